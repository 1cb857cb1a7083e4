#pragma once
// The simplified model M_s of section VII: a point-mass end effector with a spherical tip, a ball
// and a table.
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "controller/model/contact_system.hpp"
#include "controller/model/registry.hpp"

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
/// Of the end effector and the first body; q̇ of the quaternion is ½ [0; ω] ⊗ q with ω in W.
BallStateVector ball_state(const scene::Scene& scene);

/// Two unit vectors that complete `normal` to an orthonormal basis, from the normal alone.
/// The basis is continuous but at normals along ±x.
void tangents(const Eigen::Vector3d& normal, Eigen::Vector3d& t, Eigen::Vector3d& s);

enum class BallContact {
  kEndEffector,  // end effector and ball
  kTable,        // ball and table
};

/// M_s evaluated at a scene with one body, the ball. Gravity acts on ball and end effector. a_WB is
/// part of d: the force at the ball's centre that makes a rolling ball accelerate so, 7/5 m a, as
/// on a table that is tilted.
/// @param contacts those that the model has, in the order of its λ. BallLayout is for both of them
/// in their order, the default.
/// Precondition: the centres of end effector and ball differ.
ContactSystem ball_contact_system(const BallModelParameters& parameters, const scene::Scene& scene,
                                  const std::vector<BallContact>& contacts = {
                                      BallContact::kEndEffector, BallContact::kTable});

/// M_s of one ball with position and orientation (19 states) [C3, VII-A].
std::unique_ptr<PlanningModel> make_rolling_ball(const BallModelParameters& parameters);
ModelKind rolling_ball_kind();

}  // namespace c3rt::model
