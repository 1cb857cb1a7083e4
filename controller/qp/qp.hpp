#pragma once

#include <memory>

#include <Eigen/Core>

#include "controller/qp/problem.hpp"

namespace c3rt::qp {

enum class QpStatus {
  kSolved,         // the answer was checked: both residuals are small
  kNotConverged,   // the last iterate is returned; its residuals say how far it got
  kInfeasible,     // the constraints cannot be met: shown by multipliers of theirs [Farkas]
  kNotFactorable,  // not convex, or beyond double precision
};

/// What an answer misses, recomputed from the answer itself. Each is relative to the terms that it
/// is the difference of; docs/math.md says how.
struct QpReport {
  QpStatus status;
  int iterations;          // of OSQP or the interior point, or refinements of the direct solution
  double primal_residual;  // of dynamics, bounds and rows
  double dual_residual;    // of stationarity, and of multipliers of rows that are not active
};

/// The quadratic step [C3, eq. (21)]: minimises over x_1 … x_N, λ, u
///
///   Σ_{k<N} (x_k−x_d,k)ᵀQ(·) + u_kᵀR u_k + ρ (z_kᵀ W_k z_k − 2 g_kᵀ z_k)  +  (x_N−x_d,N)ᵀQ_N(·)
///
/// subject to x_{k+1} = A x_k + B u_k + D λ_k + d, x_0 given, and the constraints. The consensus
/// term (z−r)ᵀG(z−r) with r = δ − w is W = G, g = G r; that of C3+ has W = G_λ + Jᵀ G_η J, J = [E F
/// H].
class QpStep {
 public:
  virtual ~QpStep() = default;

  /// Costs and constraints that passed `check`. Of the costs it uses Q, Q_N, R. May allocate.
  virtual void set_costs(const Costs& costs, const Constraints& constraints) = 0;

  /// Takes the system and the W of a new problem, which must outlive the calls of `solve`, and
  /// forgets every earlier iterate, so that the same problem gives the same bits. RT as `solve`.
  /// @param lambda_0  if not null, λ_0 is fixed to it (n_lambda), whatever its bounds
  virtual void start(Horizon lcs, StageMatrices W, const Eigen::VectorXd* lambda_0) noexcept = 0;

  /// Warm-starts from `z`, `x_N` (those of the previous call, if any since `start`) and overwrites
  /// them. x_desired: (n_x × N+1); g, z: (n_z × N). RT: no heap, no lock, no throw (with OSQP: no
  /// heap unless it polishes).
  [[nodiscard]] virtual QpReport solve(double rho, const Eigen::Ref<const Eigen::VectorXd>& x0,
                                       const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                                       const Eigen::Ref<const Eigen::MatrixXd>& g,
                                       Eigen::Ref<Eigen::MatrixXd> z,
                                       Eigen::Ref<Eigen::VectorXd> x_N) noexcept = 0;
};

/// Settings of OSQP. Iteration counts, never times, decide its answer.
struct OsqpSettings {
  int max_iterations;
  double eps;                 // absolute and relative tolerance
  double rho;                 // its own penalty parameter, at the start of every solve
  int adaptive_rho_interval;  // iterations between adaptations of that; 0: never
  bool polish;                // solve the KKT system of the active bounds at the end (allocates)
};

/// Solution by the Riccati recursion over the augmented input ν = [λ; u], refined until the
/// gradient no longer shrinks. Refuses constraints with std::invalid_argument.
std::unique_ptr<QpStep> make_direct_qp(const Sizes& sizes);

/// Solution by a primal-dual interior point method, each Newton step one Riccati recursion, so that
/// time and memory grow linearly with N, after a guess of the active rows that mostly makes it
/// needless. Takes every kind of constraint; without any it is the direct method.
std::unique_ptr<QpStep> make_interior_point_qp(const Sizes& sizes);

/// Solution by OSQP (sparse, z and x_N as variables). Its workspace is set up in the first
/// `set_costs`, and again only where costs or bounds fill other places of the matrices; else it is
/// updated. Where OSQP does not converge, or says that the constraints cannot be met, the interior
/// point decides, so that kSolved and kInfeasible mean the same with every back end.
std::unique_ptr<QpStep> make_osqp_qp(const Sizes& sizes, const OsqpSettings& settings);

}  // namespace c3rt::qp
