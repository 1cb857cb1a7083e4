#pragma once
// The operational-space impedance law of the paper's appendix D, eq. (36). Pure functions of the
// arm's state.
//
//   u = J_f^T Λ [K 0; 0 B] x̃^e + C_f + τ_ff + N_f (K_n (q_d - q) + B_n (q̇_d - q̇))
//
//   Λ = (J_f M_f⁻¹ J_f^T)⁻¹
//
// Gravity is not in it: the robot compensates its own.
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/model/arm.hpp"

namespace c3rt::impedance {

using model::ArmState;
using model::Matrix67d;
using model::Matrix6d;
using model::Matrix7d;
using model::Vector6d;
using model::Vector7d;

enum class Inertia {
  kFull,      // Λ as in (36): free, every coordinate is on its own; blocked in one, the law pushes
              // sideways: with z held below it, f_x = Λ_xz / Λ_zz f_z, 0.4 of it in our posture
  kDiagonal,  // Λ's diagonal: a blocked coordinate pushes no other, at the price of some coupling
              // of the free motion; passive as well, as Λ_d K and Λ_d B are. Its gains are up to
              // 20 times Λ's (x against pitch), so they have to stay low
  kUncoupled,  // Λ without what couples x, y and z once the rotation has given way: as `kDiagonal`
               // for what is blocked, gains at most three times Λ's
};

/// Λ with the off-diagonal elements of its Schur complement Λ_v = Λ_tt − Λ_tr Λ_rr⁻¹ Λ_rt, the
/// inertia of the point alone, taken out: symmetric, positive definite. RT: no heap, no throw.
Matrix6d uncoupled(const Matrix6d& Lambda) noexcept;

/// K and B of eq. (36). Λ multiplies them, so they are accelerations per error, not N/m: for small
/// errors and with the full Λ the closed loop is ë + B ė + K e = 0 in each coordinate, whatever the
/// arm's posture.
struct Gains {
  Inertia inertia = Inertia::kFull;
  Vector6d stiffness;           // K, [translation; rotation] [1/s^2]
  Vector6d damping;             // B, [translation; rotation] [1/s]
  double null_space_stiffness;  // K_n [N m/rad]
  double null_space_damping;    // B_n [N m s/rad]
  Vector7d null_space_q;        // q_d^f [rad]
};

/// What the end effector shall do. Its angular velocity shall be zero.
struct Goal {
  Eigen::Vector3d p_WE;  // [m]
  Eigen::Vector3d v_WE;  // [m/s]
  Eigen::Quaterniond q_WE;
  Eigen::Vector3d force_E;  // λ_d as the force of the contacts on the end effector, in W [N]
};

/// e of x̃^e: [p_d - p; vector part of q_d q⁻¹, taken the short way round], in W. Its rotational
/// part is half the rotation vector for small angles, so the rotational stiffness per radian is
/// K/2.
/// RT: no heap, no lock, no throw.
Vector6d pose_error(const Eigen::Isometry3d& X_WE, const Eigen::Vector3d& p_WE_desired,
                    const Eigen::Quaterniond& q_WE_desired) noexcept;

/// The arm as the end effector feels it.
struct TaskInertia {
  Matrix6d Lambda;  // Λ [kg; kg m; kg m^2]
  Matrix7d N;  // I - J^T J̄^T with J̄ = M⁻¹ J^T Λ: N τ moves the joints, not the end effector
};

/// Λ and N. Where the arm is (nearly) singular, directions in which its inverse inertia J M⁻¹ J^T
/// falls below kSmallestMobility count with that value, so that Λ stays bounded; N is exact
/// wherever nothing was bounded.
/// RT: no heap, no lock, no throw.
TaskInertia task_inertia(const ArmState& arm) noexcept;

/// Smallest eigenvalue of J M⁻¹ J^T that is inverted as it is. Within 0.4 rad of the start posture
/// all are above 0.07; at 0.005 the apparent inertia is 200 kg, far more than any force of ours
/// should act on.
constexpr double kSmallestMobility = 0.005;

/// τ_ff, in (36) J_c^T λ_d with J_c of the reaction. Here the force f is given as what the contacts
/// exert on the end effector: it adds J_v^T f to the joints, J_v the linear rows of J. The law
/// cancels that,
///
///   τ_ff = -J_v^T f
///
/// and so the end effector exerts the planned force on an object without leaving its reference. The
/// force's line is taken through E: the normal's passes there, the friction's lever is the radius.
/// RT: no heap, no lock, no throw.
Vector7d feed_forward_torque(const Matrix67d& J_WE, const Eigen::Vector3d& force_E) noexcept;

/// τ of eq. (36) without gravity, q̇_d^f = 0, in two parts. [N m]
struct Torque {
  Vector7d of_goal;  // of x_d - x, ẋ_d and λ_d: 0 for a goal where the arm is, at rest
  Vector7d of_arm;   // of its velocity and posture
  Vector7d sum() const { return of_goal + of_arm; }
};
/// RT: no heap, no lock, no throw.
Torque torque(const Gains& gains, const ArmState& arm, const Vector7d& q, const Vector7d& dq,
              const Goal& goal) noexcept;

}  // namespace c3rt::impedance
