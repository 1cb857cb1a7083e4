#pragma once

#include <Eigen/Core>

#include "controller/c3/problem.hpp"

namespace c3rt::c3 {

/// How far a QP on the rows below may be from its constraints, of the largest |t| (PairRows).
inline constexpr double kFeasible = 1e-11;

/// The 2 n_lambda functionals of δ that the LCP is made of, [λ; y] = J δ + [0; c]. With U = T⁻ᵀ T⁻¹
/// and δ = v + T f the distance to v is ‖f‖ and the functionals are J v + [0; c] + (J T) f. Each is
/// divided by the length of its row of J T, so that s² is the least ‖f‖² that bringing that one to
/// zero costs, whatever its unit.
struct PairRows {
  explicit PairRows(const Sizes& sizes);

  /// J of a system. RT: no heap, no lock, no throw.
  void assign(const lcs::Lcs& lcs) noexcept;
  /// Divides the columns of C = (J T)ᵀ, which the caller has just written, by their lengths.
  void normalise() noexcept;
  /// t ← the divided functionals at `v`; of a functional that is constant only the sign, with the
  /// size of the largest.
  void evaluate(const Eigen::Ref<const Eigen::VectorXd>& v) noexcept;

  /// Whether every pair of `delta`, whose forces are not negative, has an open side and a closed
  /// one or two closed ones: a force that is 0, a gap that is it within kInSet of its terms at v
  /// and delta or of the way that `evaluate` (the last call) found to the farthest row.
  bool holds(const Eigen::Ref<const Eigen::VectorXd>& v,
             const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept;
  static constexpr double kInSet = 1e-9;

  Sizes sizes;
  Eigen::MatrixXd J;      // [0 I 0; E F H] (2 n_lambda × n_z)
  Eigen::MatrixXd C;      // (n_z × 2 n_lambda) columns of length 1, or 0
  Eigen::VectorXd scale;  // 1/length that they had, 0 if that was 0
  int n_constant = 0;     // columns of length 0
  Eigen::VectorXd t;
  double largest = 0.0;  // |t_i|
  const Eigen::VectorXd* c = nullptr;
};

/// U with something for the directions that have no weight: 1e-8 of the largest; 1 if none has.
Eigen::MatrixXd definite(const Eigen::MatrixXd& U);

}  // namespace c3rt::c3
