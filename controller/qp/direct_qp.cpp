#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "controller/qp/qp.hpp"
#include "controller/qp/qp_cost.hpp"
#include "controller/qp/riccati.hpp"

namespace c3rt::qp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxRefinements = 4;
constexpr double kConverged = 1e-13;  // estimated error beside the largest entry of its kind
constexpr double kAcceptable = 1e-6;  // gradient beside its largest term; worse: not solved
constexpr double kSettled =
    1e-7;  // what the next refinement would change of its kind; more: not solved
constexpr double kConsistent = 1e-9;  // the same for what the states miss the dynamics by

/// One Newton step is the solution; the same step again refines it.
class DirectQp final : public QpStep {
 public:
  explicit DirectQp(const Sizes& sizes)
      : sizes_(sizes),
        cost_(sizes),
        riccati_(sizes),
        gradient_(sizes.n_z(), sizes.N),
        step_(sizes.n_z(), sizes.N),
        defect_(sizes.n_x, sizes.N),
        gradient_N_(sizes.n_x),
        step_N_(sizes.n_x) {}

  void set_costs(const Costs& costs, const Constraints& constraints) override {
    if (any(constraints)) {
      throw std::invalid_argument(
          "Constraints: expected none with the direct QP, got some: use the interior point or "
          "OSQP");
    }
    cost_.set_costs(costs);
  }

  void start(Horizon lcs, StageMatrices W, const VectorXd* lambda_0) noexcept override {
    cost_.start(W);
    riccati_.start(lcs, lambda_0 != nullptr);
    lambda_0_ = lambda_0;
    started_ = factored_ = false;
  }

  QpReport solve(double rho, const Eigen::Ref<const VectorXd>& x0,
                 const Eigen::Ref<const MatrixXd>& x_desired, const Eigen::Ref<const MatrixXd>& g,
                 Eigen::Ref<MatrixXd> z, Eigen::Ref<VectorXd> x_N) noexcept override {
    if (rho != cost_.rho() || !factored_) {
      cost_.build_hessian(rho);
      factored_ = riccati_.factor(cost_.H(), cost_.H_N());
      if (!factored_) {
        const double none = std::numeric_limits<double>::infinity();
        return {QpStatus::kNotFactorable, 0, none, none};
      }
    }
    cost_.set_linear_term(x_desired, g);
    if (!started_) {
      z.setZero();
      x_N.setZero();
    }
    started_ = true;
    sizes_.x(z.col(0)) = x0;
    if (lambda_0_ != nullptr) sizes_.lambda(z.col(0)) = *lambda_0_;
    riccati_.defects(z, x_N, defect_);
    cost_.gradient(z, x_N, gradient_, gradient_N_);
    double change = 0.0, next_change = 0.0;
    int refinements = -1;  // the first step is the solution, those after it refine
    while (refinements < kMaxRefinements) {
      riccati_.step(gradient_, gradient_N_, defect_, step_, step_N_);
      z += step_;
      x_N += step_N_;
      riccati_.defects(z, x_N, defect_);
      cost_.gradient(z, x_N, gradient_, gradient_N_);
      ++refinements;
      const double previous = change;
      change = riccati_.relative_step(step_, z);
      if (refinements == 0) continue;
      // a step shrinks the error by about as much as the steps shrink
      next_change = change < previous ? change * (change / previous) : change;
      if (change * change <= kConverged * previous || !(change <= 0.25 * previous)) break;
    }
    const Riccati::Stationarity found = riccati_.stationarity(gradient_, gradient_N_, z);
    const double primal = riccati_.relative_defect(z, x_N, defect_);
    const double dual =
        relative(found, cost_.terms(gradient_, gradient_N_), riccati_.largest_gain());
    QpStatus status = QpStatus::kNotConverged;
    // a NaN anywhere must not look solved
    if (primal <= kConsistent && dual <= kAcceptable && next_change <= kSettled) {
      status = QpStatus::kSolved;
    }
    if (!found.is_known) status = QpStatus::kNotFactorable;
    if (status != QpStatus::kSolved && !(z.allFinite() && x_N.allFinite())) {
      status = QpStatus::kNotFactorable;
    }
    return {status, refinements, primal, dual};
  }

 private:
  Sizes sizes_;
  QpCost cost_;
  Riccati riccati_;
  const VectorXd* lambda_0_ = nullptr;
  bool started_ = false, factored_ = false;
  MatrixXd gradient_, step_;      // in z
  MatrixXd defect_;               // (n_x × N)
  VectorXd gradient_N_, step_N_;  // in x_N
};

}  // namespace

std::unique_ptr<QpStep> make_direct_qp(const Sizes& sizes) {
  return std::make_unique<DirectQp>(sizes);
}

}  // namespace c3rt::qp
