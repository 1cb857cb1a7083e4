#pragma once
// (15) by enumeration, independent of everything in controller/horizon: long double, dense, no
// active-set method.
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Dense>

#include "controller/horizon/problem.hpp"

namespace enumeration {

using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

/// The best plan's cost, or nothing if no plan meets the problem. A minimiser makes some of λ and y
/// zero (of each pair one, or both) and some bounds tight, and is then the solution of the KKT
/// system of these equalities alone; where it is not the only minimiser, one at a vertex is. So all
/// 3^(N n_lambda) times the combinations of bounds are tried, and the cheapest solution that meets
/// everything is the optimum.
inline std::optional<Real> optimum(const c3rt::horizon::Problem& problem) {
  constexpr Real kMet = 1e-11L;  // of the terms of a row
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const c3rt::c3::Constraints& constraints = *problem.constraints;
  const int n_stage = n_u + n_lambda, n_v = N * n_stage, n_pairs = N * n_lambda;

  // x_k = X v + x, open loop: horizons here are short
  Matrix X = Matrix::Zero(n_x, n_v), H = Matrix::Zero(n_v, n_v);
  Vector x = problem.x0.cast<Real>(), g = Vector::Zero(n_v);
  Real constant = 0.0L;
  Matrix pairs = Matrix::Zero(2 * n_pairs, n_v);
  Vector offsets = Vector::Zero(2 * n_pairs);
  std::vector<Vector> rows;  // row v + offset ≥ 0
  std::vector<Real> offset;
  std::vector<bool> equality;
  const auto bound = [&](const Vector& row, Real value, double minimum, double maximum) {
    if (minimum == maximum) {
      rows.push_back(row), offset.push_back(value - minimum), equality.push_back(true);
      return;
    }
    if (std::isfinite(minimum))
      rows.push_back(row), offset.push_back(value - minimum), equality.push_back(false);
    if (std::isfinite(maximum))
      rows.push_back(-row), offset.push_back(maximum - value), equality.push_back(false);
  };
  const auto bounds = [&](const Matrix& matrix, const Vector& value, const Eigen::VectorXd& minimum,
                          const Eigen::VectorXd& maximum) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      bound(matrix.row(i), value[i], minimum.size() > 0 ? minimum[i] : -kNone,
            maximum.size() > 0 ? maximum[i] : kNone);
  };
  const auto cost = [&](const Eigen::MatrixXd& weight, const Matrix& matrix, const Vector& error) {
    const Matrix weighted = weight.cast<Real>() * matrix;
    H += matrix.transpose() * weighted;
    g += weighted.transpose() * error;
    constant += error.dot(weight.cast<Real>() * error);
  };
  for (int k = 0; k < N; ++k) {
    const c3rt::lcs::Lcs& lcs = problem.systems[k];
    Matrix U = Matrix::Zero(n_u, n_v), L = Matrix::Zero(n_lambda, n_v);
    U.middleCols(k * n_stage, n_u).setIdentity();
    L.middleCols(k * n_stage + n_u, n_lambda).setIdentity();
    cost(problem.costs->Q[k], X, x - problem.x_desired.col(k).cast<Real>());
    cost(problem.costs->R[k], U, Vector::Zero(n_u));
    pairs.middleRows(k * n_lambda, n_lambda) = L;
    pairs.middleRows(n_pairs + k * n_lambda, n_lambda) =
        lcs.E.cast<Real>() * X + lcs.F.cast<Real>() * L + lcs.H.cast<Real>() * U;
    offsets.segment(n_pairs + k * n_lambda, n_lambda) = lcs.E.cast<Real>() * x + lcs.c.cast<Real>();
    if (k > 0) bounds(X, x, constraints.x_min[k], constraints.x_max[k]);
    bounds(U, Vector::Zero(n_u), constraints.u_min[k], constraints.u_max[k]);
    bounds(L, Vector::Zero(n_lambda), constraints.lambda_min[k], constraints.lambda_max[k]);
    x = (lcs.A.cast<Real>() * x + lcs.d.cast<Real>()).eval();
    X = (lcs.A.cast<Real>() * X + lcs.B.cast<Real>() * U + lcs.D.cast<Real>() * L).eval();
  }
  cost(problem.costs->Q_N, X, x - problem.x_desired.col(N).cast<Real>());
  bounds(X, x, constraints.x_N_min, constraints.x_N_max);

