#include "controller/example/closed_loop.hpp"

#include <cmath>
#include <limits>

#include "controller/base/random.hpp"
#include "controller/lcs/simulate.hpp"
#include "controller/lcs/step.hpp"

namespace c3rt::example {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Every trial of every seed has its own numbers.
base::Random trial_random(std::uint64_t seed, int trial) {
  return base::Random(seed * 7919U + 104729U * static_cast<std::uint64_t>(trial) + 1U);
}

}  // namespace

LcsPlant::LcsPlant(const Experiment& experiment)
    : experiment_(experiment), lemke_(sizes(experiment).n_lambda) {}

void LcsPlant::reset(const VectorXd& x) { x_ = x; }

bool LcsPlant::step(const VectorXd& u, VectorXd& x, VectorXd& lambda) {
  const lcs::Lcs lcs = simulation_system(experiment_, x);
  x_ = x;
  return lcs::step(lcs, x_, u, lemke_, x, lambda).ok();
}

double cost_to_go(const Experiment& experiment, const lcs::Lcs& lcs, const VectorXd& x,
                  const MatrixXd& u) {
  const lcs::Simulation simulation = lcs::simulate(lcs, x, u);
  if (!simulation.report.ok()) return std::numeric_limits<double>::quiet_NaN();
  double cost = 0.0;
  for (Eigen::Index k = 0; k < u.cols(); ++k) {
    cost += stage_cost(experiment, simulation.x.col(k), u.col(k));
  }
  const VectorXd e = simulation.x.col(u.cols()) - experiment.x_desired;
  return cost + e.dot(experiment.costs.Q_N * e);
}

Trajectory run(const Experiment& experiment, std::uint64_t seed, int trial, Controller& controller,
               Plant& plant, Observer* observer) {
  const c3::Sizes s = sizes(experiment);
  const auto steps =
      static_cast<Eigen::Index>(std::llround(experiment.duration / experiment.simulation_step));
  const auto held = static_cast<Eigen::Index>(
      std::llround(experiment.control_period / experiment.simulation_step));
  base::Random random = trial_random(seed, trial);
  const Disturbance& disturbance = experiment.disturbance;
  const double unit = random.uniform() + 0x1p-54;  // never an end
  const double push = disturbance.min + unit * (disturbance.max - disturbance.min);

  Trajectory out;
  out.x.resize(s.n_x, steps + 1);
  out.u.resize(s.n_u, steps);
  out.lambda.resize(s.n_lambda, steps);
  out.cost = VectorXd::Zero(steps + 1);
  out.cost_to_go = VectorXd::Zero((steps + held - 1) / held);
  VectorXd x = start_of_trial(experiment, seed, trial);
  VectorXd u = VectorXd::Zero(s.n_u), applied = u, lambda = VectorXd::Zero(s.n_lambda);
  out.x.col(0) = x;
  controller.reset();
  plant.reset(x);
  Eigen::Index step = 0, decisions = 0;
  for (; step < steps; ++step) {
    const double t = static_cast<double>(step) * experiment.simulation_step;
    if (step % held == 0) {
      if (observer != nullptr && !observer->go_on(t)) {
        out.stopped = true;
        break;
      }
      const lcs::Lcs lcs = planning_system(experiment, x);
      if (const MatrixXd* plan = controller.decide(lcs, x, t); plan != nullptr) {
        u = plan->col(0);
        clip(experiment, u);
        out.cost_to_go[decisions] = cost_to_go(experiment, lcs, x, *plan);
      } else {
        ++out.controller_failures;
        out.cost_to_go[decisions] = std::numeric_limits<double>::quiet_NaN();
      }
      ++decisions;
    }
    out.u.col(step) = u;
    out.cost[step + 1] = out.cost[step] + stage_cost(experiment, x, u);
    applied = u;
    if (t >= disturbance.start && t < disturbance.start + disturbance.duration) applied[0] += push;
    if (!plant.step(applied, x, lambda) || !x.allFinite()) {
      out.plant_failed = true;
      break;
    }
    if (experiment.noise > 0.0) {
      for (double& value : x)
        value += experiment.noise * experiment.simulation_step * random.normal();
    }
    out.lambda.col(step) = lambda;
    out.x.col(step + 1) = x;
  }
  out.x.conservativeResize(Eigen::NoChange, step + 1);
  out.u.conservativeResize(Eigen::NoChange, step);
  out.lambda.conservativeResize(Eigen::NoChange, step);
  out.cost.conservativeResize(step + 1);
  out.cost_to_go.conservativeResize(decisions);
  out.succeeded = !out.plant_failed && !out.stopped &&
                  (x.array() >= experiment.success_min.array()).all() &&
                  (x.array() <= experiment.success_max.array()).all();
  return out;
}

}  // namespace c3rt::example
