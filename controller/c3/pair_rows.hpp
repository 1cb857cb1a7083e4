#pragma once

#include <Eigen/Core>

#include "controller/c3/problem.hpp"

namespace c3rt::c3 {

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
  /// t ← the divided functionals at `v`. Returns the largest.
  double evaluate(const Eigen::Ref<const Eigen::VectorXd>& v) noexcept;

  Sizes sizes;
  Eigen::MatrixXd J;      // [0 I 0; E F H] (2 n_lambda × n_z)
  Eigen::MatrixXd C;      // (n_z × 2 n_lambda) columns of length 1, or 0
  Eigen::VectorXd scale;  // 1/length that they had, 1 if 0
  Eigen::VectorXd t;
  const Eigen::VectorXd* c = nullptr;
};

/// U with something for the directions that have no weight: 1e-8 of the largest; 1 if none has.
Eigen::MatrixXd definite(const Eigen::MatrixXd& U);

}  // namespace c3rt::c3
