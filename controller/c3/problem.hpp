#pragma once

#include <Eigen/Core>

#include "controller/c3/projection/registry.hpp"
#include "controller/qp/problem.hpp"

namespace c3rt::c3 {

// what a problem of Algorithm 1 has of the QPs that it solves
using qp::any;
using qp::check;
using qp::Constraints;
using qp::cost;
using qp::Horizon;
using qp::PerStage;
using qp::Sizes;
using qp::StageMatrices;

/// Weights of the convex projection [C3, eq. (24)]; its weight of λ is F + ε I.
struct ConvexWeights {
  Eigen::MatrixXd Q_x;   // (n_x × n_x) positive definite
  Eigen::MatrixXd Q_u;   // (n_u × n_u) positive definite
  double alpha = 0.0;    // in [0, 1]: 0 makes the answer complementary
  double epsilon = 0.0;  // ≥ 0
};

/// Weights of C3+, of λ and of the gap η = E x + F λ + H u + c, each (n_lambda). g: of the
/// consensus term in the QP, non-negative; u: of the projection, positive.
struct PlusWeights {
  Eigen::VectorXd g_lambda, g_eta, u_lambda, u_eta;
  /// Empty, or 1 and more: the last of two or more QPs goes towards δ itself instead of δ − w, and
  /// this multiplies g_lambda of a pair whose force is 0 in δ, else its g_eta.
  Eigen::VectorXd final_scale = {};
};

/// Weights of Algorithm 1, all symmetric: those of qp::Costs and of
///
///   Σ_{k<N} (z_k−δ_k+w_k)ᵀ ρ G (z_k−δ_k+w_k)                                      [C3, eq. (21)]
///
/// with G (n_z × n_z) positive semidefinite; definite in λ and, with R, in u; empty with C3+. The
/// projection minimises (δ−z−w)ᵀ U (δ−z−w)                                         [C3, eq. (23)].
struct Costs : qp::Costs {
  Eigen::MatrixXd U;  // (n_z × n_z) positive semidefinite; may be empty unless kMiqp, kAdmm
  ConvexWeights convex = {};  // kConvex
  PlusWeights plus = {};      // kPlus
};

/// As qp::check: "Costs.U: expected 34 x 34, got 33 x 33".
void check(const Costs& costs, const Sizes& sizes, ProjectionKind projection);

}  // namespace c3rt::c3
