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
  kNone,       // no point of the set was found: there is none, or the search ended too early
  kNotFinite,  // NaN or infinity came in
};

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

  /// A weight that passed `check`. May allocate.
  virtual void set_weight(const Eigen::MatrixXd& U) = 0;

  /// Computes what depends on E, F, H alone; `lcs` must outlive the calls of `project`.
  /// RT: no heap, no lock, no throw.
  virtual void start(const lcs::Lcs& lcs) noexcept = 0;

  /// Unless there is a point (kSolved, kNodeLimit, kDeadline) delta is v. RT: no heap, no lock, no
  /// throw.
  [[nodiscard]] virtual ProjectionReport project(const Eigen::Ref<const Eigen::VectorXd>& v,
                                                 Eigen::Ref<Eigen::VectorXd> delta,
                                                 const Deadline& deadline) noexcept = 0;
};

/// The exact minimiser of (δ−v)ᵀ U (δ−v) [C3, eq. (23) with M → ∞], by branch and bound over the
/// complementary pairs. Directions of zero weight in U get 1e-8 of the largest weight.
std::unique_ptr<Projection> make_miqp_projection(const Sizes& sizes, int max_nodes);

/// δ_x = v_x, δ_u = v_u, δ_λ = LCP(E v_x + H v_u + c, F) by Lemke's method, regularised where the
/// plain one fails.
std::unique_ptr<Projection> make_lcp_projection(const Sizes& sizes);

}  // namespace c3rt::c3
