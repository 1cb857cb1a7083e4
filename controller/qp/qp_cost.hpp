#pragma once

#include <Eigen/Core>

#include "controller/qp/problem.hpp"

namespace c3rt::qp {

/// The cost of the QP step (21), halved: Σ_{k<N} ½ z_kᵀ H_k z_k − h_kᵀ z_k, and the like of x_N,
/// with H_k = ρ W_k + blkdiag(Q, 0, R) and h_k = ρ g_k + [Q x_d,k; 0; 0]. After `set_costs` nothing
/// allocates.
class QpCost {
 public:
  explicit QpCost(const Sizes& sizes);

  void set_costs(const Costs& costs);
  /// Takes the W of a problem, which must outlive the calls of everything below. RT.
  void start(StageMatrices W) noexcept;
  /// H for this ρ. RT.
  void build_hessian(double rho) noexcept;
  /// h for these targets and the ρ of `build_hessian`. RT.
  void set_linear_term(const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                       const Eigen::Ref<const Eigen::MatrixXd>& g) noexcept;

  /// The ρ of the last `build_hessian`; 0 if none since `start`.
  double rho() const noexcept { return rho_; }
  StageMatrices H() const noexcept { return {H_.data(), stride_}; }
  const Eigen::MatrixXd& H_N() const noexcept { return Q_N_; }

  /// Largest terms of a gradient's components in states and in inputs: a state is known to its
  /// rounding at best, and what the weights make of that no gradient can fall below.
  struct Terms {
    double state, input;
  };
  /// Of a gradient that `gradient` gave, within a factor of 2. RT.
  Terms terms(const Eigen::MatrixXd& gradient, const Eigen::VectorXd& gradient_N) const noexcept;
  /// H z − h, in z (n_z × N) and x_N. RT.
  void gradient(const Eigen::Ref<const Eigen::MatrixXd>& z,
                const Eigen::Ref<const Eigen::VectorXd>& x_N, Eigen::MatrixXd& gradient,
                Eigen::VectorXd& gradient_N) const noexcept;

 private:
  Sizes sizes_;
  PerStage<Eigen::MatrixXd> Q_, R_;
  Eigen::MatrixXd Q_N_;
  StageMatrices W_{nullptr, 0};
  int stride_ = 0;  // of H_: 0 where one serves all stages
  double rho_ = 0.0;
  std::vector<Eigen::MatrixXd> H_;
  Eigen::MatrixXd h_;    // (n_z × N)
  Eigen::VectorXd h_N_;  // (n_x)
};

}  // namespace c3rt::qp
