#include "controller/qp/qp_cost.hpp"

#include <algorithm>
#include <cmath>

#include "controller/qp/kernels.hpp"

namespace c3rt::qp {

using Eigen::MatrixXd;
using Eigen::VectorXd;

QpCost::QpCost(const Sizes& sizes)
    : sizes_(sizes),
      H_(sizes.N, MatrixXd::Zero(sizes.n_z(), sizes.n_z())),
      h_(MatrixXd::Zero(sizes.n_z(), sizes.N)),
      h_N_(VectorXd::Zero(sizes.n_x)) {}

void QpCost::set_costs(const Costs& costs) {
  Q_ = costs.Q;
  Q_N_ = costs.Q_N;
  R_ = costs.R;
  rho_ = 0.0;
}

void QpCost::start(StageMatrices W) noexcept {
  W_ = W;
  stride_ = W.stride == 0 && Q_.count() == 1 && R_.count() == 1 ? 0 : 1;
  rho_ = 0.0;
}

void QpCost::build_hessian(double rho) noexcept {
  for (int k = 0; k < (stride_ == 0 ? 1 : sizes_.N); ++k) {
    H_[k] = rho * W_[k];
    H_[k].topLeftCorner(sizes_.n_x, sizes_.n_x) += Q_[k];
    H_[k].bottomRightCorner(sizes_.n_u, sizes_.n_u) += R_[k];
  }
  rho_ = rho;
}

void QpCost::set_linear_term(const Eigen::Ref<const MatrixXd>& x_desired,
                             const Eigen::Ref<const MatrixXd>& g) noexcept {
  const int n_x = sizes_.n_x;
  h_ = rho_ * g;
  for (int k = 0; k < sizes_.N; ++k) {
    kernels::add_columns(n_x, n_x, Q_[k].data(), n_x, x_desired.col(k).data(), h_.col(k).data());
  }
  h_N_.setZero();
  kernels::add_columns(n_x, n_x, Q_N_.data(), n_x, x_desired.col(sizes_.N).data(), h_N_.data());
}

void QpCost::gradient(const Eigen::Ref<const MatrixXd>& z, const Eigen::Ref<const VectorXd>& x_N,
                      MatrixXd& gradient, VectorXd& gradient_N) const noexcept {
  const int n_x = sizes_.n_x, n_z = sizes_.n_z();
  for (int k = 0; k < sizes_.N; ++k) {
    kernels::product_minus(n_z, n_z, H_[k * stride_].data(), n_z, z.data() + k * z.outerStride(),
                           h_.data() + k * n_z, gradient.data() + k * n_z);
  }
  kernels::product_minus(n_x, n_x, Q_N_.data(), n_x, x_N.data(), h_N_.data(), gradient_N.data());
}

QpCost::Terms QpCost::terms(const MatrixXd& gradient, const VectorXd& gradient_N) const noexcept {
  const int n_x = sizes_.n_x, n_nu = sizes_.n_z() - n_x;
  const auto largest = [&](int first, int rows) {
    return std::max(kernels::largest(rows, sizes_.N, gradient.data() + first, n_x + n_nu),
                    kernels::largest(rows, sizes_.N, h_.data() + first, n_x + n_nu));
  };
  const double of_x_N =
      std::max(kernels::largest(n_x, gradient_N.data()), kernels::largest(n_x, h_N_.data()));
  return {std::max(of_x_N, largest(0, n_x)), largest(n_x, n_nu)};
}

}  // namespace c3rt::qp
