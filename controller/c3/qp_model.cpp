#include "controller/c3/qp_model.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::c3 {

using Eigen::MatrixXd;
using Eigen::VectorXd;

QpModel::QpModel(const Sizes& sizes) : sizes_(sizes), cost_(sizes), riccati_(sizes), rows_(sizes) {
  for (MatrixXd* m : {&z_, &z_rest_, &gradient_, &gradient_rest_, &total_, &step_})
    m->setZero(sizes.n_z(), sizes.N);
  for (VectorXd* v :
       {&x0_, &x_N_, &x_N_rest_, &gradient_N_, &gradient_N_rest_, &total_N_, &step_N_})
    v->setZero(sizes.n_x);
}

void QpModel::set_costs(const Costs& costs, const Constraints& constraints) {
  cost_.set_costs(costs);
  rows_.set(constraints);
  value_.setZero(rows_.all());
  value_rest_.setZero(rows_.all());
  weight_.setZero(rows_.all());
  squares_.prepare(sizes_.N, rows_.all());
}

void QpModel::start(Horizon lcs, StageMatrices W, const VectorXd* lambda_0) noexcept {
  cost_.start(W);
  riccati_.start(lcs, lambda_0 != nullptr);
  factored_ = false;
  rows_.fix_lambda_0(lambda_0 != nullptr);
  lambda_0_ = lambda_0;
}

void QpModel::aim(double rho, const Eigen::Ref<const VectorXd>& x0,
                  const Eigen::Ref<const MatrixXd>& x_desired,
                  const Eigen::Ref<const MatrixXd>& g) noexcept {
  if (rho != cost_.rho()) {
    cost_.weigh(rho);
    factored_ = false;
  }
  cost_.aim(x_desired, g);
  x0_ = x0;
  z_.setZero();
  if (lambda_0_ != nullptr) sizes_.lambda(z_.col(0)) = *lambda_0_;
  riccati_.roll_out(x0_, z_, x_N_);
  evaluate();
  z_rest_ = z_;
  x_N_rest_ = x_N_;
  value_rest_ = value_;
  cost_.gradient(z_rest_, x_N_rest_, gradient_rest_, gradient_N_rest_);
}

bool QpModel::factor(const VectorXd& weight) noexcept {
  // the recursion runs from the end: what lies behind the last change stands
  int last = factored_ ? -1 : sizes_.N;
  squares_.clear();
  for (int i = 0; i < rows_.count(); ++i) {
    const QpRows::Row& row = rows_[i];
    if (weight[i] != weight_[i]) last = std::max(last, row.stage);
    if (weight[i] != 0.0) squares_.add(row.stage, row.coordinate, rows_.normal(i), weight[i]);
  }
  weight_ = weight;
  factored_ = riccati_.factor(cost_.H(), cost_.H_N(), last, &squares_);
  return factored_;
}

void QpModel::measure(VectorXd& compliance) noexcept {
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
    compliance[i] =
        k == sizes_.N ? riccati_.compliance(k, total_N_) : riccati_.compliance(k, total_.col(k));
    largest = std::max(largest, compliance[i]);
  }
  // a row that no input moves
  if (largest == 0.0) largest = 1.0;
  for (int i = 0; i < rows_.count(); ++i) {
    if (!(compliance[i] > 0.0)) compliance[i] = largest;
  }
}

double QpModel::differentiate(const VectorXd& multiplier) noexcept {
  const double term = cost_.gradient(z_, x_N_, gradient_, gradient_N_);
  for (int i = 0; i < rows_.count(); ++i) {
    if (multiplier[i] != 0.0) rows_.add(i, -multiplier[i], gradient_, gradient_N_);
  }
  return term;
}

double QpModel::stationarity(const VectorXd& multiplier) noexcept {
  double largest = riccati_.largest_gain() * differentiate(multiplier);
  for (int i = 0; i < rows_.count(); ++i) largest = std::max(largest, std::abs(multiplier[i]));
  const Riccati::Reduced reduced = riccati_.reduce(gradient_, gradient_N_);
  return reduced.largest == 0.0 ? 0.0 : reduced.largest / std::max(reduced.scale, largest);
}

Riccati::Reduced QpModel::pull(const VectorXd& multiplier) noexcept {
  total_.setZero();
  total_N_.setZero();
  for (int i = 0; i < rows_.count(); ++i) rows_.add(i, -multiplier[i], total_, total_N_);
  return riccati_.reduce(total_, total_N_);
}

void QpModel::newton(const VectorXd& extra) noexcept { step(gradient_, gradient_N_, extra); }

void QpModel::newton_from_rest(const VectorXd& extra) noexcept {
  step(gradient_rest_, gradient_N_rest_, extra);
  z_ = z_rest_ + step_;
  x_N_ = x_N_rest_ + step_N_;
  evaluate();
}

void QpModel::step(const MatrixXd& gradient, const VectorXd& gradient_N,
                   const VectorXd& extra) noexcept {
  total_ = gradient;
  total_N_ = gradient_N;
  for (int i = 0; i < rows_.count(); ++i) {
    if (extra[i] != 0.0) rows_.add(i, extra[i], total_, total_N_);
  }
  riccati_.step(total_, total_N_, step_, step_N_);
}

void QpModel::move(double alpha) noexcept {
  const int n_nu = sizes_.n_lambda + sizes_.n_u;
  z_.bottomRows(n_nu) += alpha * step_.bottomRows(n_nu);
  riccati_.roll_out(x0_, z_, x_N_);
  evaluate();
}

double QpModel::relative_step() const noexcept { return c3::relative_step(sizes_, step_, z_); }

void QpModel::go_to(const MatrixXd& z, const VectorXd& x_N) noexcept {
  z_ = z;
  x_N_ = x_N;
  evaluate();
}

void QpModel::evaluate() noexcept {
  for (int i = 0; i < rows_.count(); ++i) value_[i] = rows_.value(i, z_, x_N_);
}

}  // namespace c3rt::c3
