#pragma once
// The numerical examples of section VI as closed loops: which system, how it is controlled, what
// disturbs it and when it has succeeded.
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "controller/c3/solver.hpp"
#include "controller/model/system_model.hpp"

namespace c3rt::example {

using Model = std::shared_ptr<const model::SystemModel>;

/// Where Algorithm 1 starts at a control step.
enum class StartPolicy {
  kFresh,          // δ⁰ and w⁰ of the settings
  kCarriedForces,  // δ⁰ = [x; λ and u of the last δ], w⁰ = 0, as the published pivoting code does
  kShifted,        // the last solution one stage on
};

/// A force on top of the first input for a while, drawn uniformly.
struct Disturbance {
  double start, duration;  // [s]; no disturbance where the duration is 0
  double min, max;         // [unit of the input]
};

struct Experiment {
  Model model;        // what the controller plans with
  Model plant;        // what is simulated
  bool mujoco_plant;  // the nonlinear cart-pole or mechanism in place of the plant's LCS
  int N;
  double planning_step;    // Δt of the planning LCS [s]
  double control_period;   // the input is held this long [s]
  double simulation_step;  // Δt of the plant's LCS [s]
  double duration;         // [s]
  Eigen::VectorXd x0, x_desired;
  /// Trials start at x0 plus a uniform draw between these.
  Eigen::VectorXd x0_spread_min, x0_spread_max;
  int trials;
  /// σ: every state gets σ Δt N(0, 1) at each simulation step.
  double noise;
  Disturbance disturbance;
  /// The last state lies between these, ±infinity where it may be anything.
  Eigen::VectorXd success_min, success_max;
  c3::Settings c3;
  c3::Costs costs;
  c3::Constraints constraints;
  StartPolicy start;
  double start_reset_period;  // kCarriedForces starts fresh this often [s]
};

/// x, λ and u of the experiment's model.
c3::Sizes sizes(const Experiment& experiment);

/// The LCS that the controller plans with, about x.
lcs::Lcs planning_system(const Experiment& experiment, const Eigen::VectorXd& x);

/// The LCS of one simulation step about x, with the small regularisation that the published
/// simulations have where the LCP would be unsolvable at zero normal force.
lcs::Lcs simulation_system(const Experiment& experiment, const Eigen::VectorXd& x);

/// What the inputs can be: fingers do not pull.
void clip(const Experiment& experiment, Eigen::Ref<Eigen::VectorXd> u);

/// The cost of a state and an input, the summand of the accumulated cost of Tables I and II.
double stage_cost(const Experiment& experiment, const Eigen::VectorXd& x, const Eigen::VectorXd& u);

/// Where trial `trial` starts, the same for every controller.
Eigen::VectorXd start_of_trial(const Experiment& experiment, std::uint64_t seed, int trial);

}  // namespace c3rt::example
