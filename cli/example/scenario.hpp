#pragma once
// The scenarios of the numerical examples: they run in this process.
#include <filesystem>
#include <string>
#include <vector>

#include "cli/report/metrics.hpp"
#include "controller/example/experiment.hpp"

namespace c3rt::cli {

struct ExampleScenario {
  std::string name, description;
  std::vector<Limit> criteria;
  example::Experiment experiment;
};

/// Whether the file describes a numerical example, not the four processes.
/// @throws config::ConfigError if it cannot be read
bool is_example(const std::filesystem::path& file);

/// @throws config::ConfigError naming file, line, key and what was expected
ExampleScenario load_example(const std::filesystem::path& file,
                             const std::vector<std::string>& overrides = {});

}  // namespace c3rt::cli
