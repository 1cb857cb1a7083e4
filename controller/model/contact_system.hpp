#pragma once
// A rigid-body system with frictional contacts, linearised to an LCS [C3, section IV].
#include <algorithm>

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"

namespace c3rt::model {

/// The gap of an end effector that pushes a body: what overlaps touches, no more. Overlap is an
/// error of the body's size or of its measured pose. As a gap it would make every plan begin with
/// the body leaping out of it, and no plan would push.
inline double no_overlap(double distance) noexcept { return std::max(0.0, distance); }

/// The multi-contact model (2)-(3) evaluated at (q*, v*, u*). n_c contacts, n_e edges of the
/// friction cone each. Velocities v are the generalised velocities with q̇ = N_q v (a quaternion has
/// 4 coordinates but 3 velocities).
struct ContactSystem {
  Eigen::VectorXd q;          // q* (n_q)
  Eigen::MatrixXd N_q;        // (n_q × n_v)
  Eigen::MatrixXd N_q_plus;   // left inverse of N_q (n_v × n_q)
  Eigen::MatrixXd J_f_q;      // Jacobian of f = M⁻¹(B u − C) (n_v × n_q)
  Eigen::MatrixXd J_f_v;      // (n_v × n_v)
  Eigen::MatrixXd J_f_u;      // (n_v × n_u)
  Eigen::VectorXd d_v;        // f(q*,v*,u*) − J_f [q*; v*; u*] (n_v)
  Eigen::MatrixXd M_inverse;  // (n_v × n_v)
  Eigen::VectorXd phi;        // gap of each contact, as the model counts it (n_c) [m]
  // between the surfaces, negative where they overlap (n_c) [m]: phi but for `no_overlap`
  Eigen::VectorXd distance;
  Eigen::MatrixXd J_n;  // φ̇ = J_n v (n_c × n_v)
  Eigen::MatrixXd J_t;  // tangential speed along each edge, contact by contact (n_c n_e × n_v)
  Eigen::VectorXd mu;   // (n_c)

  Eigen::Index n_q() const { return q.size(); }
  Eigen::Index n_v() const { return M_inverse.rows(); }
  Eigen::Index n_u() const { return J_f_u.cols(); }
  Eigen::Index n_c() const { return phi.size(); }
  Eigen::Index n_e() const { return n_c() == 0 ? 0 : J_t.rows() / n_c(); }
};

/// What is in between when an LCS is made, kept so that the next one of the same sizes needs no
/// heap.
struct LcsStorage {
  Eigen::MatrixXd V_x, V_u, V_lambda, E_t, J_c, J_n_q, to_A, to_E, to_F;
  Eigen::VectorXd mu, V_d, phi_q;
};

/// The LCS of Stewart and Trinkle: (8) and (9) with x = [q; v] and λ = [γ; λⁿ; λᵗ].
///
///   v⁺ = v + Δt (J_f [q; v; u] + M⁻¹ J_nᵀ λⁿ + M⁻¹ J_tᵀ λᵗ + d_v),   q⁺ = q + Δt N_q v⁺
///   0 ≤ γ  ⊥ μ λⁿ − E_t λᵗ ≥ 0
///   0 ≤ λⁿ ⊥ φ + J_n N_q⁺ (q − q*) + Δt J_n v⁺ ≥ 0
///   0 ≤ λᵗ ⊥ E_tᵀ γ + J_t v⁺ ≥ 0
///
/// @param dt time step Δt [s]
/// Source: [C3, eq. (8), (9)]; N_q⁺ replaces the identity where q and v differ in size.
lcs::Lcs stewart_trinkle(const ContactSystem& system, double dt);
/// The same in place of another one, without heap where that had the same sizes.
void stewart_trinkle(const ContactSystem& system, double dt, LcsStorage& storage, lcs::Lcs& lcs);

/// The LCS of Anitescu: (12) and (13) with x = [q; v] and one λ for each edge of each contact's
/// cone. λ is an impulse [N s], as the paper has it: no Δt stands before it.
///
///   v⁺ = v + Δt (J_f [q; v; u] + d_v) + M⁻¹ J_cᵀ λ,   q⁺ = q + Δt N_q v⁺,   J_c = E_tᵀ J_n + μ J_t
///   0 ≤ λ ⊥ E_tᵀ (φ + J_n N_q⁺ (q − q*)) / Δt + J_c v⁺ ≥ 0
///
/// F = J_c M⁻¹ J_cᵀ is symmetric and positive semidefinite, which the convex projection (24) needs.
/// A contact without edges (n_e = 0) gets one λ along its normal. What slides also separates, by μ
/// times the speed of sliding: the price of convexity.
///
/// @param dt time step Δt [s]
/// Source: [C3, eq. (12), (13)]. (12) prints d_v without its Δt; the discretisation of (10) has it.
lcs::Lcs anitescu(const ContactSystem& system, double dt);
/// The same in place of another one, without heap where that had the same sizes.
void anitescu(const ContactSystem& system, double dt, LcsStorage& storage, lcs::Lcs& lcs);

/// Contacts that are linear springs without friction, evaluated at the start of the step: x = [q;
/// v], λ = the springs' forces [N].
///
///   q⁺ = q + Δt N_q v,   v⁺ = v + Δt (J_f [q; v; u] + M⁻¹ J_nᵀ λ + d_v)
///   0 ≤ λ ⊥ φ + J_n N_q⁺ (q − q*) + λ / k ≥ 0
///
/// The explicit Euler method, as in the cart-pole example [C3, section VI-C]: H = 0 and F is
/// diagonal, so λ has a closed form.
/// @param stiffness k of each contact (n_c) [N/m]
lcs::Lcs spring_contacts(const ContactSystem& system, const Eigen::VectorXd& stiffness, double dt);

}  // namespace c3rt::model
