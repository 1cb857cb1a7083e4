#pragma once

#include <vector>

#include <Eigen/Core>

namespace c3rt::c3 {

/// A small dense QP in the space of its constraints. For min ½ eᵀ U e subject to s = t + C e, the
/// minimiser is e = U⁻¹ Cᵀ μ, so only K = C U⁻¹ Cᵀ matters:
///
///   min ½ μᵀ K μ   with   s = t + K μ,   s_i ≥ 0 ⊥ μ_i ≥ 0,   or s_i = 0, μ_i free if i is pinned
///
/// Dual active set method [Goldfarb, Idnani 1983]: a pinned constraint is added to a solved state,
/// and `solve` continues from there. Constraints are normalised by the caller: K_ii = 1 (or 0).
struct DualQp {
  enum class Status { kSolved, kInfeasible, kAboveBound, kStuck };

  explicit DualQp(Eigen::Index size);

  /// The unconstrained minimiser: μ = 0, s = t, nothing pinned.
  void start(const Eigen::VectorXd& t) noexcept;

  /// Solves from the present state. Returns early once ½ μᵀ K μ is above `bound`. `tolerance`: how
  /// far s may be below zero. RT: no heap, no lock, no throw.
  Status solve(const Eigen::MatrixXd& K, const Eigen::VectorXd& t, double tolerance,
               double bound) noexcept;

  /// Solves the active constraints once more from the present multipliers, which takes out the
  /// rounding that the path to them has accumulated. RT: no heap, no lock, no throw.
  void refine(const Eigen::MatrixXd& K, const Eigen::VectorXd& t) noexcept;

  /// Copies what `solve` needs, nothing more.
  void copy_from(const DualQp& other) noexcept;

  Eigen::VectorXd mu, s;
  std::vector<char> pinned;
  double objective = 0.0;         // ½ μᵀ K μ
  int n_active = 0;
  std::vector<int> active;        // indices with s = 0 held, the first n_active count
  // Cholesky factor of K over `active`, its lower triangle
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> L;

 private:
  void append(double diagonal) noexcept;
  void remove(int position) noexcept;

  std::vector<char> is_active_;
  Eigen::VectorXd l_, r_, direction_;
};

}  // namespace c3rt::c3
