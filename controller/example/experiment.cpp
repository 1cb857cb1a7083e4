#include "controller/example/experiment.hpp"

#include "controller/base/random.hpp"

namespace c3rt::example {
c3::Sizes sizes(const Experiment& experiment) {
  const model::SystemLayout& layout = experiment.model->layout();
  return {layout.n_x(), layout.n_lambda(), layout.n_u(), experiment.N};
}

lcs::Lcs planning_system(const Experiment& experiment, const Eigen::VectorXd& x) {
  return experiment.model->planning_system(x, experiment.planning_step);
}

lcs::Lcs simulation_system(const Experiment& experiment, const Eigen::VectorXd& x) {
  return experiment.plant->simulation_system(x, experiment.simulation_step);
}

void clip(const Experiment& experiment, Eigen::Ref<Eigen::VectorXd> u) {
  experiment.plant->clip(u);
}

double stage_cost(const Experiment& experiment, const Eigen::VectorXd& x,
                  const Eigen::VectorXd& u) {
  const Eigen::VectorXd e = x - experiment.x_desired;
  return e.dot(experiment.costs.Q[0] * e) + u.dot(experiment.costs.R[0] * u);
}

Eigen::VectorXd start_of_trial(const Experiment& experiment, std::uint64_t seed, int trial) {
  Eigen::VectorXd x = experiment.x0;
  base::Random random(seed * 1000003U + static_cast<std::uint64_t>(trial));
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double low = experiment.x0_spread_min[i], high = experiment.x0_spread_max[i];
    x[i] += low + random.uniform() * (high - low);
  }
  return x;
}

}  // namespace c3rt::example
