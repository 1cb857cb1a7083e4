#pragma once
// Runs of scenarios in lockstep, several at once, kept from call to call: what campaigns and the
// figures of section VII are made of.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "cli/campaign/engine.hpp"

namespace c3rt::cli::campaign {

using nlohmann::ordered_json;

/// What one run depends on, beside the programs.
struct RunSpec {
  std::string name;      // of its folder and on the screen: "seed-0007"
  std::string scenario;  // name or path
  std::uint64_t seed = 1;
  std::vector<std::string> overrides = {};  // "planner.rate_hz=75"
  std::optional<double> duration = {};      // [s]; nothing: the scenario's
  bool logs = false;                        // run.mcap, too
  bool pictures = false;
  bool in_process = false;  // in one process, without DDS; else with four processes
  bool example = false;     // a numerical example; run_all fills it in
};

struct RunResult {
  RunSpec spec;
  std::filesystem::path folder;
  int status = 0;       // what c3rt run exited with: kDone, kCriterionFailed or kProcessFailed
  bool kept = false;    // from an earlier call
  double wall_s = 0.0;  // how long it took when it was made
  ordered_json report;  // null for kProcessFailed
  std::string failure;  // what failed, with the end of its log
};

struct RunSettings {
  std::filesystem::path folder;  // each run has its own below it
  int at_once = cores();
  bool fresh = false;  // makes every run anew
  std::string title;   // on the line that tells how far it is
  Stop stop;
  /// Instead of run_here.
  std::function<void(const std::vector<Job>&, int at_once, const Watch&)> engine = run_here;
};

/// One result for each spec, in their order. A run is made again unless its folder holds one that
/// ended by itself, of the same scenario text, files that it names, overrides, seed, duration and
/// programs.
/// @return fewer results if a stop was wanted; what was finished is kept for the next call
/// @throws UsageError, config::ConfigError before anything is started
std::vector<RunResult> run_all(const std::vector<RunSpec>& specs, const RunSettings& settings);

/// "c3rt run circle_slow --clock lockstep --seed 7 --set planner.rate_hz=75": the same run again,
/// with logs and pictures.
std::string replay_command(const RunSpec& spec);

/// Columns of a table (sim_scene.csv), one row per sample.
/// @throws std::runtime_error naming the file and the column that is not there
std::vector<std::vector<double>> read_columns(const std::filesystem::path& file,
                                              const std::vector<std::string>& names);
/// The same of columns with texts.
std::vector<std::vector<std::string>> read_cells(const std::filesystem::path& file,
                                                 const std::vector<std::string>& names);

}  // namespace c3rt::cli::campaign
