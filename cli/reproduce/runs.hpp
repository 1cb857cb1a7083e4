#pragma once
// Runs of scenarios in lockstep, several at once, kept from call to call: what the figures of
// section VII are made of. The Python package makes them (c3rt.evaluation).
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "cli/progress.hpp"

namespace c3rt::cli::reproduce {

using nlohmann::ordered_json;

/// One scenario with one seed or several.
struct RunSpec {
  std::string name;                         // of its folder; of several seeds NAME-0007
  std::string scenario;                     // name or path
  std::string seeds = {};                   // "1..20"; empty: the first alone
  std::vector<std::string> overrides = {};  // "planner.rate_hz=75"
  std::optional<double> duration = {};      // [s]; nothing: the scenario's
  bool logs = false;                        // run.mcap, too
  bool in_process = false;                  // in one process, without DDS; else with four processes
};

struct Run {
  RunSpec spec;
  std::filesystem::path folder;
  ordered_json report;
  std::string command;  // that makes it again
};

/// The runs of one spec, by seed.
struct RunGroup {
  std::vector<Run> runs;
  ordered_json summary;  // what campaign.json says of them
};

struct RunSettings {
  std::filesystem::path folder;  // each run has its own below it
  std::string title;             // on the line that tells how far it is
  bool fresh = false;            // makes every run anew
  Stop stop;
};

/// Thrown where a person's wish to end is noticed.
struct Interrupted {};
/// Thrown where the runs could not be made, which has been said.
struct NoRuns {
  int status;  // to exit with
};

/// One group for each spec, in their order; what an earlier call with the same scenario, settings
/// and programs finished is kept. @throws Interrupted, NoRuns, UsageError if there is no Python
std::vector<RunGroup> run_all(const std::vector<RunSpec>& specs, const RunSettings& settings);

/// Columns of a table (sim_scene.csv), one row per sample.
/// @throws std::runtime_error naming the file and the column that is not there
std::vector<std::vector<double>> read_columns(const std::filesystem::path& file,
                                              const std::vector<std::string>& names);
/// The same of columns with texts.
std::vector<std::vector<std::string>> read_cells(const std::filesystem::path& file,
                                                 const std::vector<std::string>& names);

}  // namespace c3rt::cli::reproduce
