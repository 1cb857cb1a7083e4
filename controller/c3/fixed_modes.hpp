#pragma once

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"
#include "controller/qp/problem.hpp"

namespace c3rt::c3 {

/// One stage of an LCS of whose pairs one side each is fixed to zero. The other sides s and the
/// next state are then affine functions,
///
///   s = S_t t + S_x x + S_u u + s_0,   x⁺ = X_t t + A' x + B' u + d'
///
/// where t are the sides that are zero: s_j = λ_j and t_j = y_j of a pair with a force, s_j = y_j
/// and t_j = λ_j of one with a gap. Fixing another side is a principal pivot of this table
/// [Cottle, Pang, Stone 1992]. After the constructor nothing allocates.
class FixedModes {
 public:
  explicit FixedModes(const qp::Sizes& sizes);

  /// All pairs get a gap. RT.
  void start(const lcs::Lcs& lcs) noexcept;
  /// Gives the pairs a force that have one in `force` (n_lambda), the others a gap. False where not
  /// all of them get theirs, as λ would not be determined by x and u. RT.
  bool set(const char* force) noexcept;
  /// Fixes the other side of a pair; false, and nothing changes, where λ would not be determined by
  /// x and u. RT.
  bool exchange(int pair) noexcept;

  bool has_force(int pair) const noexcept { return has_force_[pair] != 0; }
  /// Pivots since `start`: each adds its rounding to the table.
  int pivots() const noexcept { return pivots_; }
  /// [S_x S_u] of a pair (n_x + n_u), and its s_0.
  const double* normal(int pair) const noexcept { return &table_(pair, n_lambda_); }
  double offset(int pair) const noexcept { return table_(pair, table_.cols() - 1); }
  /// How s of pair `of`, and entry `of` of x⁺, change with t of a pair.
  double pair_response(int of, int pair) const noexcept { return table_(of, pair); }
  double state_response(int of, int pair) const noexcept { return table_(n_lambda_ + of, pair); }

  /// s and x⁺ of [x; u] (n_x + n_u), t being zero. RT.
  void evaluate(const Eigen::Ref<const Eigen::VectorXd>& xu, Eigen::Ref<Eigen::VectorXd> s,
                Eigen::Ref<Eigen::VectorXd> x_next) const noexcept;
  /// A', B' and d' into a system without pairs. RT.
  void dynamics(lcs::Lcs& lcs) const noexcept;

 private:
  bool is_pivot(int row, int column) const noexcept;
  void pivot(int row, int column) noexcept;
  bool exchange_two(int one, int other) noexcept;

  // rows [s; x⁺], columns [t; x; u; 1]
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> table_;
  Eigen::RowVectorXd row_;
  Eigen::VectorXd column_;
  Eigen::VectorXi has_force_;
  int n_x_, n_lambda_, n_u_, pivots_ = 0;
};

}  // namespace c3rt::c3
