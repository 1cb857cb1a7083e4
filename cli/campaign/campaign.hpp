#pragma once
// `c3rt campaign`: one scenario, many seeds, one table.
#include <string>
#include <vector>

#include "cli/campaign/engine_settings.hpp"
#include "cli/progress.hpp"

namespace c3rt::cli::campaign {

struct Settings : EngineSettings {
  std::string scenario;                // name or path
  std::string seeds = "1..20";         // parse_seeds()
  std::vector<std::string> overrides;  // "planner.rate_hz=75"
  std::string out;                     // empty: out/campaign-SCENARIO
  bool logs = false, pictures = false;
  bool in_process = false;  // each run in one process
};

/// Prints the table and writes campaign.json and campaign.md; each run is in OUT/seed-NNNN.
/// @return an exit status: kDone if every run met its criteria, kCriterionFailed if one did not or
/// it was interrupted, kProcessFailed if a process failed
/// @throws UsageError, config::ConfigError before anything is started
int run(const Settings& settings, const Stop& stop);

}  // namespace c3rt::cli::campaign
