#pragma once

#include <memory>

#include <Eigen/Core>

#include "controller/c3/problem.hpp"

namespace c3rt::c3 {

/// The copies of a projection and the consensus term of the QP step, ρ (z_kᵀ W_k z_k − 2 g_kᵀ z_k):
/// what binds the z of the QP to δ − w. After `set_weights` nothing allocates.
class Consensus {
 public:
  virtual ~Consensus() = default;

  /// Rows of a stage's copy: z, and what the projection appends to it.
  virtual int n_copy() const noexcept = 0;

  /// Costs that passed `check` with its projection. May allocate.
  virtual void set_weights(const Costs& costs) = 0;
  /// Costs::G as the QP step is to know it.
  virtual PerStage<Eigen::MatrixXd> pattern(const Costs& costs) const = 0;

  /// Takes the systems of a problem, which must outlive the calls of everything below. Returns W,
  /// valid until the next call. RT.
  virtual StageMatrices start(Horizon lcs) noexcept = 0;
  /// Before the last QP, which goes towards δ (n_copy × N): W of it, of which `set_linear_term`
  /// then knows; null where it is a QP as the others. RT.
  virtual StageMatrices finish(const Eigen::MatrixXd& /*delta*/) noexcept { return {nullptr, 0}; }
  /// g ← the linear term for δ and w (n_copy × N). RT.
  virtual void set_linear_term(const Eigen::MatrixXd& delta, const Eigen::MatrixXd& w,
                               Eigen::MatrixXd& g) noexcept = 0;
  /// Fills the rows below z of a copy (n_copy × N) whose first n_z rows are z. RT.
  virtual void append(Eigen::MatrixXd& copy) noexcept = 0;
};

/// The copy is z itself, W = G and g = G (δ − w)                                   [C3, eq. (21)].
std::unique_ptr<Consensus> make_consensus(const Sizes& sizes);

}  // namespace c3rt::c3
