#include "controller/model/ball_model.hpp"

#include <cmath>

namespace c3rt::model {
namespace {

constexpr double kGravity = 9.81;  // [m/s²]
using L = BallLayout;
// velocities v = [v_WE; ω_WB; v_WB]
constexpr int kVelocityEndEffector = 0, kVelocityOmega = 3, kVelocityBall = 6, kVelocities = 9,
              kPositions = 10;

Eigen::Vector3d end_effector_normal(const BallState& state) {
  return (state.p_WE - state.p_WB).normalized();
}

// rows of J_t: n_e edges +t −t +s −s of the speed of the contact's first body relative to the
// second
void fill_edges(Eigen::Ref<Eigen::MatrixXd> rows, const Eigen::Vector3d& t,
                const Eigen::Vector3d& s,
                const Eigen::Matrix<double, 3, kVelocities>& relative_velocity) {
  rows.row(0) = t.transpose() * relative_velocity;
  rows.row(1) = -rows.row(0);
  rows.row(2) = s.transpose() * relative_velocity;
  rows.row(3) = -rows.row(2);
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d result;
  result << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return result;
}

}  // namespace

BallStateVector to_vector(const BallState& state) {
  BallStateVector x;
  x << state.p_WE, state.q_WB.w(), state.q_WB.x(), state.q_WB.y(), state.q_WB.z(), state.p_WB,
      state.v_WE, state.omega_WB, state.v_WB;
  return x;
}

void tangents(const Eigen::Vector3d& normal, Eigen::Vector3d& t, Eigen::Vector3d& s) {
  // y and z never both vanish in the basis: contacts of this task have normals far from ±x, or
  // exactly along it
  const Eigen::Vector3d reference =
      std::abs(normal.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  t = (reference - normal * normal.dot(reference)).normalized();
  s = normal.cross(t);
}

ContactSystem ball_contact_system(const BallModelParameters& parameters, const BallState& state) {
  ContactSystem system;
  system.q = to_vector(state).head<kPositions>();

  // q̇ = ½ [0; ω] ⊗ q_WB = ½ G ω, and Gᵀ G = I for a unit quaternion
  const Eigen::Quaterniond& q = state.q_WB;
  Eigen::Matrix<double, 4, 3> G;
  G << -q.x(), -q.y(), -q.z(), q.w(), q.z(), -q.y(), -q.z(), q.w(), q.x(), q.y(), -q.x(), q.w();
  system.N_q = Eigen::MatrixXd::Zero(kPositions, kVelocities);
  system.N_q.block<3, 3>(L::p_WE, kVelocityEndEffector).setIdentity();
  system.N_q.block<4, 3>(L::q_WB, kVelocityOmega) = 0.5 * G;
  system.N_q.block<3, 3>(L::p_WB, kVelocityBall).setIdentity();
  system.N_q_plus = Eigen::MatrixXd::Zero(kVelocities, kPositions);
  system.N_q_plus.block<3, 3>(kVelocityEndEffector, L::p_WE).setIdentity();
  system.N_q_plus.block<3, 4>(kVelocityOmega, L::q_WB) = 2.0 * G.transpose();
  system.N_q_plus.block<3, 3>(kVelocityBall, L::p_WB).setIdentity();

  // f = M⁻¹ (B u − C) is affine: gravity and the force on the end effector; a sphere has no
  // gyroscopic term
  const double ball_inertia =
      0.4 * parameters.ball_mass * parameters.ball_radius * parameters.ball_radius;
  Eigen::VectorXd inverse_masses(kVelocities);
  inverse_masses << Eigen::Vector3d::Constant(1.0 / parameters.end_effector_mass),
      Eigen::Vector3d::Constant(1.0 / ball_inertia),
      Eigen::Vector3d::Constant(1.0 / parameters.ball_mass);
  system.M_inverse = inverse_masses.asDiagonal();
  system.J_f_q = Eigen::MatrixXd::Zero(kVelocities, kPositions);
  system.J_f_v = Eigen::MatrixXd::Zero(kVelocities, kVelocities);
  system.J_f_u = Eigen::MatrixXd::Zero(kVelocities, L::n_u);
  system.J_f_u.topRows<3>().diagonal().setConstant(1.0 / parameters.end_effector_mass);
  system.d_v = Eigen::VectorXd::Zero(kVelocities);
  system.d_v[kVelocityEndEffector + 2] = -kGravity;
  system.d_v[kVelocityBall + 2] = -kGravity;

  system.phi.resize(L::n_c);
  system.J_n = Eigen::MatrixXd::Zero(L::n_c, kVelocities);
  system.J_t = Eigen::MatrixXd::Zero(L::n_c * L::n_e, kVelocities);
  system.mu = Eigen::Vector2d(parameters.friction_end_effector, parameters.friction_table);
  Eigen::Vector3d t, s;

  // contact 0: end effector against the ball's surface point r n away from the ball's centre
  const Eigen::Vector3d n = end_effector_normal(state);
  tangents(n, t, s);
  Eigen::Matrix<double, 3, kVelocities> relative = Eigen::Matrix<double, 3, kVelocities>::Zero();
  relative.middleCols<3>(kVelocityEndEffector).setIdentity();
  relative.middleCols<3>(kVelocityOmega) = cross_matrix(parameters.ball_radius * n);  // −ω × r n
  relative.middleCols<3>(kVelocityBall) = -Eigen::Matrix3d::Identity();
  system.phi[0] =
      (state.p_WE - state.p_WB).norm() - parameters.end_effector_radius - parameters.ball_radius;
  system.J_n.row(0) = n.transpose() * relative;
  fill_edges(system.J_t.topRows(L::n_e), t, s, relative);

  // contact 1: the ball's lowest point against the table
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  tangents(up, t, s);
  relative.setZero();
  relative.middleCols<3>(kVelocityOmega) = cross_matrix(parameters.ball_radius * up);  // ω × (−r ẑ)
  relative.middleCols<3>(kVelocityBall).setIdentity();
  system.phi[1] = state.p_WB.z() - parameters.ball_radius - parameters.table_height;
  system.J_n.row(1) = up.transpose() * relative;
  fill_edges(system.J_t.bottomRows(L::n_e), t, s, relative);
  return system;
}

Eigen::Vector3d force_on_end_effector(const BallState& state,
                                      const Eigen::Ref<const Eigen::VectorXd>& lambda) {
  const Eigen::Vector3d n = end_effector_normal(state);
  Eigen::Vector3d t, s;
  tangents(n, t, s);
  const auto edges = lambda.segment<L::n_e>(L::tangent_end_effector);
  return n * lambda[L::normal_end_effector] + t * (edges[0] - edges[1]) + s * (edges[2] - edges[3]);
}

void separate(const BallModelParameters& parameters, const Eigen::Vector3d& away,
              BallState& state) {
  const double touching = parameters.end_effector_radius + parameters.ball_radius;
  const Eigen::Vector3d from_end_effector = state.p_WB - state.p_WE;
  if (from_end_effector.norm() >= touching) return;
  Eigen::Vector3d direction(from_end_effector.x(), from_end_effector.y(), 0.0);
  if (direction.norm() < 1e-9) direction = Eigen::Vector3d(away.x(), away.y(), 0.0);
  if (direction.norm() < 1e-9) direction = Eigen::Vector3d::UnitX();
  const double height = from_end_effector.z();
  const double horizontal = std::sqrt(touching * touching - height * height);
  state.p_WB.head<2>() = state.p_WE.head<2>() + horizontal * direction.normalized().head<2>();
}

}  // namespace c3rt::model
