#pragma once
// `c3rt run` of a numerical example: in this process, without the four others.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/progress.hpp"

namespace c3rt::cli {

struct ExampleSettings {
  std::filesystem::path file;  // of the scenario
  std::uint64_t seed = 1;
  std::vector<std::string> overrides;  // "c3.projection=plus"
  std::string out;                     // empty: out/SCENARIO-DATE
};

/// Runs all trials and writes report.json, trajectory.csv and trajectory.png (of the first trial).
/// @return an exit status
/// @throws config::ConfigError, UsageError
int run_example(const ExampleSettings& settings, const Stop& stop);

}  // namespace c3rt::cli
