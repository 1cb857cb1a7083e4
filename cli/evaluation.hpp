#pragma once
// The Python package c3rt.evaluation, which makes many runs: campaigns, searches, tables and
// figures.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace c3rt::cli {

/// How runs are made, as a person says it: the same words for every command that makes many.
struct EngineSettings {
  std::optional<double> duration;  // of each run [s]; nothing: the scenario's
  int at_once = 0;                 // runs; 0: as many as there are cores
  bool fresh = false;
  std::string engine = "local";  // or "dask"
  std::string address;           // of Dask's scheduler; empty: a cluster of its own on this machine
};

/// One scenario, many seeds, one table.
struct CampaignSettings : EngineSettings {
  std::string scenario;                // name or path
  std::string seeds = "1..20";         // or "1,5,9..12"
  std::vector<std::string> overrides;  // "planner.rate_hz=75"
  std::string out;                     // empty: out/campaign-SCENARIO
  bool logs = false, pictures = false;
  bool in_process = false;  // each run in one process
};

/// Numbers of a scenario, found by CMA-ES over runs, judged on other seeds.
struct TuneSettings : EngineSettings {
  std::string scenario;                         // name or path
  std::vector<std::string> overrides;           // where it begins: "planner.rate_hz=75"
  std::vector<std::string> search_overrides;    // beside these, in the generations alone
  std::vector<std::string> linear, log, whole;  // "planner.admm.rho=0.1..10"
  std::string minimise, maximise;               // one of them: a figure of report.json
  std::string seeds = "101..104", final_seeds = "201..210", test_seeds = "1..10";
  int finalists = 4;  // the best candidates, judged once more on the final seeds; 1: no final
  int generations = 20;
  int population = 0;  // 0: 4 + 3 ln(numbers)
  double sigma = 0.2;  // of each range
  std::uint32_t seed = 1;
  std::string out;  // empty: out/tune-SCENARIO
};

/// Tables and figures of the paper, our numbers beside its own.
struct ReproduceSettings {
  std::string what;            // of reproduced()
  std::string out;             // empty: out/reproduce
  bool quick = false;          // short runs: for a look, not for numbers
  bool fresh = false;          // makes every run anew
  std::string seeds = "1..5";  // of comparison and push_anything
  double miqp_limit = 15.0;    // of one monolithic MIQP [s]
};
/// Their names, as the package has them.
const std::vector<std::string>& reproduced();

/// Become the package's programs, whose exit status is the command's.
/// @throws UsageError where there is no Python that has what they need
[[noreturn]] void campaign(const CampaignSettings& settings);
[[noreturn]] void tune(const TuneSettings& settings);
[[noreturn]] void reproduce(const ReproduceSettings& settings);

}  // namespace c3rt::cli
