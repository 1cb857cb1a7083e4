#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "controller/c3/consensus.hpp"
#include "controller/c3/deadline.hpp"
#include "controller/c3/parallel.hpp"
#include "controller/c3/polish.hpp"
#include "controller/c3/problem.hpp"
#include "controller/c3/projection.hpp"
#include "controller/lcs/lcs.hpp"
#include "controller/lcs/lemke.hpp"
#include "controller/qp/qp.hpp"

namespace c3rt::c3 {

using qp::OsqpSettings;
using qp::QpReport;
using qp::QpStatus;
using qp::QpStep;

enum class QpBackend {
  kDirect,         // no constraints
  kInteriorPoint,  // any constraints
  kOsqp,
};

/// Settings of Algorithm 1. Counts alone decide the answer: no time limit is in here.
struct Settings {
  int admm_iterations;    // s: how many QPs are solved; u_0 is from the last
  double rho, rho_scale;  // ρ of the first QP and its factor ρ_s per iteration
  QpBackend qp;
  OsqpSettings osqp;  // used by kOsqp
  ProjectionKind projection;
  int max_nodes;              // of one projection's branch and bound
  bool delta_starts_at_x0;    // δ⁰ = [x0; 0; 0] in all stages instead of 0
  bool project_last = false;  // also project after the last QP, whose u_0 does not depend on it
  bool fix_lambda_0 = false;  // λ_0 = LCP(E x_0 + c, F) in every QP; needs H = 0 at the first stage
  bool trace = false;         // keep every iterate
  AdmmProjectionSettings admm = {};  // used by kAdmm
  int polish = 0;  // QPs at most that improve the plan after Algorithm 1; 0: none [Polish]
};

/// Throws std::invalid_argument naming the field and what was expected.
void check(const Settings& settings);

enum class SolveStatus {
  kOk,
  kTruncated,  // the deadline struck, or a projection hit its bound of nodes: less than Algorithm 1
  kFailed,     // see Solution::failure; z, x_N are of the last complete QP, zero if there is none
};

enum class Failure {
  kNone,
  kNoCosts,     // set_costs was not called
  kWrongSize,   // of the system, x0, x_desired or the start
  kNotFinite,   // NaN or infinity in these, or in what came of them
  kLambda0,     // fix_lambda_0: H is not zero, or the LCP at x_0 has no solution
  kQp,          // see Solution::qp
  kProjection,  // one has no point: see Solution::projection
};

/// What one turn of Algorithm 1 left behind. The copies have n_z rows, with C3+ n_z + n_lambda: the
/// gap η below (Sizes::eta).
struct Iterate {
  double rho;                // of its QP
  Eigen::MatrixXd z;         // (n_copy × N)
  Eigen::VectorXd x_N;       // (n_x)
  Eigen::MatrixXd delta, w;  // (n_copy × N) after projection and dual update; as before without
  QpReport qp;
  int projections;                           // N, or 0 where the turn ended with the QP
  std::vector<ProjectionReport> projection;  // (N)
  double primal_residual;                    // ‖z − δ‖_F
  double dual_residual;                      // ρ ‖δ − δ of the turn before‖_F
  double complementarity_violation;          // of z, as in Solution
};

struct Solution {
  SolveStatus status = SolveStatus::kFailed;
  Failure failure = Failure::kNoCosts;
  Eigen::MatrixXd z;    // (n_copy × N) of the last complete QP: x_k, λ_k, u_k; with C3+ also η_k
  Eigen::VectorXd x_N;  // (n_x)
  Eigen::MatrixXd delta, w;         // (n_copy × N) copies and scaled duals, for the next QP
  double rho = 0.0;                 // of the next QP
  Eigen::VectorXd primal_residual;  // (s) ‖z − δ‖_F after projection i, 0 where there was none
  double complementarity_violation;  // max |min(λ, E x + F λ + H u + c)| over the stages of z
  int iterations = 0;                // complete QPs
  int projections = 0;               // complete rounds of N projections
  int inexact_projections = 0;       // ended by max_nodes
  long branch_nodes = 0;             // QPs of all branch and bounds (pivots with kLcp)
  QpReport qp{};                     // of the last QP
  ProjectionReport projection{};     // of the first stage whose projection failed (kProjection)
  int failed_stage = 0;              // that stage
  // with Settings::polish; where it has a plan, z and x_N are that plan, its forces complementary
  PolishReport polish{};
  PairModes modes;             // (n_lambda × N) of that plan; kNoMode where there is none
  std::vector<Iterate> trace;  // (s) the first `iterations` count; empty unless asked for
  Sizes sizes{};

