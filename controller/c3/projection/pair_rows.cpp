#include "controller/c3/projection/pair_rows.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace c3rt::c3 {
namespace {

constexpr double kZeroWeight = 1e-8;  // of the largest, for directions without weight
constexpr double kSingular = 1e-12;   // of the largest: a weight that counts as none

}  // namespace

PairRows::PairRows(const Sizes& the_sizes)
    : sizes(the_sizes),
      J(Eigen::MatrixXd::Zero(2 * sizes.n_lambda, sizes.n_z())),
      C(Eigen::MatrixXd::Zero(sizes.n_z(), 2 * sizes.n_lambda)),
      scale(Eigen::VectorXd::Ones(2 * sizes.n_lambda)),
      t(Eigen::VectorXd::Zero(2 * sizes.n_lambda)) {
  J.block(0, sizes.n_x, sizes.n_lambda, sizes.n_lambda).setIdentity();
}

void PairRows::assign(const lcs::Lcs& lcs) noexcept {
  const int n = sizes.n_lambda;
  c = &lcs.c;
  J.block(n, 0, n, sizes.n_x) = lcs.E;
  J.block(n, sizes.n_x, n, n) = lcs.F;
  J.block(n, sizes.n_x + n, n, sizes.n_u) = lcs.H;
}

void PairRows::normalise() noexcept {
  n_constant = 0;
  for (Eigen::Index i = 0; i < C.cols(); ++i) {
    const double length = C.col(i).norm();
    scale[i] = length > 0.0 ? 1.0 / length : 0.0;
    n_constant += length == 0.0;
    C.col(i) *= scale[i];
  }
}

void PairRows::evaluate(const Eigen::Ref<const Eigen::VectorXd>& v) noexcept {
  t.noalias() = J * v;
  t.tail(sizes.n_lambda) += *c;
  largest = 0.0;
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    if (scale[i] == 0.0) continue;
    t[i] *= scale[i];
    largest = std::max(largest, std::abs(t[i]));
  }
  if (n_constant == 0) return;
  // no δ changes these: beside all others they are clearly open, closed or out of reach
  if (largest == 0.0) largest = 1.0;
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    if (scale[i] == 0.0 && t[i] != 0.0) t[i] = std::copysign(largest, t[i]);
  }
}

bool PairRows::holds(const Eigen::Ref<const Eigen::VectorXd>& v,
                     const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept {
  const int n = sizes.n_lambda;
  for (int i = 0; i < n; ++i) {
    const auto row = J.row(n + i);
    double y = (*c)[i], terms = std::abs(y);
    for (Eigen::Index j = 0; j < row.size(); ++j) {
      y += row[j] * delta[j];
      terms += std::abs(row[j]) * (std::abs(delta[j]) + std::abs(v[j]));
    }
    const double way = scale[n + i] > 0.0 ? largest / scale[n + i] : 0.0;
    const double closed = kInSet * (terms + way);
    const bool is_closed = std::abs(y) <= closed;
    if (!(is_closed || (y > 0.0 && delta[sizes.n_x + i] == 0.0))) return false;
  }
  return true;
}

Eigen::MatrixXd definite(const Eigen::MatrixXd& U) {
  Eigen::MatrixXd made = U;
  const double largest = U.diagonal().maxCoeff();
  if (!(largest > 0.0)) return Eigen::MatrixXd::Identity(U.rows(), U.cols());
  if (U.isDiagonal(0.0)) {
    for (Eigen::Index i = 0; i < U.rows(); ++i) {
      if (U(i, i) <= kSingular * largest) made(i, i) = kZeroWeight * largest;
    }
  } else if (Eigen::LDLT<Eigen::MatrixXd>(U).vectorD().minCoeff() <= kSingular * largest) {
    made.diagonal().array() += kZeroWeight * largest;
  }
  return made;
}

}  // namespace c3rt::c3
