#include "controller/qp/qp_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace c3rt::qp {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kOfKind =
    1e-3;                       // of the largest entry of its kind: what a bound of 0 is met beside
constexpr double kTiny = 1e-6;  // nor is a violation measured beside less

}  // namespace

QpModel::QpModel(const Sizes& sizes) : sizes_(sizes), cost_(sizes), riccati_(sizes), rows_(sizes) {
  for (MatrixXd* m : {&z_, &z_rest_, &gradient_, &gradient_rest_, &total_, &step_})
    m->setZero(sizes.n_z(), sizes.N);
  for (MatrixXd* m : {&defect_, &defect_rest_}) m->setZero(sizes.n_x, sizes.N);
  for (VectorXd* v : {&x_N_, &x_N_rest_, &gradient_N_, &gradient_N_rest_, &total_N_, &step_N_})
    v->setZero(sizes.n_x);
}

void QpModel::set_costs(const Costs& costs, const Constraints& constraints) {
  cost_.set_costs(costs);
  rows_.set(constraints);
  value_.setZero(rows_.all());
  value_rest_.setZero(rows_.all());
  weight_.setZero(rows_.all());
  rank_one_terms_.prepare(sizes_.N, rows_.all());
}

void QpModel::start(Horizon lcs, StageMatrices W, const VectorXd* lambda_0) noexcept {
  cost_.start(W);
  riccati_.start(lcs, lambda_0 != nullptr);
  factored_ = false;
  rows_.fix_lambda_0(lambda_0 != nullptr);
  lambda_0_ = lambda_0;
}

void QpModel::set_linear_term(double rho, const Eigen::Ref<const VectorXd>& x0,
                              const Eigen::Ref<const MatrixXd>& x_desired,
                              const Eigen::Ref<const MatrixXd>& g) noexcept {
  if (rho != cost_.rho()) {
    cost_.build_hessian(rho);
    factored_ = false;
  }
  cost_.set_linear_term(x_desired, g);
  z_.setZero();
  x_N_.setZero();
  sizes_.x(z_.col(0)) = x0;
  if (lambda_0_ != nullptr) sizes_.lambda(z_.col(0)) = *lambda_0_;
  riccati_.defects(z_, x_N_, defect_rest_);
  evaluate();
  z_rest_ = z_;
  x_N_rest_ = x_N_;
  value_rest_ = value_;
  cost_.gradient(z_rest_, x_N_rest_, gradient_rest_, gradient_N_rest_);
}

bool QpModel::factor(const VectorXd& weight) noexcept {
  // the recursion runs from the end: what lies behind the last change stands
  int last = factored_ ? -1 : sizes_.N;
  rank_one_terms_.clear();
  for (int i = 0; i < rows_.count(); ++i) {
    const QpRows::Row& row = rows_[i];
    if (weight[i] != weight_[i]) last = std::max(last, row.stage);
    if (weight[i] != 0.0)
      rank_one_terms_.add(row.stage, row.coordinate, rows_.normal(i), weight[i]);
  }
  weight_ = weight;
  factored_ = riccati_.factor(cost_.H(), cost_.H_N(), last, &rank_one_terms_);
  return factored_;
}

void QpModel::measure(VectorXd& inverse_hessian) noexcept {
  double largest = 0.0;
  for (int i = 0; i < rows_.count(); ++i) {
    const int k = rows_[i].stage;
    // the row's own stage alone: a horizon of zeros for each row would cost N²
    if (k == sizes_.N) {
      total_N_.setZero();
    } else {
      total_.col(k).setZero();
    }
    rows_.add(i, 1.0, total_, total_N_);
    inverse_hessian[i] = k == sizes_.N ? riccati_.inverse_hessian_along(k, total_N_)
                                       : riccati_.inverse_hessian_along(k, total_.col(k));
    largest = std::max(largest, inverse_hessian[i]);
  }
  // a row that no input moves
  if (largest == 0.0) largest = 1.0;
  for (int i = 0; i < rows_.count(); ++i) {
    if (!(inverse_hessian[i] > 0.0)) inverse_hessian[i] = largest;
  }
}

void QpModel::differentiate(const VectorXd& multiplier) noexcept {
  riccati_.defects(z_, x_N_, defect_);
  cost_.gradient(z_, x_N_, gradient_, gradient_N_);
  subtract_rows(multiplier);
}

/// Of the gradient.
void QpModel::subtract_rows(const VectorXd& multiplier) noexcept {
  for (int i = 0; i < rows_.count(); ++i) {
    if (multiplier[i] != 0.0) rows_.add(i, -multiplier[i], gradient_, gradient_N_);
  }
}

