#include "controller/lcs/lemke.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::lcs {
namespace {

// An entry this small beside the largest of its column is rounding, not a pivot.
constexpr double kPivotTolerance = 1e-11;
// Ratios this close (beside the larger one) are a tie, which the lexicographic rule breaks.
constexpr double kTieTolerance = 1e-12;
// A basis whose λ misses the problem by more than this (beside max(1, |q|)) is not called solved.
constexpr double kResidualTolerance = 1e-7;
// A row that is missed by less than this part of its terms needs no second attempt.
constexpr double kExact = 1e-10;

struct Residual {
  double natural;   // max |min(λ, y)|
  double relative;  // what misses complementarity, beside the terms of its row
};

Residual residual(const Eigen::Ref<const Eigen::MatrixXd>& F,
                  const Eigen::Ref<const Eigen::VectorXd>& q,
                  const Eigen::Ref<const Eigen::VectorXd>& lambda, double epsilon) noexcept {
  Residual worst{0.0, 0.0};
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    double y = q[i] + epsilon * lambda[i], terms = std::abs(q[i]) + epsilon * lambda[i];
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      y += F(i, j) * lambda[j];
      terms += std::abs(F(i, j) * lambda[j]);
    }
    worst.natural = std::max(worst.natural, std::abs(std::min(lambda[i], y)));
    const double missing = lambda[i] > 0.0 ? std::abs(y) : std::max(-y, 0.0);
    if (missing > worst.relative * terms) worst.relative = missing / terms;
  }
  return worst;
}

}  // namespace

Lemke::Lemke(int size)
    : size_(size),
      tableau_(size, 2 * size + 2),
      basis_(size),
      q_(size),
      first_(size),
      row_(Eigen::VectorXd::Ones(size)),
      column_(Eigen::VectorXd::Ones(size)) {}

LcpReport Lemke::solve(const Eigen::Ref<const Eigen::MatrixXd>& F,
                       const Eigen::Ref<const Eigen::VectorXd>& q,
                       Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  LcpReport first = attempt(F, q, 0.0, false, lambda);
  if (first.pivots == 0) return first;  // trivial, or refused
  const auto missed = [&](const LcpReport& report) {
    if (report.status != LcpStatus::kSolved) return HUGE_VAL;
    return residual(F, q, lambda, 0.0).relative;
  };
  const double first_missed = missed(first);
  if (first_missed <= kExact) return first;
  first_ = lambda;
  equilibrate(F);
  LcpReport second = attempt(F, q, 0.0, true, lambda);
  const bool better = missed(second) < first_missed;
  if (!better) lambda = first_;
  LcpReport& report = better ? second : first;
  report.pivots = first.pivots + second.pivots;
  return report;
}

LcpReport Lemke::solve_regularised(const Eigen::Ref<const Eigen::MatrixXd>& F,
                                   const Eigen::Ref<const Eigen::VectorXd>& q,
                                   Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  LcpReport report = solve(F, q, lambda);
  if (report.status == LcpStatus::kSolved || !F.allFinite() || !q.allFinite()) return report;
  const double largest = F.size() > 0 ? F.cwiseAbs().maxCoeff() : 0.0;
  int pivots = report.pivots;
  for (double relative = 1e-12; relative < 2e-2; relative *= 100.0) {
    report = attempt(F, q, relative * std::max(largest, 1e-12), false, lambda);
    pivots += report.pivots;
    report.pivots = pivots;
    if (report.status == LcpStatus::kSolved) break;
  }
  return report;
}

