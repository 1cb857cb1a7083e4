#pragma once
// All trials of an experiment, and what they amount to.
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "cli/example/deciding.hpp"
#include "cli/example/exact.hpp"
#include "cli/example/scenario.hpp"
#include "cli/example/traced.hpp"
#include "cli/progress.hpp"
#include "controller/example/closed_loop.hpp"

namespace c3rt::cli {

struct Trial {
  bool succeeded;
  double accumulated_cost;   // of the whole trial, as in Tables I and II
  double mean_cost_to_go;    // of the plans that could be rolled out; kNone where none could
  int plans_not_rolled_out;  // their LCP had no solution
  int controller_failures;
  bool plant_failed;
  double overshoot;  // how far a simulated state went beyond the limits of C, 0: nowhere
  Eigen::VectorXd final_state;
};

Trial summarise(const example::Experiment& experiment, const example::Trajectory& trajectory);

struct TrialsResult {
  std::vector<Trial> trials;                 // that were finished
  example::Trajectory first;                 // of the first trial, also where it was interrupted
  std::vector<double> solve_times;           // [s]
  std::vector<ExactDecision> exact;          // of the exact search
  std::vector<ProjectionTimes> projections;  // these of a trace
  std::vector<c3::Iterate> first_iterates;
  lcs::Lcs first_system;
  bool interrupted = false;
};

/// Runs the trials one after the other.
TrialsResult run_trials(const ExampleScenario& scenario, std::uint64_t seed, const Stop& stop,
                        const Deciding& deciding = {});

struct ExampleReport {
  std::string scenario;
  std::uint64_t seed = 0;
  std::string result;  // "passed", "criteria not met", "interrupted"
  int trials_wanted = 0;
  std::vector<Trial> trials;
  double success_rate = kNone;      // of the trials that were finished
  double mean_cost_to_go = kNone;   // mean over the trials
  double accumulated_cost = kNone;  // mean over the trials
  Spread solve_time;                // [s]
  std::size_t solves = 0;
  std::size_t exact = 0, proven = 0;  // of the exact search: decisions, those that it proved
  std::vector<CriterionResult> criteria;
};

ExampleReport report_on(const ExampleScenario& scenario, std::uint64_t seed,
                        const TrialsResult& result);

/// SI units; what the run did not give is null.
nlohmann::ordered_json to_json(const ExampleReport& report);

/// The report for a person: some lines for the terminal.
std::string summary(const ExampleReport& report);

}  // namespace c3rt::cli
