#include "controller/c3/fixed_modes.hpp"

#include <cmath>

namespace c3rt::c3 {
namespace {

// A pivot smaller than this beside the largest entry of its row is rounding.
constexpr double kPivot = 1e-9;
// A sum this small beside its terms is rounding, too.
constexpr double kCancelled = 1e-12;

}  // namespace

FixedModes::FixedModes(const qp::Sizes& sizes)
    : table_(sizes.n_lambda + sizes.n_x, sizes.n_lambda + sizes.n_x + sizes.n_u + 1),
      row_(table_.cols()),
      column_(table_.rows()),
      has_force_(Eigen::VectorXi::Zero(sizes.n_lambda)),
      n_x_(sizes.n_x),
      n_lambda_(sizes.n_lambda),
      n_u_(sizes.n_u) {
  table_.setZero();
}

void FixedModes::start(const lcs::Lcs& lcs) noexcept {
  const auto fill = [&](int row, int rows, const Eigen::MatrixXd& of_lambda,
                        const Eigen::MatrixXd& of_x, const Eigen::MatrixXd& of_u,
                        const Eigen::VectorXd& constant) {
    table_.block(row, 0, rows, n_lambda_) = of_lambda;
    table_.block(row, n_lambda_, rows, n_x_) = of_x;
    table_.block(row, n_lambda_ + n_x_, rows, n_u_) = of_u;
    table_.block(row, table_.cols() - 1, rows, 1) = constant;
  };
  fill(0, n_lambda_, lcs.F, lcs.E, lcs.H, lcs.c);
  fill(n_lambda_, n_x_, lcs.D, lcs.A, lcs.B, lcs.d);
  has_force_.setZero();
  pivots_ = 0;
}

bool FixedModes::is_pivot(int row, int column) const noexcept {
  const double largest = table_.row(row).head(n_lambda_).cwiseAbs().maxCoeff();
  return std::abs(table_(row, column)) > kPivot * largest;
}

/// Exchanges what a row is with what a column is.
void FixedModes::pivot(int row, int column) noexcept {
  ++pivots_;
  const double inverse = 1.0 / table_(row, column);
  row_ = -inverse * table_.row(row);
  row_[column] = inverse;
  column_ = table_.col(column);
  for (Eigen::Index r = 0; r < table_.rows(); ++r) {
    if (r == row || column_[r] == 0.0) continue;
    table_(r, column) = 0.0;
    // what cancels is zero: friction's edges make rows that say the same
    for (Eigen::Index c = 0; c < table_.cols(); ++c) {
      const double term = column_[r] * row_[c], sum = table_(r, c) + term;
      table_(r, c) = std::abs(sum) <= kCancelled * std::abs(term) ? 0.0 : sum;
    }
  }
  table_.row(row) = row_;
}

bool FixedModes::exchange(int pair) noexcept {
  if (!is_pivot(pair, pair)) return false;
  pivot(pair, pair);
  has_force_[pair] = 1 - has_force_[pair];
  return true;
}

/// Two pairs at once, neither of which can be exchanged alone.
bool FixedModes::exchange_two(int one, int other) noexcept {
  if (!is_pivot(one, other)) return false;
  // what is left for the second pivot
  const double second =
      table_(other, one) - table_(other, other) * table_(one, one) / table_(one, other);
  if (!(std::abs(second) > kPivot * table_.row(other).head(n_lambda_).cwiseAbs().maxCoeff()))
    return false;
  pivot(one, other);
  pivot(other, one);
  table_.row(one).swap(table_.row(other));
  table_.col(one).swap(table_.col(other));
  for (const int pair : {one, other}) has_force_[pair] = 1 - has_force_[pair];
  return true;
}

bool FixedModes::set(const char* force) noexcept {
  const auto differs = [&](int pair) { return has_force(pair) != (force[pair] != 0); };
  while (true) {
    int best = -1;
    double largest = 0.0;
    bool all = true;
    for (int i = 0; i < n_lambda_; ++i) {
      if (!differs(i)) continue;
      all = false;
      if (!is_pivot(i, i)) continue;
      const double size =
          std::abs(table_(i, i)) / table_.row(i).head(n_lambda_).cwiseAbs().maxCoeff();
      if (size <= largest) continue;
      largest = size;
      best = i;
    }
    if (all) return true;
    if (best >= 0) {
      exchange(best);
      continue;
    }
    bool exchanged = false;
    for (int i = 0; i < n_lambda_ && !exchanged; ++i) {
      for (int j = 0; j < n_lambda_ && !exchanged; ++j) {
        if (i != j && differs(i) && differs(j)) exchanged = exchange_two(i, j);
      }
    }
    if (!exchanged) return false;
  }
}

void FixedModes::evaluate(const Eigen::Ref<const Eigen::VectorXd>& xu,
                          Eigen::Ref<Eigen::VectorXd> s,
                          Eigen::Ref<Eigen::VectorXd> x_next) const noexcept {
  const auto last = table_.col(table_.cols() - 1);
  s = last.head(n_lambda_);
  s.noalias() += table_.block(0, n_lambda_, n_lambda_, n_x_ + n_u_) * xu;
  x_next = last.tail(n_x_);
  x_next.noalias() += table_.block(n_lambda_, n_lambda_, n_x_, n_x_ + n_u_) * xu;
}

void FixedModes::dynamics(lcs::Lcs& lcs) const noexcept {
  lcs.A = table_.block(n_lambda_, n_lambda_, n_x_, n_x_);
  lcs.B = table_.block(n_lambda_, n_lambda_ + n_x_, n_x_, n_u_);
  lcs.d = table_.col(table_.cols() - 1).tail(n_x_);
}

}  // namespace c3rt::c3
