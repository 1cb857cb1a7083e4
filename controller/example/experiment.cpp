#include "controller/example/experiment.hpp"

#include <algorithm>

#include "controller/base/random.hpp"

namespace c3rt::example {
namespace {

/// Added to the γ rows of the gaiting fingers, which without normal force would ask 0 ≥ friction.
constexpr double kFingerRegularisation = 1e-4;
constexpr double kPivotingRegularisation = 1e-12;

lcs::Lcs system_of(const Model& model, const Eigen::VectorXd& x, double dt) {
  struct Build {
    const Eigen::VectorXd& x;
    double dt;
    lcs::Lcs operator()(const model::CartPoleParameters& p) const {
      return model::cart_pole(p, dt);
    }
    lcs::Lcs operator()(const model::FingerGaitingParameters& p) const {
      return model::finger_gaiting(p, dt);
    }
    lcs::Lcs operator()(const model::PivotingParameters& p) const {
      return model::pivoting(p, x, dt);
    }
  };
  return std::visit(Build{x, dt}, model);
}

}  // namespace

c3::Sizes sizes(const Experiment& experiment) {
  const lcs::Sizes of = lcs::sizes(planning_system(experiment, experiment.x0));
  return {of.n_x, of.n_lambda, of.n_u, experiment.N};
}

lcs::Lcs planning_system(const Experiment& experiment, const Eigen::VectorXd& x) {
  return system_of(experiment.model, x, experiment.planning_step);
}

lcs::Lcs simulation_system(const Experiment& experiment, const Eigen::VectorXd& x) {
  lcs::Lcs lcs = system_of(experiment.plant, x, experiment.simulation_step);
  if (std::holds_alternative<model::FingerGaitingParameters>(experiment.plant)) {
    using L = model::FingerGaitingLayout;
    lcs.c[L::gamma_1] += kFingerRegularisation;
    lcs.c[L::gamma_2] += kFingerRegularisation;
  } else if (std::holds_alternative<model::PivotingParameters>(experiment.plant)) {
    lcs.F.diagonal().array() += kPivotingRegularisation;
  }
  return lcs;
}

void clip(const Experiment& experiment, Eigen::Ref<Eigen::VectorXd> u) {
  if (std::holds_alternative<model::CartPoleParameters>(experiment.plant)) return;
  // both examples with fingers have their normal forces at the same places
  static_assert(model::FingerGaitingLayout::normal_1 == model::PivotingLayout::normal_1 &&
                model::FingerGaitingLayout::normal_2 == model::PivotingLayout::normal_2);
  using L = model::PivotingLayout;
  u[L::normal_1] = std::max(u[L::normal_1], 0.0);
  u[L::normal_2] = std::max(u[L::normal_2], 0.0);
}

double stage_cost(const Experiment& experiment, const Eigen::VectorXd& x,
                  const Eigen::VectorXd& u) {
  const Eigen::VectorXd e = x - experiment.x_desired;
  return e.dot(experiment.costs.Q[0] * e) + u.dot(experiment.costs.R[0] * u);
}

Eigen::VectorXd start_of_trial(const Experiment& experiment, std::uint64_t seed, int trial) {
  Eigen::VectorXd x = experiment.x0;
  base::Random random(seed * 1000003u + static_cast<std::uint64_t>(trial));
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double low = experiment.x0_spread_min[i], high = experiment.x0_spread_max[i];
    x[i] += low + random.uniform() * (high - low);
  }
  return x;
}

}  // namespace c3rt::example
