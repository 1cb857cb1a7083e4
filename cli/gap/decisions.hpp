#pragma once
// Plans that C3 made, each with the problem (15) that it was made for.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/example/scenario.hpp"
#include "cli/progress.hpp"
#include "config/problem_file.hpp"
#include "controller/horizon/problem.hpp"

namespace c3rt::cli::gap {

struct Decision {
  double t;                   // when it was made [s]
  std::vector<lcs::Lcs> lcs;  // one for all stages, or N
  Eigen::VectorXd x0;
  Eigen::MatrixXd u;    // (n_u × N) the plan, within its bounds; no column where there is no plan
  double solve_time_s;  // of a core
  Eigen::MatrixXd x_desired;  // (n_x × N+1)
  std::size_t costs = 0;      // which of them
};

/// What another planner decides in the same place.
struct Answer {
  Eigen::MatrixXd u;    // as of a Decision
  double solve_time_s;  // of a core
};

/// What its decisions have in common.
struct Decisions {
  std::string name;
  c3::Sizes sizes;
  std::vector<c3::Costs> costs;
  c3::Constraints constraints;
  std::vector<Decision> all;

  /// @param index of the decision; this outlives the problem
  horizon::Problem problem(std::size_t index) const;
  /// What follows from inputs by the planning system itself, with its cost (14); nothing where
  /// that cannot be said. It need not meet the constraints.
  /// @param u (n_u × N), or no column where there is no plan
  std::optional<horizon::Plan> simulated(std::size_t index, const Eigen::MatrixXd& u) const;
};

/// Of Algorithm 1 on a problem file, whatever method the file names.
Decisions of_problem(const config::ProblemFile& problem, const std::string& name);

/// Of the first `count` control steps of an example's first trial.
/// @return fewer where the trial ends before, or a stop is wanted
Decisions of_example(const ExampleScenario& scenario, std::uint64_t seed, int count,
                     const Stop& stop);

/// What C3 with the settings of `planner` decides at these decisions' states, one after the other.
/// @param scenario whose decisions they are
/// @throws UsageError where its plans would have other sizes or another step
std::vector<Answer> answers(const Decisions& decisions, const ExampleScenario& scenario,
                            const ExampleScenario& planner);

}  // namespace c3rt::cli::gap
