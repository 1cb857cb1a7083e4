#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"

namespace c3rt::c3 {

/// Sizes of one C3 problem. z_k = [x_k; λ_k; u_k] for k = 0 … N−1; x_N stands alone. Every block
/// offset in z comes from here. n_lambda = 0 is a model without contacts, n_u = 0 one without
/// inputs.
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
    return z.segment(n_x + n_lambda, n_u);
  }
  /// C3+ appends the gap variables: [z_k; η_k].
  template <typename Z>
  auto eta(Z&& z) const {
    return z.segment(n_z(), n_lambda);
  }
};

/// What every stage k = 0 … N−1 has of one kind: one for all of them, or N.
template <typename T>
class PerStage {
 public:
  PerStage() : values_(1) {}
  PerStage(T one) : values_{std::move(one)} {}
  PerStage(std::vector<T> each) : values_(std::move(each)) {}
  template <typename Derived>
  PerStage(const Eigen::EigenBase<Derived>& one) : values_{T(one.derived())} {}

  int count() const noexcept { return static_cast<int>(values_.size()); }
  const T* data() const noexcept { return values_.data(); }
  const T& operator[](int k) const noexcept { return values_[values_.size() == 1 ? 0 : k]; }
  T& operator[](int k) noexcept { return values_[values_.size() == 1 ? 0 : k]; }

 private:
  std::vector<T> values_;
};

enum class ProjectionKind {
  kMiqp,    // exact, by branch and bound                                       [C3, eq. (23)]
  kLcp,     // λ from the LCP at the x and u of the QP                          [C3, V.B.3b]
  kAdmm,    // QCQP by a nested ADMM with bisection                             [C3, V.B.3c]
  kConvex,  // one convex QP that trades complementarity against distance        [C3, eq. (24)]
  kPlus,    // C3+: gap variables in the QP, projection pair by pair            [C3+, III]
};

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
};

/// Weights of Algorithm 1, all symmetric. There is no ½ anywhere:
///
///   Σ_{k<N} (x_k−x_d,k)ᵀ Q (x_k−x_d,k) + u_kᵀ R u_k + (x_N−x_d,N)ᵀ Q_N (x_N−x_d,N)  [C3, eq. (14)]
///   + Σ_{k<N} (z_k−δ_k+w_k)ᵀ ρ G (z_k−δ_k+w_k)                                    [C3, eq. (21)]
///
/// and the projection minimises (δ−z−w)ᵀ U (δ−z−w)                                 [C3, eq. (23)].
struct Costs {
  PerStage<Eigen::MatrixXd> Q;  // (n_x × n_x) positive semidefinite
  Eigen::MatrixXd Q_N;          // (n_x × n_x) positive semidefinite
  PerStage<Eigen::MatrixXd> R;  // (n_u × n_u) positive semidefinite
  PerStage<Eigen::MatrixXd> G;  // (n_z × n_z) positive semidefinite; definite in λ and, with R, in
                                // u; empty with C3+
  Eigen::MatrixXd U;  // (n_z × n_z) positive semidefinite; may be empty unless kMiqp, kAdmm
  ConvexWeights convex = {};  // kConvex
  PlusWeights plus = {};      // kPlus
};

/// The set C of the QP step, never of the projection; ±infinity where there is no bound, an empty
/// vector for none at all. Bounds hold for λ_k, u_k (k = 0 … N−1) and x_k (k = 1 … N−1); rows hold
/// at k = 0 … N−1, but one of x alone is left out at k = 0, where x is given.
struct Constraints {
  PerStage<Eigen::VectorXd> x_min, x_max;            // (n_x)
  PerStage<Eigen::VectorXd> lambda_min, lambda_max;  // (n_lambda)
  PerStage<Eigen::VectorXd> u_min, u_max;            // (n_u)
  Eigen::VectorXd x_N_min, x_N_max;                  // (n_x) of the last state
  PerStage<Eigen::MatrixXd> C;                       // (rows × n_z): C_min ≤ C z_k ≤ C_max
  PerStage<Eigen::VectorXd> C_min, C_max;            // (rows)
};

/// Whether there is a finite bound anywhere.
bool any(const Constraints& constraints);

/// The cost (14) of states, inputs and a last state, x_0's constant term included.
/// @param x_desired (n_x × N+1)
/// @param z         (n_z or more × N)
double cost(const Costs& costs, const Sizes& sizes,
            const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
            const Eigen::Ref<const Eigen::MatrixXd>& z,
            const Eigen::Ref<const Eigen::VectorXd>& x_N);

/// Throws std::invalid_argument naming the field and what was expected:
/// "Costs.U: expected 34 x 34, got 33 x 33", "Costs.G: expected a positive semidefinite matrix, got
/// the eigenvalue -1". Of per-stage fields with N entries the stage is named: "Costs.G[3]: …".
void check(const Sizes& sizes);
void check(const Costs& costs, const Sizes& sizes, ProjectionKind projection);
void check(const Constraints& constraints, const Sizes& sizes);

/// The systems of the N stages: one for all of them (stride 0) or one each (stride 1).
struct Horizon {
  const lcs::Lcs* first;
  int stride;
  const lcs::Lcs& operator[](int k) const noexcept { return first[k * stride]; }
};

/// Matrices of the N stages, in the same way.
struct StageMatrices {
  const Eigen::MatrixXd* first;
  int stride;
  const Eigen::MatrixXd& operator[](int k) const noexcept { return first[k * stride]; }
};

}  // namespace c3rt::c3
