#include "controller/horizon/problem.hpp"

#include <algorithm>

namespace c3rt::horizon {

Plan roll_out(const Problem& problem, const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& u) {
  const c3::Sizes& sizes = problem.sizes;
  Plan plan{Eigen::MatrixXd(sizes.n_x, sizes.N + 1), lambda, u};
  plan.x.col(0) = problem.x0;
  for (int k = 0; k < sizes.N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    const auto x = plan.x.col(k);
    const auto force = lambda.col(k), input = u.col(k);
    const Eigen::VectorXd gap = lcs.E * x + lcs.F * force + lcs.H * input + lcs.c;
    const double violation = force.cwiseMin(gap).cwiseAbs().maxCoeff();
    plan.complementarity_violation = std::max(plan.complementarity_violation, violation);
    const Eigen::VectorXd error = x - problem.x_desired.col(k);
    plan.objective +=
        error.dot(problem.costs->Q[k] * error) + input.dot(problem.costs->R[k] * input);
    plan.x.col(k + 1) = lcs.A * x + lcs.B * input + lcs.D * force + lcs.d;
  }
  const Eigen::VectorXd error = plan.x.col(sizes.N) - problem.x_desired.col(sizes.N);
  plan.objective += error.dot(problem.costs->Q_N * error);
  return plan;
}

}  // namespace c3rt::horizon
