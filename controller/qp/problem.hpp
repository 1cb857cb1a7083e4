#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"

namespace c3rt::qp {

/// Sizes of one problem. z_k = [x_k; λ_k; u_k] for k = 0 … N−1; x_N stands alone. Every block
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

/// Weights of a QP over the stages, all symmetric. There is no ½ anywhere:
///
///   Σ_{k<N} (x_k−x_d,k)ᵀ Q (x_k−x_d,k) + u_kᵀ R u_k + (x_N−x_d,N)ᵀ Q_N (x_N−x_d,N)  [C3, eq. (14)]
struct Costs {
  PerStage<Eigen::MatrixXd> Q;  // (n_x × n_x) positive semidefinite
  Eigen::MatrixXd Q_N;          // (n_x × n_x) positive semidefinite
  PerStage<Eigen::MatrixXd> R;  // (n_u × n_u) positive semidefinite
  // (n_z × n_z) where the consensus term of QpStep may have entries; empty: anywhere
  PerStage<Eigen::MatrixXd> G;
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
/// "Costs.Q: expected 34 x 34, got 33 x 33", "Costs.Q_N: expected a positive semidefinite matrix,
/// got the eigenvalue -1". Of per-stage fields with N entries the stage is named: "Costs.Q[3]: …".
/// Of the costs Q, Q_N and R are checked.
void check(const Sizes& sizes);
void check(const Costs& costs, const Sizes& sizes);
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

}  // namespace c3rt::qp
