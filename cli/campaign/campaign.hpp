#pragma once
// `c3rt campaign`: one scenario, many seeds, one table.
#include <optional>
#include <string>
#include <vector>

#include "cli/progress.hpp"

namespace c3rt::cli::campaign {

struct Settings {
  std::string scenario;                // name or path
  std::string seeds = "1..20";         // parse_seeds()
  std::vector<std::string> overrides;  // "planner.rate_hz=75"
  std::optional<double> duration;      // [s]; nothing: the scenario's
  int at_once = 0;                     // runs; 0: as many as there are cores
  std::string out;                     // empty: out/campaign-SCENARIO
  bool fresh = false;
  bool logs = false, pictures = false;
  bool in_process = false;       // each run in one process
  std::string engine = "local";  // or "dask"
  std::string address;           // of Dask's scheduler; empty: a cluster of its own on this machine
};

/// Prints the table and writes campaign.json and campaign.md; each run is in OUT/seed-NNNN.
/// @return an exit status: kDone if every run met its criteria, kCriterionFailed if one did not or
/// it was interrupted, kProcessFailed if a process failed
/// @throws UsageError, config::ConfigError before anything is started
int run(const Settings& settings, const Stop& stop);

}  // namespace c3rt::cli::campaign
