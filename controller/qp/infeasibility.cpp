#include "controller/qp/infeasibility.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::qp {
namespace {

using Eigen::VectorXd;

constexpr double kFar = 1e7;   // so many times beyond the point no solution is sought
constexpr double kMet = 1e-8;  // violation of rows, beside their terms, that counts as none
constexpr double kViolatedStiffness =
    1e7;                           // of violated rows, beside that of the problem against them
constexpr double kDescent = 1e-4;  // least share of the descent that the slope promises [Armijo]
constexpr double kFlat = 1e-13;    // of the sum of squares: what it may rise by where it is flat
constexpr int kMaxSteps = 60;
constexpr int kMaxHalvings = 20;  // of one step

/// Σ (violation)²/inverse_hessian.
double squares(const QpModel& model, const VectorXd& inverse_hessian) noexcept {
  double sum = 0.0;
  for (int i = 0; i < model.rows().count(); ++i) {
    const double outside = model.rows().outside(i, model.value()[i]);
    sum += outside * outside / inverse_hessian[i];
  }
  return sum;
}

}  // namespace

void Infeasibility::prepare(const QpModel& model) {
  for (VectorXd* v : {&weight_, &extra_, &multiplier_}) v->setZero(model.rows().all());
  z_ = model.z();
  x_N_ = model.x_N();
}

/// At any point e away that satisfies dynamics and rows, Σ m aᵀe is at least `violated`. It is also
/// what is left of their force, times e, and what the multipliers of the dynamics make of the
/// defects.
bool Infeasibility::is_proven(QpModel& model, const VectorXd& multiplier) noexcept {
  double violated = 0.0;
  for (int i = 0; i < model.rows().count(); ++i) {
    if (multiplier[i] == 0.0) continue;
    const QpRows::Row& row = model.rows()[i];
    violated -= multiplier[i] * (model.value()[i] - (multiplier[i] > 0.0 ? row.lower : row.upper));
  }
  if (!(violated > 0.0)) return false;
  const Riccati::Stationarity left = model.stationarity_of_multipliers(multiplier);
  const Sizes& sizes = model.sizes();
  const int n_nu = sizes.n_lambda + sizes.n_u;
  const auto far = [](double largest) { return kFar * std::max(1.0, largest); };
  const double inputs = n_nu == 0 ? 0.0 : model.z().bottomRows(n_nu).cwiseAbs().maxCoeff();
  const double states = std::max(model.z().topRows(sizes.n_x).cwiseAbs().maxCoeff(),
                                 model.x_N().cwiseAbs().maxCoeff());
  return left.input_sum * far(inputs) + left.state_sum * far(states) + std::abs(left.defect) <
         violated;
}

/// From the minimiser without rows, damped Newton steps on the squares of the violations, the QP's
/// own Hessian holding the point where it is [proximal point]. Where they end, the violations
/// themselves are the multipliers sought.
bool Infeasibility::prove(QpModel& model, const VectorXd& inverse_hessian) noexcept {
  const int n = model.rows().count();
  steps_ = 0;
  weight_.setZero();
  extra_.setZero();
  if (!model.factor(weight_)) return false;
  model.newton_from_rest(extra_);
  double sum = squares(model, inverse_hessian);
  while (steps_ < kMaxSteps && model.violation() > kMet) {
    ++steps_;
    for (int i = 0; i < n; ++i) {
      const double outside = model.rows().outside(i, model.value()[i]);
      weight_[i] = outside == 0.0 ? 0.0 : kViolatedStiffness / inverse_hessian[i];
      extra_[i] = weight_[i] * outside;
      multiplier_[i] = -extra_[i];
    }
    if (!model.factor(weight_)) return false;
    if (is_proven(model, multiplier_)) return true;
    model.newton_of_rows(extra_);
    double slope = 0.0;
    for (int i = 0; i < n; ++i) {
      if (extra_[i] != 0.0) slope += 2.0 / kViolatedStiffness * extra_[i] * model.change(i);
    }
    if (!(slope < 0.0)) return false;
    z_ = model.z();
    x_N_ = model.x_N();
    double alpha = 1.0, after = sum;
    for (int half = 0; half <= kMaxHalvings; ++half, alpha *= 0.5) {
      model.go_to(z_, x_N_);
      model.move(alpha);
      after = squares(model, inverse_hessian);
      if (after <= sum + kDescent * alpha * slope + kFlat * sum) break;
    }
    sum = after;
  }
  return false;
}

}  // namespace c3rt::qp