LcpReport Lemke::attempt(const Eigen::Ref<const Eigen::MatrixXd>& F,
                         const Eigen::Ref<const Eigen::VectorXd>& q, double epsilon, bool scaled,
                         Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const int n = size_;
  const int z0 = 2 * n, rhs = 2 * n + 1;
  lambda.setZero();
  if (F.rows() != n || F.cols() != n || q.size() != n || lambda.size() != n || !F.allFinite() ||
      !q.allFinite()) {
    return {LcpStatus::kInaccurate, 0, HUGE_VAL, epsilon};
  }
  if (n == 0 || q.minCoeff() >= 0.0) return {LcpStatus::kSolved, 0, 0.0, epsilon};

  // w − F λ − 1 z0 = q
  tableau_.leftCols(n).setIdentity();
  tableau_.middleCols(n, n) = -F;
  tableau_.middleCols(n, n).diagonal().array() -= epsilon;
  tableau_.col(z0).setConstant(-1.0);
  tableau_.col(rhs) = q;
  if (scaled) {
    tableau_.middleCols(n, n) =
        row_.asDiagonal() * tableau_.middleCols(n, n) * column_.asDiagonal();
    tableau_.col(rhs).array() *= row_.array();
  }
  for (int i = 0; i < n; ++i) basis_[i] = i;

  // z0 enters in the lexicographically smallest row; of equal q the last row has the smallest
  // [q | w columns], because the identity's 1 comes latest in it
  int row = 0;
  for (int i = 1; i < n; ++i) {
    if (tableau_(i, rhs) <= tableau_(row, rhs)) row = i;
  }
  int entering = z0;
  const int pivot_limit = 50 + 20 * n;
  int pivots = 0;
  while (true) {
    if (pivots == pivot_limit) {
      return {LcpStatus::kPivotLimit, pivots, residual(F, q, lambda, 0.0).natural, epsilon};
    }
    const int leaving = basis_[row];
    pivot(row, entering);
    ++pivots;
    if (leaving == z0) break;
    entering = leaving < n ? leaving + n : leaving - n;  // the complement of what left
    row = leaving_row(entering);
    if (row < 0) return {LcpStatus::kRay, pivots, residual(F, q, lambda, 0.0).natural, epsilon};
  }

  for (int i = 0; i < n; ++i) {
    if (basis_[i] < n || basis_[i] >= z0) continue;
    const int j = basis_[i] - n;
    lambda[j] = std::max(tableau_(i, rhs), 0.0) * (scaled ? column_[j] : 1.0);
  }
  const double solved_residual = residual(F, q, lambda, epsilon).natural;
  const double limit = kResidualTolerance * std::max(1.0, q.cwiseAbs().maxCoeff());
  if (!(solved_residual <= limit)) {
    lambda.setZero();
    return {LcpStatus::kInaccurate, pivots, solved_residual, epsilon};
  }
  const double natural = epsilon > 0.0 ? residual(F, q, lambda, 0.0).natural : solved_residual;
  return {LcpStatus::kSolved, pivots, natural, epsilon};
}

/// Factors that bring the geometric means of F's rows and columns near 1.
void Lemke::equilibrate(const Eigen::Ref<const Eigen::MatrixXd>& F) noexcept {
  row_.setOnes();
  column_.setOnes();
  const auto factor = [&](int line, bool is_row) {
    int sum = 0, count = 0;
    for (int k = 0; k < size_; ++k) {
      const int i = is_row ? line : k, j = is_row ? k : line;
      const double entry = row_[i] * F(i, j) * column_[j];
      if (entry == 0.0 || !std::isfinite(entry)) continue;
      sum += std::ilogb(entry);
      ++count;
    }
    return count > 0 ? std::ldexp(1.0, -sum / count) : 1.0;
  };
  for (int sweep = 0; sweep < 4; ++sweep) {
    for (int i = 0; i < size_; ++i) row_[i] *= factor(i, true);
    for (int j = 0; j < size_; ++j) column_[j] *= factor(j, false);
  }
}

int Lemke::leaving_row(int entering) const noexcept {
  const int n = size_;
  const int z0 = 2 * n, rhs = 2 * n + 1;
  double largest = 0.0;
  for (int i = 0; i < n; ++i) largest = std::max(largest, std::abs(tableau_(i, entering)));
  const double smallest_pivot = kPivotTolerance * largest;

  // lexicographic comparison of [q | B⁻¹] rows over their pivots: is row i before row j?
  const auto before = [&](int i, int j) {
    const double a_i = tableau_(i, entering), a_j = tableau_(j, entering);
    const auto compare = [&](int column) {
      const double left = tableau_(i, column) / a_i, right = tableau_(j, column) / a_j;
      if (std::abs(left - right) <= kTieTolerance * std::max(std::abs(left), std::abs(right))) {
        return 0;
      }
      return left < right ? -1 : 1;
    };
    if (const int order = compare(rhs); order != 0) return order < 0;
    if (basis_[i] == z0 || basis_[j] == z0) return basis_[i] == z0;  // z0 leaves: solved
    for (int column = 0; column < n; ++column) {
      if (const int order = compare(column); order != 0) return order < 0;
    }
    return i < j;
  };

  int best = -1;
  for (int i = 0; i < n; ++i) {
    if (tableau_(i, entering) > smallest_pivot && (best < 0 || before(i, best))) best = i;
  }
  return best;
}

void Lemke::pivot(int row, int entering) noexcept {
  tableau_.row(row) /= tableau_(row, entering);
  for (int i = 0; i < size_; ++i) {
    if (i == row) continue;
    const double factor = tableau_(i, entering);
    if (factor == 0.0) continue;
    tableau_.row(i) -= factor * tableau_.row(row);
    tableau_(i, entering) = 0.0;
  }
  basis_[row] = entering;
}

}  // namespace c3rt::lcs
