#include "controller/horizon/problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/qp/bound.hpp"

namespace c3rt::horizon {

Eigen::VectorXd next_state(const Problem& problem, const Plan& plan, int k) {
  const lcs::Lcs& lcs = problem.systems[k];
  return lcs.A * plan.x.col(k) + lcs.B * plan.u.col(k) + lcs.D * plan.lambda.col(k) + lcs.d;
}

void evaluate(const Problem& problem, Plan& plan) {
  const c3::Sizes& sizes = problem.sizes;
  plan.objective = plan.complementarity_violation = 0.0;
  for (int k = 0; k < sizes.N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    const auto x = plan.x.col(k), force = plan.lambda.col(k), input = plan.u.col(k);
    const Eigen::VectorXd gap = lcs.E * x + lcs.F * force + lcs.H * input + lcs.c;
    for (int j = 0; j < sizes.n_lambda; ++j) {
      plan.complementarity_violation =
          std::max(plan.complementarity_violation, std::abs(std::min(force[j], gap[j])));
    }
    const Eigen::VectorXd error = x - problem.x_desired.col(k);
    plan.objective +=
        error.dot(problem.costs->Q[k] * error) + input.dot(problem.costs->R[k] * input);
  }
  const Eigen::VectorXd error = plan.x.col(sizes.N) - problem.x_desired.col(sizes.N);
  plan.objective += error.dot(problem.costs->Q_N * error);
}

Plan roll_out(const Problem& problem, const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& u) {
  Plan plan{Eigen::MatrixXd(problem.sizes.n_x, problem.sizes.N + 1), lambda, u};
  plan.x.col(0) = problem.x0;
  for (int k = 0; k < problem.sizes.N; ++k) plan.x.col(k + 1) = next_state(problem, plan, k);
  evaluate(problem, plan);
  return plan;
}

namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kOfOthers = 1e-5;  // an entry that stays at zero is not more exact than this

/// Largest violation so far, each in relation to the terms of its row.
class Worst {
 public:
  void at_least_zero(double value, double terms) {
    if (!(value >= 0.0)) zero(value, terms);
  }
  void zero(double value, double terms) {
    const double ratio = value == 0.0 ? 0.0 : std::abs(value) / terms;
    worst_ = std::isnan(ratio) ? kNone : std::max(worst_, ratio);
  }
  void within(double value, double terms, double minimum, double maximum) {
    if (minimum > -kNone) at_least_zero(value - minimum, terms + std::abs(minimum));
    if (maximum < kNone) at_least_zero(maximum - value, terms + std::abs(maximum));
  }
  /// An empty bound is none.
  void within(const Eigen::VectorXd& value, const Eigen::VectorXd& terms,
              const Eigen::VectorXd& minimum, const Eigen::VectorXd& maximum) {
    for (Eigen::Index i = 0; i < value.size(); ++i) {
      within(value[i], terms[i], qp::bound_at(minimum, i, -kNone), qp::bound_at(maximum, i, kNone));
    }
  }
  double value() const { return worst_; }

 private:
  double worst_ = 0.0;
};

}  // namespace

double residual(const Problem& problem, const Plan& plan) {
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const c3::Constraints& constraints = *problem.constraints;
  // what each entry is rounded to: its largest value, and a little of the largest of its kind
  const auto sizes = [](const Eigen::MatrixXd& values) -> Eigen::VectorXd {
    if (values.size() == 0) return Eigen::VectorXd::Zero(values.rows());
    return values.cwiseAbs().rowwise().maxCoeff().array() +
           kOfOthers * values.cwiseAbs().maxCoeff();
  };
  const Eigen::VectorXd force_sizes = sizes(plan.lambda), input_sizes = sizes(plan.u);
  Eigen::VectorXd x_sizes = plan.x.cwiseAbs().rowwise().maxCoeff();
  for (int k = 0; k < N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    x_sizes = x_sizes.cwiseMax(lcs.B.cwiseAbs() * input_sizes + lcs.D.cwiseAbs() * force_sizes +
                               lcs.d.cwiseAbs());
  }
  Worst worst;
  for (int k = 0; k < N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    const Eigen::VectorXd x = plan.x.col(k), force = plan.lambda.col(k), input = plan.u.col(k);
    const Eigen::VectorXd gap = lcs.E * x + lcs.F * force + lcs.H * input + lcs.c;
    const Eigen::VectorXd gap_sizes = lcs.E.cwiseAbs() * x_sizes + lcs.F.cwiseAbs() * force_sizes +
                                      lcs.H.cwiseAbs() * input_sizes + lcs.c.cwiseAbs();
    for (int j = 0; j < n_lambda; ++j) {
      worst.at_least_zero(force[j], force_sizes[j]);
      worst.at_least_zero(gap[j], gap_sizes[j]);
      if (force[j] > 0.0 && gap[j] > 0.0)
        worst.zero(std::min(force[j] / force_sizes[j], gap[j] / gap_sizes[j]), 1.0);
    }
    if (k > 0) worst.within(x, x_sizes, constraints.x_min[k], constraints.x_max[k]);
    worst.within(force, force_sizes, constraints.lambda_min[k], constraints.lambda_max[k]);
    worst.within(input, input_sizes, constraints.u_min[k], constraints.u_max[k]);
    Eigen::VectorXd z(problem.sizes.n_z()), z_sizes(problem.sizes.n_z());
    z << x, force, input;
    z_sizes << x_sizes, force_sizes, input_sizes;
    const Eigen::MatrixXd& C = constraints.C[k];
    for (Eigen::Index i = 0; i < C.rows(); ++i) {
      if (k == 0 && C.row(i).tail(n_lambda + n_u).isZero(0.0)) continue;
      worst.within(C.row(i).dot(z), C.row(i).cwiseAbs().dot(z_sizes),
                   qp::bound_at(constraints.C_min[k], i, -kNone),
                   qp::bound_at(constraints.C_max[k], i, kNone));
    }
    const Eigen::VectorXd missed = plan.x.col(k + 1) - next_state(problem, plan, k);
    const Eigen::VectorXd next_sizes =
        lcs.A.cwiseAbs() * x.cwiseAbs() + lcs.B.cwiseAbs() * input.cwiseAbs() +
        lcs.D.cwiseAbs() * force.cwiseAbs() + lcs.d.cwiseAbs() + plan.x.col(k + 1).cwiseAbs();
    for (int i = 0; i < n_x; ++i) worst.zero(missed[i], next_sizes[i]);
  }
  worst.within(plan.x.col(N), x_sizes, constraints.x_N_min, constraints.x_N_max);
  return worst.value();
}

}  // namespace c3rt::horizon