double QpModel::stationarity(const VectorXd& multiplier) noexcept {
  cost_.gradient(z_, x_N_, gradient_, gradient_N_);
  const QpCost::Terms terms = cost_.terms(gradient_, gradient_N_);
  subtract_rows(multiplier);
  double input_scale = 0.0;
  for (int i = 0; i < rows_.count(); ++i) {
    input_scale = std::max(input_scale, std::abs(multiplier[i]));
  }
  Riccati::Stationarity found = riccati_.stationarity(gradient_, gradient_N_, z_);
  found.input_scale = std::max(found.input_scale, input_scale);
  if (!found.is_known) return std::numeric_limits<double>::infinity();
  return relative(found, terms, riccati_.largest_gain());
}

double QpModel::inconsistency() noexcept {
  riccati_.defects(z_, x_N_, defect_);
  return riccati_.relative_defect(z_, x_N_, defect_);
}

double QpModel::violation() const noexcept {
  const int n_x = sizes_.n_x, n_lambda = sizes_.n_lambda;
  const auto largest = [](const auto& block) {
    return block.size() == 0 ? 0.0 : block.cwiseAbs().maxCoeff();
  };
  const double lambda = largest(z_.middleRows(n_x, n_lambda));
  const double u = largest(z_.bottomRows(sizes_.n_u));
  // a state is the sum of what comes from the stage before it
  const auto state = [&](int k) {
    const double own = k < sizes_.N ? largest(sizes_.x(z_.col(k))) : largest(x_N_);
    return k == 0 ? own : std::max(own, largest(sizes_.x(z_.col(k - 1))));
  };
  double worst = 0.0;
  for (int i = 0; i < rows_.count(); ++i) {
    const double outside = rows_.outside(i, value_[i]);
    if (outside == 0.0) continue;
    const QpRows::Row& row = rows_[i];
    const double bound = outside > 0.0 ? row.upper : row.lower;
    const double kind = row.coordinate < 0                ? rows_.largest_term(i, z_, x_N_)
                        : row.coordinate < n_x            ? kOfKind * state(row.stage)
                        : row.coordinate < n_x + n_lambda ? kOfKind * lambda
                                                          : kOfKind * u;
    const double scale = std::max({std::abs(bound), std::abs(value_[i]), kind, kTiny});
    const double relative = std::abs(outside) / scale;
    if (!(relative <= worst)) worst = relative;  // also NaN
  }
  return worst;
}

Riccati::Stationarity QpModel::stationarity_of_multipliers(const VectorXd& multiplier) noexcept {
  riccati_.defects(z_, x_N_, defect_);
  total_.setZero();
  total_N_.setZero();
  for (int i = 0; i < rows_.count(); ++i) rows_.add(i, -multiplier[i], total_, total_N_);
  return riccati_.stationarity_of_multipliers(total_, total_N_, defect_);
}

void QpModel::newton(const VectorXd& extra) noexcept {
  step(gradient_, gradient_N_, defect_, extra);
}

void QpModel::newton_of_rows(const VectorXd& extra) noexcept {
  gradient_.setZero();
  gradient_N_.setZero();
  riccati_.defects(z_, x_N_, defect_);
  newton(extra);
}

void QpModel::newton_from_rest(const VectorXd& extra) noexcept {
  step(gradient_rest_, gradient_N_rest_, defect_rest_, extra);
  z_ = z_rest_ + step_;
  x_N_ = x_N_rest_ + step_N_;
  evaluate();
}

void QpModel::step(const MatrixXd& gradient, const VectorXd& gradient_N, const MatrixXd& defect,
                   const VectorXd& extra) noexcept {
  total_ = gradient;
  total_N_ = gradient_N;
  for (int i = 0; i < rows_.count(); ++i) {
    if (extra[i] != 0.0) rows_.add(i, extra[i], total_, total_N_);
  }
  riccati_.step(total_, total_N_, defect, step_, step_N_);
}

void QpModel::move(double alpha) noexcept {
  z_ += alpha * step_;
  x_N_ += alpha * step_N_;
  evaluate();
}

double QpModel::relative_step() noexcept { return riccati_.relative_step(step_, z_); }

void QpModel::go_to(const MatrixXd& z, const VectorXd& x_N) noexcept {
  z_ = z;
  x_N_ = x_N;
  evaluate();
}

void QpModel::evaluate() noexcept {
  for (int i = 0; i < rows_.count(); ++i) value_[i] = rows_.value(i, z_, x_N_);
}

}  // namespace c3rt::qp
