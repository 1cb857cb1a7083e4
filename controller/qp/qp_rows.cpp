#include "controller/qp/qp_rows.hpp"

#include <algorithm>
#include <cmath>

#include "controller/qp/bound.hpp"

namespace c3rt::qp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

void QpRows::set(const Constraints& c) {
  rows_.clear();
  normals_.clear();
  const int n_x = sizes_.n_x, n_lambda = sizes_.n_lambda;
  for (int k = 0; k < sizes_.N; ++k) {
    if (k > 0) {
      add_bounds(k, 0, c.x_min[k], c.x_max[k]);
      add_bounds(k, n_x, c.lambda_min[k], c.lambda_max[k]);
    }
    add_bounds(k, n_x + n_lambda, c.u_min[k], c.u_max[k]);
    for (Eigen::Index row = 0; row < c.C[k].rows(); ++row) {
      const VectorXd a = c.C[k].row(row);
      if (k == 0 && a.tail(sizes_.n_z() - n_x).isZero(0.0)) continue;  // x_0 is given
      add_general(k, a, bound_at(c.C_min[k], row, -kInfinity),
                  bound_at(c.C_max[k], row, kInfinity));
    }
  }
  add_bounds(sizes_.N, 0, c.x_N_min, c.x_N_max);
  first_of_lambda_0_ = all();
  add_bounds(0, n_x, c.lambda_min[0], c.lambda_max[0]);
  count_ = all();
  find_neighbours();
}

void QpRows::find_neighbours() {
  // the last and the first stage have none beyond
  const int stages = sizes_.N + 3;
  std::vector<int> row_of(static_cast<std::size_t>(stages * sizes_.n_z()), -1);
  const auto place = [&](const Row& row, int step) -> int& {
    return row_of[(row.stage + 1 + step) * sizes_.n_z() + row.coordinate];
  };
  for (int i = 0; i < all(); ++i) {
    if (rows_[i].coordinate >= 0) place(rows_[i], 0) = i;
  }
  later_.assign(rows_.size(), -1);
  earlier_.assign(rows_.size(), -1);
  for (int i = 0; i < all(); ++i) {
    if (rows_[i].coordinate < 0) continue;
    later_[i] = place(rows_[i], 1);
    earlier_[i] = place(rows_[i], -1);
  }
}

void QpRows::add_bounds(int k, int first, const VectorXd& lower, const VectorXd& upper) {
  for (Eigen::Index i = 0; i < std::max(lower.size(), upper.size()); ++i) {
    const double l = bound_at(lower, i, -kInfinity), u = bound_at(upper, i, kInfinity);
    if (l > -kInfinity || u < kInfinity)
      rows_.push_back({k, first + static_cast<int>(i), -1, l, u});
  }
}

void QpRows::add_general(int k, const VectorXd& a, double lower, double upper) {
  if (lower == -kInfinity && upper == kInfinity) return;
  Eigen::Index largest = 0;
  const double size = a.cwiseAbs().maxCoeff(&largest);
  if (size == 0.0 || (a.array() != 0.0).count() > 1) {
    const double scale = size == 0.0 ? 1.0 : 1.0 / size;
    rows_.push_back({k, -1, static_cast<int>(normals_.size()), scale * lower, scale * upper});
    normals_.emplace_back(scale * a);
    return;
  }
  const double l = lower / a[largest], u = upper / a[largest];
  rows_.push_back({k, static_cast<int>(largest), -1, std::min(l, u), std::max(l, u)});
}

double QpRows::value(int i, const MatrixXd& z, const VectorXd& x_N) const noexcept {
  const Row& row = rows_[i];
  if (row.stage == sizes_.N) return x_N[row.coordinate];
  if (row.coordinate >= 0) return z(row.coordinate, row.stage);
  return normals_[row.normal].dot(z.col(row.stage));
}

double QpRows::largest_term(int i, const MatrixXd& z, const VectorXd& x_N) const noexcept {
  if (rows_[i].coordinate >= 0) return std::abs(value(i, z, x_N));
  const VectorXd& a = normals_[rows_[i].normal];
  double largest = 0.0;
  for (Eigen::Index j = 0; j < a.size(); ++j) {
    largest = std::max(largest, std::abs(a[j] * z(j, rows_[i].stage)));
  }
  return largest;
}

void QpRows::add(int i, double c, MatrixXd& gradient, VectorXd& gradient_N) const noexcept {
  const Row& row = rows_[i];
  if (row.stage == sizes_.N) {
    gradient_N[row.coordinate] += c;
  } else if (row.coordinate >= 0) {
    gradient(row.coordinate, row.stage) += c;
  } else {
    gradient.col(row.stage) += c * normals_[row.normal];
  }
}

}  // namespace c3rt::qp
