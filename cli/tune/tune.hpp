#pragma once
// `c3rt tune`: numbers of a scenario, found by CMA-ES over runs, judged on other seeds.
#include <cstdint>
#include <string>
#include <vector>

#include "cli/campaign/engine_settings.hpp"
#include "cli/progress.hpp"

namespace c3rt::cli::tune {

struct Settings : campaign::EngineSettings {
  std::string scenario;                         // name or path
  std::vector<std::string> overrides;           // where it begins: "planner.rate_hz=75"
  std::vector<std::string> linear, log, whole;  // "planner.admm.rho=0.1..10"
  std::string minimise, maximise;               // one of them: a figure of report.json
  std::string seeds = "101..104", test_seeds = "1..10";
  int generations = 20;
  int population = 0;  // 0: usual_population()
  double sigma = 0.2;  // of each range
  std::uint32_t seed = 1;
  std::string out;  // empty: out/tune-SCENARIO
};

/// Leaves SCENARIO_tuned.yaml, tune.json and tune.md in its folder, and every run; the same call
/// goes on where an earlier one was ended.
/// @return kDone where what was found is at least as good as the start on the test seeds,
/// kCriterionFailed where it is not, or it was interrupted, kProcessFailed where no run of the
/// start ended well
/// @throws UsageError, config::ConfigError before anything is started
int run(const Settings& settings, const Stop& stop);

}  // namespace c3rt::cli::tune
