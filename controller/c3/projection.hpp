#pragma once

#include <memory>

#include <Eigen/Core>

#include "controller/c3/deadline.hpp"
#include "controller/c3/problem.hpp"

namespace c3rt::c3 {

enum class ProjectionStatus {
  kSolved,
  kNodeLimit,  // a point of the set, but the search ended (nodes, or pivots of one node's QP)
               // before it was proved to be the nearest
  kDeadline,   // the same, ended by the deadline
  // without a point:
  kEmpty,       // there is none: the set is empty, or the inequalities have no common point
  kNotFound,    // none was found before the search ended: max_nodes, the deadline, pivots, a ray
  kNotConvex,   // F + ε I of (24) is not positive semidefinite
  kInaccurate,  // one was found, but of its digits none are left
  kNotFinite,   // NaN or infinity came in
};

constexpr bool has_point(ProjectionStatus status) noexcept {
  return status == ProjectionStatus::kSolved || status == ProjectionStatus::kNodeLimit ||
         status == ProjectionStatus::kDeadline;
}

struct ProjectionReport {
  ProjectionStatus status;
  long nodes;        // QPs solved by branch and bound; pivots of Lemke's method
  double objective;  // (δ−v)ᵀ U (δ−v)
};

/// The projection step: δ = projection of v = z_k + w_k on
///
///   { (x, λ, u) : 0 ≤ λ ⊥ E x + F λ + H u + c ≥ 0 }                                 [C3, eq. (22)]
class Projection {
 public:
  virtual ~Projection() = default;

  /// Costs that passed `check` with this kind of projection. May allocate.
  virtual void set_weights(const Costs& costs) = 0;

  /// Computes what depends on E, F, H alone; `lcs` must outlive the calls of `project`.
  /// RT: no heap, no lock, no throw.
  virtual void start(const lcs::Lcs& lcs) noexcept = 0;

  /// Depends on v alone, not on earlier calls. Unless `has_point` delta is v. RT: no heap, no lock,
  /// no throw.
  [[nodiscard]] virtual ProjectionReport project(const Eigen::Ref<const Eigen::VectorXd>& v,
                                                 Eigen::Ref<Eigen::VectorXd> delta,
                                                 const Deadline& deadline) noexcept = 0;
};

/// The exact minimiser of (δ−v)ᵀ U (δ−v) [C3, eq. (23) with M → ∞], by branch and bound over the
/// complementary pairs. Directions of zero weight in U get 1e-8 of the largest weight. kInaccurate
/// where weights or units lie so far apart that no digits of a point of the set are left.
std::unique_ptr<Projection> make_miqp_projection(const Sizes& sizes, int max_nodes);

/// δ_x = v_x, δ_u = v_u, δ_λ = LCP(E v_x + H v_u + c, F) by Lemke's method; kNotFound
/// where that finds no answer that `lcs::miss` accepts.
std::unique_ptr<Projection> make_lcp_projection(const Sizes& sizes);

/// ρ of the first turn of the nested ADMM, beside U, its factor per turn and how many turns at
/// most.
struct AdmmProjectionSettings {
  double rho = 10.0, rho_scale = 1.0;
  int iterations = 10;
};

/// The QCQP of [C3, V.B.3c] by a nested ADMM of a QP over the inequalities and a one-constraint
/// QCQP for λᵀ y = 0, solved by bisection; both distances in the norm of U, of all copies the one
/// nearest to the set. That need not lie in it. kEmpty where the inequalities have no common point.
std::unique_ptr<Projection> make_admm_projection(const Sizes& sizes,
                                                 const AdmmProjectionSettings& settings);

/// The convex QP (24) with the norms squared:
///
///   min ½‖δ_x−v_x‖²_Qx + ½‖δ_u−v_u‖²_Qu + ½ α ‖δ_λ−v_λ‖²_S + ½ (1−α) ‖δ_λ‖²_S,   S = F + ε I,
///   subject to E δ_x + F δ_λ + H δ_u + c ≥ 0, δ_λ ≥ 0
///
/// Its complementarity violation is linear in α [C3, Lemma 3]. Of F in S only the symmetric part
/// counts, which has to be positive semidefinite: otherwise kNotConvex. Where S is singular, 1e-8
/// of its diagonal is added to it. kEmpty where the constraints have no common point.
std::unique_ptr<Projection> make_convex_projection(const Sizes& sizes);

/// C3+ [C3+, III]: v = [z; η] + w has the gap variables; pair by pair the nearest point of
/// { λ ≥ 0, η ≥ 0, λ η = 0 } in the norm u_λ (λ−·)² + u_η (η−·)². δ_x = v_x, δ_u = v_u.
std::unique_ptr<Projection> make_plus_projection(const Sizes& sizes);

}  // namespace c3rt::c3
