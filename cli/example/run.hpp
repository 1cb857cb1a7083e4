#pragma once
// `c3rt run` of a numerical example: in this process, without the four others.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/example/deciding.hpp"
#include "cli/progress.hpp"

namespace c3rt::cli {

struct ExampleSettings {
  std::filesystem::path file;  // of the scenario
  std::uint64_t seed = 1;
  std::vector<std::string> overrides;  // "c3.projection=plus"
  std::string out;                     // empty: out/SCENARIO-DATE
  Deciding deciding = {};
};

/// Runs all trials and writes report.json, and of the first trial trajectory.csv, trajectory.png,
/// decisions.csv and, with a trace, iterates.csv.
/// @return an exit status
/// @throws config::ConfigError, UsageError
int run_example(const ExampleSettings& settings, const Stop& stop);

}  // namespace c3rt::cli
