#pragma once
// A rigid-body system with frictional contacts, linearised to an LCS [C3, section IV].
#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"

namespace c3rt::model {

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
  Eigen::VectorXd phi;        // gap of each contact (n_c) [m]
  Eigen::MatrixXd J_n;        // φ̇ = J_n v (n_c × n_v)
  Eigen::MatrixXd J_t;  // tangential speed along each edge, contact by contact (n_c n_e × n_v)
  Eigen::VectorXd mu;   // (n_c)

  Eigen::Index n_q() const { return q.size(); }
  Eigen::Index n_v() const { return M_inverse.rows(); }
  Eigen::Index n_u() const { return J_f_u.cols(); }
  Eigen::Index n_c() const { return phi.size(); }
  Eigen::Index n_e() const { return n_c() == 0 ? 0 : J_t.rows() / n_c(); }
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

}  // namespace c3rt::model