  auto u_0() const { return sizes.u(z.col(0)); }
};

/// Where Algorithm 1 begins, instead of w⁰ = 0 and δ⁰ = 0, and polish beside Algorithm 1's plan.
struct Start {
  Eigen::MatrixXd delta, w;  // (n_copy × N), or both empty: as without a start
  Eigen::MatrixXd u = {};    // (n_u × N) of a plan that is known, as the last one; or empty
  PairModes modes = {};      // (n_lambda × N) of that plan, as Solution::modes; or empty
};

/// A start from an earlier solution, one stage on: stage k takes the copy, the dual and the inputs
/// of k + 1, the last stage keeps its own. w is rescaled so that the dual ρ w is the same at `rho`.
/// No heap if `start` has the sizes already.
void shift(const Solution& solution, double rho, Start& start);

/// Of that, the plan alone, `stages` on: its inputs and modes; the rest of `start` stays. No heap
/// if these have the sizes already.
void shift_plan(const Solution& solution, int stages, Start& start);

/// Consensus complementarity control [C3, Algorithm 1]:
///
///   z ← QP (21);   δ_k ← projection of z_k + w_k (22);   w_k ← (w_k + z_k − δ_k)/ρ_s;   ρ ← ρ_s ρ
///
/// Start: w = 0. Sizes are fixed by the constructor; after `set_costs` a solve allocates nothing
/// (but see OsqpSettings::polish). Equal problems give equal bits, whatever was solved between them
/// and however many threads projected.
class Solver {
 public:
  /// @param parallel  threads for the N projections
  /// @throws std::invalid_argument as `check`
  Solver(const Sizes& sizes, const Settings& settings, const Parallel& parallel = {});

  /// @throws std::invalid_argument as `check`; also if there are constraints and the back end is
  /// direct
  void set_costs(const Costs& costs, const Constraints& constraints = {});

  /// @param x_desired  (n_x × N+1)
  /// The reference is valid until the next call. RT: no heap, no lock, no throw.
  const Solution& solve(const lcs::Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
                        const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                        const Deadline& deadline = {}, const Start* start = nullptr) noexcept;

  /// The same with one system per stage (N of them).
  const Solution& solve(const std::vector<lcs::Lcs>& lcs,
                        const Eigen::Ref<const Eigen::VectorXd>& x0,
                        const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                        const Deadline& deadline = {}, const Start* start = nullptr) noexcept;

  /// Rows of a stage's copy: n_z, and what the projection appends (C3+: n_lambda).
  int n_copy() const noexcept { return n_copy_; }

 private:
  /// A projection of its own for each thread, and the system that it was started with.
  struct Worker {
    std::unique_ptr<Projection> projection;
    const lcs::Lcs* lcs;
  };
  /// What `project_stage` needs of a round of projections.
  struct Round {
    Solver* solver;
    Horizon lcs;
    const Deadline* deadline;
  };

  Failure refuse(Horizon lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
                 const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                 const Start* start) const noexcept;
  const Solution& run(Horizon lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
                      const Eigen::Ref<const Eigen::MatrixXd>& x_desired, const Deadline& deadline,
                      const Start* start) noexcept;
  const Eigen::VectorXd* fixed_lambda_0() const noexcept;
  bool finish(Horizon lcs) noexcept;
  void reset() noexcept;
  const Solution& fail(Failure failure) noexcept;
  void polish(Horizon lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
              const Eigen::Ref<const Eigen::MatrixXd>& x_desired, const Deadline& deadline,
              const Start* start) noexcept;
  Failure find_lambda_0(const lcs::Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x0) noexcept;
  /// δ ← projections of z + w; false if the solve cannot go on (see solution_)
  bool project(Horizon lcs, const Deadline& deadline) noexcept;
  static void project_stage(void* round, int k, int worker) noexcept;
  void record(Horizon lcs, double rho, bool projected) noexcept;
  double complementarity_violation(Horizon lcs) noexcept;

  Sizes sizes_;
  Settings settings_;
  Parallel parallel_;
  std::unique_ptr<Consensus> consensus_;
  int n_copy_;
  bool has_costs_ = false;
  std::unique_ptr<QpStep> qp_;
  std::vector<Worker> workers_;
  std::unique_ptr<Polish> polish_;  // none where there is nothing to polish
  lcs::Lemke lemke_;
  Eigen::VectorXd lambda_0_;
  Eigen::MatrixXd z_, g_;  // work: a z or δ is published only when it is complete
  Eigen::MatrixXd delta_, v_;
  std::vector<ProjectionReport> reports_;
  Eigen::VectorXd x_N_, y_;
  double dual_residual_ = 0.0;
  Solution solution_;
};

}  // namespace c3rt::c3
