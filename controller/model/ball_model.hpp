#pragma once
// The simplified model M_s of section VII: a point-mass end effector with a spherical tip, a ball
// and a table.
#include <vector>

#include <Eigen/Geometry>

#include "controller/model/contact_system.hpp"

namespace c3rt::model {

struct BallModelParameters {
  double end_effector_mass;      // [kg]; a planning parameter, not the arm's
  double end_effector_radius;    // [m]
  double ball_mass;              // [kg]
  double ball_radius;            // [m]
  double table_height;           // of the table's surface in W [m]
  double friction_end_effector;  // μ between end effector and ball
  double friction_table;         // μ between ball and table
};

/// State of M_s; q̇ of the quaternion is ½ [0; ω] ⊗ q with ω in W. Nothing in it is aligned for a
/// vector unit, which would give it another layout for each.
struct BallState {
  Eigen::Vector3d p_WE;      // end effector's centre [m]
  Eigen::Quaternion<double, Eigen::DontAlign> q_WB;  // the ball's orientation
  Eigen::Vector3d p_WB;      // the ball's centre [m]
  Eigen::Vector3d v_WE;      // [m/s]
  Eigen::Vector3d omega_WB;  // in W [rad/s]
  Eigen::Vector3d v_WB;      // [m/s]
  // what the ball does on the table with nothing but that in contact, in x and y [m/s²]
  Eigen::Matrix<double, 2, 1, Eigen::DontAlign> a_WB = Eigen::Vector2d::Zero();
};

/// x = [p_WE (3); q_WB w x y z (4); p_WB (3); v_WE (3); ω_WB (3); v_WB (3)], u = force on the end
/// effector [N], λ = [γ₀ γ₁ n₀ n₁ t₀ (4) t₁ (4)]; contact 0 is end effector–ball, contact 1
/// ball–table. Each contact's edges are +t −t +s −s. The only place that knows the order.
struct BallLayout {
  static constexpr int n_x = 19, n_lambda = 12, n_u = 3, n_c = 2, n_e = 4;
  static constexpr int p_WE = 0, q_WB = 3, p_WB = 7, v_WE = 10, omega_WB = 13, v_WB = 16;
  static constexpr int gamma = 0, normal_end_effector = 2, normal_table = 3,
                       tangent_end_effector = 4, tangent_table = 8;
};

using BallStateVector = Eigen::Matrix<double, BallLayout::n_x, 1>;
BallStateVector to_vector(const BallState& state);

/// Two unit vectors that complete `normal` to an orthonormal basis, from the normal alone.
/// The basis is continuous but at normals along ±x.
void tangents(const Eigen::Vector3d& normal, Eigen::Vector3d& t, Eigen::Vector3d& s);

/// n λ_n and what the edges +t −t +s −s add to it: the force of one contact on the body that its
/// normal points to, in W [N].
Eigen::Vector3d contact_force(const Eigen::Vector3d& normal, double lambda_n,
                              const Eigen::Matrix<double, 4, 1, Eigen::DontAlign>& edges);

enum class BallContact {
  kEndEffector,  // end effector and ball
  kTable,        // ball and table
};

/// M_s evaluated at a state. Gravity acts on ball and end effector. a_WB is part of d: the force at
/// the ball's centre that makes a rolling ball accelerate so, 7/5 m a, as on a table that is
/// tilted.
/// @param contacts those that the model has, in the order of its λ. BallLayout is for both of them
/// in their order, the default.
/// Precondition: the centres of end effector and ball differ.
ContactSystem ball_contact_system(const BallModelParameters& parameters, const BallState& state,
                                  const std::vector<BallContact>& contacts = {
                                      BallContact::kEndEffector, BallContact::kTable});

/// The force that contact 0 exerts on the end effector, in W [N], from an unscaled λ of this model
/// at `state`.
Eigen::Vector3d force_on_end_effector(const BallState& state,
                                      const Eigen::Ref<const Eigen::VectorXd>& lambda);

/// Moves the ball horizontally away from the end effector until they touch, where they overlap
/// [Algorithm 3, step 1: an estimate with the end effector inside the ball would make the LCS push
/// them apart at once].
/// @param away horizontal direction used when the end effector is straight above the ball
void separate(const BallModelParameters& parameters, const Eigen::Vector3d& away, BallState& state);

}  // namespace c3rt::model
