#pragma once

#include <Eigen/Core>

namespace c3rt::lcs {

/// An LCP's answer beside the terms that its rows are added up from.
struct LcpMiss {
  double residual;  // max |min(λ, F λ + q)|
  double
      relative;  // largest |y_i| where λ_i > 0, or −y_i, beside what rounding may leave: see below
  [[nodiscard]] bool accepted() const noexcept { return relative <= 1.0; }
};

/// The one test that an answer of LCP(q, F) passes before it is used: λ ≥ 0, and every gap
/// y = F λ + q is 0 where λ_i > 0, and not negative, to within the smaller of
///
///   1e-10 (terms_i + Σ_j |F_ij| λ_j) + 1e-12 Σ_j |F_ij| C_j max_k λ_k/C_k
///   1e-4 max_k (R_k terms_k) / R_i
///
/// First what row i is added up from, `terms` being those of q, |c| + |E x| + |H u|, or |q|; and
/// what the largest force, by its rounding, leaves in every other one. R and C are those of
/// `equilibrate`, so that forces, and rows, are compared in units of one size. Then what the rows
/// of an answer are made of whose forces are no larger than they need be: a gap of −1 is not
/// rounding's, however huge a force is beside it. λ that is not finite, or so large that y has no
/// digits left, is refused. RT: no heap, no lock, no throw.
[[nodiscard]] LcpMiss miss(const Eigen::Ref<const Eigen::MatrixXd>& F,
                           const Eigen::Ref<const Eigen::VectorXd>& q,
                           const Eigen::Ref<const Eigen::VectorXd>& terms,
                           const Eigen::Ref<const Eigen::VectorXd>& R,
                           const Eigen::Ref<const Eigen::VectorXd>& C,
                           const Eigen::Ref<const Eigen::VectorXd>& lambda) noexcept;

/// Whether `lambda` passes `miss` by far in the units as they are given, R = C = 1: every gap to
/// within 1e-12 of what it is added up from, and no more than 1e-4 of the largest of `terms`.
/// @param residual max |min(λ, F λ + q)|, if so
/// RT: no heap, no lock, no throw.
[[nodiscard]] bool is_exact(const Eigen::Ref<const Eigen::MatrixXd>& F,
                            const Eigen::Ref<const Eigen::VectorXd>& q,
                            const Eigen::Ref<const Eigen::VectorXd>& terms,
                            const Eigen::Ref<const Eigen::VectorXd>& lambda,
                            double& residual) noexcept;

/// Powers of 2, R and C, that bring the largest entry of every row and column of R [F C, terms]
/// near 1 [Ruiz 2001]: the largest, because many of the small ones are rounding's. RT: no heap, no
/// lock, no throw.
void equilibrate(const Eigen::Ref<const Eigen::MatrixXd>& F,
                 const Eigen::Ref<const Eigen::VectorXd>& terms, Eigen::Ref<Eigen::VectorXd> R,
                 Eigen::Ref<Eigen::VectorXd> C) noexcept;

}  // namespace c3rt::lcs
