#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "controller/c3/deadline.hpp"
#include "controller/c3/problem.hpp"
#include "controller/c3/projection.hpp"
#include "controller/c3/qp.hpp"
#include "controller/lcs/lcs.hpp"

namespace c3rt::c3 {

enum class QpBackend { kDirect, kOsqp };
enum class ProjectionKind { kMiqp, kLcp };

/// Settings of Algorithm 1. Counts alone decide the answer: no time limit is in here.
struct Settings {
  int admm_iterations;         // s: how many QPs are solved; u_0 is from the last
  double rho, rho_scale;       // ρ of the first QP and its factor ρ_s per iteration
  QpBackend qp;
  OsqpSettings osqp;           // used by kOsqp
  ProjectionKind projection;
  int max_nodes;               // of one projection's branch and bound
  bool delta_starts_at_x0;     // δ⁰ = [x0; 0; 0] in all stages instead of 0
  bool project_last = false;   // also project after the last QP, whose u_0 does not depend on it
};

/// Throws std::invalid_argument naming the field and what was expected.
void check(const Settings& settings);

enum class SolveStatus {
  kOk,
  kTruncated,  // the deadline struck, or a projection hit its bound of nodes: less than Algorithm 1
  kFailed,     // see Solution::failure; z, x_N are zero
};

enum class Failure {
  kNone,
  kNoCosts,     // set_costs was not called
  kWrongSize,   // of the system, x0 or x_desired
  kNotFinite,   // NaN or infinity in the system, x0 or x_desired, or in what came of them
  kQp,          // see Solution::qp
  kProjection,  // no point of the LCP's set was found
};

struct Solution {
  SolveStatus status = SolveStatus::kFailed;
  Failure failure = Failure::kNoCosts;
  Eigen::MatrixXd z;    // (n_z × N) of the last complete QP: x_k, λ_k, u_k
  Eigen::VectorXd x_N;  // (n_x)
  Eigen::MatrixXd delta, w;          // (n_z × N) copies and scaled duals, as the next QP would use
  Eigen::VectorXd primal_residual;   // (s) ‖z − δ‖_F after projection i, 0 where there was none
  double complementarity_violation;  // max |min(λ, E x + F λ + H u + c)| over the stages of z
  int iterations = 0;                // complete QPs
  int projections = 0;               // complete rounds of N projections
  int inexact_projections = 0;       // ended by max_nodes
  long branch_nodes = 0;             // QPs of all branch and bounds (pivots with kLcp)
  QpReport qp{};                     // of the last QP
  int n_u = 0;

  auto u_0() const { return z.col(0).tail(n_u); }
};

/// Consensus complementarity control [C3, Algorithm 1]:
///
///   z ← QP (21);   δ_k ← projection of z_k + w_k (22);   w_k ← (w_k + z_k − δ_k)/ρ_s;   ρ ← ρ_s ρ
///
/// Start: w = 0. Sizes are fixed by the constructor; after `set_costs` a solve allocates nothing
/// (but see OsqpSettings::polish). Equal problems give equal bits, whatever was solved between them.
class Solver {
 public:
  /// @throws std::invalid_argument as `check`
  Solver(const Sizes& sizes, const Settings& settings);

  /// @throws std::invalid_argument as `check`; also if there are bounds and the back end is direct
  void set_costs(const Costs& costs, const Bounds& bounds = {});

  /// @param x_desired  (n_x × N+1)
  /// The reference is valid until the next call. RT: no heap, no lock, no throw.
  const Solution& solve(const lcs::Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
                        const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                        const Deadline& deadline = {}) noexcept;

  /// The same with one system per stage (N of them).
  const Solution& solve(const std::vector<lcs::Lcs>& lcs,
                        const Eigen::Ref<const Eigen::VectorXd>& x0,
                        const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                        const Deadline& deadline = {}) noexcept;

 private:
  Failure refuse(Horizon lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
                 const Eigen::Ref<const Eigen::MatrixXd>& x_desired) const noexcept;
  const Solution& run(Horizon lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
                      const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                      const Deadline& deadline) noexcept;
  void reset() noexcept;
  const Solution& fail(Failure failure) noexcept;
  /// δ ← projections of z + w; false if the solve cannot go on (see solution_)
  bool project(Horizon lcs, const Deadline& deadline) noexcept;
  double complementarity_violation(Horizon lcs) noexcept;

  Sizes sizes_;
  Settings settings_;
  bool has_costs_ = false;
  std::unique_ptr<QpStep> qp_;
  std::unique_ptr<Projection> projection_;
  Eigen::MatrixXd z_, delta_, r_;  // work: a z or δ is published only when it is complete
  Eigen::VectorXd x_N_, v_, y_;
  Solution solution_;
};

}  // namespace c3rt::c3