  // units of v and of the rows, so that one tolerance is enough
  Vector unit(n_v);
  for (int i = 0; i < n_v; ++i) unit[i] = H(i, i) > 0.0L ? 1.0L / std::sqrt(H(i, i)) : 1.0L;
  H = (unit.asDiagonal() * H * unit.asDiagonal()).eval();
  g = unit.cwiseProduct(g).eval();
  const int n_rows = 2 * n_pairs + static_cast<int>(rows.size());
  Matrix J(n_rows, n_v);
  Vector c(n_rows);
  J.topRows(2 * n_pairs) = pairs;
  c.head(2 * n_pairs) = offsets;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    J.row(2 * n_pairs + i) = rows[i].transpose();
    c[2 * n_pairs + i] = offset[i];
  }
  J = (J * unit.asDiagonal()).eval();
  for (int i = 0; i < n_rows; ++i) {
    const Real length = J.row(i).norm();
    if (length == 0.0L) continue;
    J.row(i) /= length;
    c[i] /= length;
  }

  std::vector<int> inequalities, tight;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (!equality[i]) inequalities.push_back(2 * n_pairs + static_cast<int>(i));
  long combinations = 1;
  for (int i = 0; i < n_pairs; ++i) combinations *= 3;
  for (std::size_t i = 0; i < inequalities.size(); ++i) combinations *= 2;
  std::optional<Real> best;
  for (long code = 0; code < combinations; ++code) {
    long rest = code;
    tight.clear();
    for (int i = 0; i < n_pairs; ++i, rest /= 3) {
      if (rest % 3 != 1) tight.push_back(i);
      if (rest % 3 != 0) tight.push_back(n_pairs + i);
    }
    for (const int row : inequalities) {
      if (rest % 2 != 0) tight.push_back(row);
      rest /= 2;
    }
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (equality[i]) tight.push_back(2 * n_pairs + static_cast<int>(i));
    const int n = n_v + static_cast<int>(tight.size());
    Matrix kkt = Matrix::Zero(n, n);
    Vector right = Vector::Zero(n);
    kkt.topLeftCorner(n_v, n_v) = H;
    right.head(n_v) = -g;
    for (std::size_t i = 0; i < tight.size(); ++i) {
      const int at = n_v + static_cast<int>(i);
      kkt.row(at).head(n_v) = J.row(tight[i]);
      kkt.col(at).head(n_v) = J.row(tight[i]).transpose();
      right[at] = -c[tight[i]];
    }
    Eigen::FullPivLU<Matrix> lu;
    lu.setThreshold(1e-14L);
    const Vector solution = lu.compute(kkt).solve(right);
    const Vector v = solution.head(n_v);
    const Vector s = J * v + c;
    const Real size = v.norm() + c.cwiseAbs().maxCoeff();
    if (!((kkt * solution - right).head(n_v).norm() <= 1e-9L * (g.norm() + solution.norm())))
      continue;
    bool met = true;
    for (const int row : tight) met = met && std::abs(s[row]) <= kMet * size;
    for (int i = 0; i < 2 * n_pairs; ++i) met = met && s[i] >= -kMet * size;
    for (const int row : inequalities) met = met && s[row] >= -kMet * size;
    if (!met) continue;
    const Real value = v.dot(H * v) + 2.0L * g.dot(v) + constant;
    if (!best || value < *best) best = value;
  }
  return best;
}

}  // namespace enumeration
