#pragma once

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"

namespace c3rt::c3 {

/// Sizes of one C3 problem. z_k = [x_k; λ_k; u_k] for k = 0 … N−1; x_N stands alone. Every block
/// offset in z comes from here.
struct Sizes {
  int n_x, n_lambda, n_u, N;

  int n_z() const noexcept { return n_x + n_lambda + n_u; }
  template <typename Z>
  auto x(Z&& z) const {
    return z.head(n_x);
  }
  template <typename Z>
  auto lambda(Z&& z) const {
    return z.segment(n_x, n_lambda);
  }
  template <typename Z>
  auto u(Z&& z) const {
    return z.tail(n_u);
  }
};

/// Weights of Algorithm 1, all symmetric. There is no ½ anywhere:
///
///   Σ_{k<N} (x_k−x_d,k)ᵀ Q (x_k−x_d,k) + u_kᵀ R u_k + (x_N−x_d,N)ᵀ Q_N (x_N−x_d,N)  [C3, eq. (14)]
///   + Σ_{k<N} (z_k−δ_k+w_k)ᵀ ρ G (z_k−δ_k+w_k)                                    [C3, eq. (21)]
///
/// and the projection minimises (δ−z−w)ᵀ U (δ−z−w)                                 [C3, eq. (23)].
struct Costs {
  Eigen::MatrixXd Q;    // (n_x × n_x) positive semidefinite
  Eigen::MatrixXd Q_N;  // (n_x × n_x) positive semidefinite
  Eigen::MatrixXd R;    // (n_u × n_u) positive semidefinite
  Eigen::MatrixXd G;    // (n_z × n_z) positive semidefinite; definite in λ and, with R, in u
  Eigen::MatrixXd U;    // (n_z × n_z) positive semidefinite
};

/// Box bounds of the QP step (the set C), never of the projection; ±infinity where there is none.
/// Empty vectors mean no bound. They hold for λ_k, u_k (k = 0 … N−1) and x_k (k = 1 … N−1).
struct Bounds {
  Eigen::VectorXd x_min, x_max;            // (n_x)
  Eigen::VectorXd lambda_min, lambda_max;  // (n_lambda)
  Eigen::VectorXd u_min, u_max;            // (n_u)
};

/// Throws std::invalid_argument naming the field and what was expected:
/// "Costs.U: expected 34 x 34, got 33 x 33", "Costs.G: expected a positive semidefinite matrix, got
/// the eigenvalue -1".
void check(const Sizes& sizes);
void check(const Costs& costs, const Sizes& sizes);
void check(const Bounds& bounds, const Sizes& sizes);

/// The systems of the N stages: one for all of them (stride 0) or one each (stride 1).
struct Horizon {
  const lcs::Lcs* first;
  int stride;
  const lcs::Lcs& operator[](int k) const noexcept { return first[k * stride]; }
};

}  // namespace c3rt::c3
