#include "controller/model/ball_model.hpp"

#include <cmath>

namespace c3rt::model {
namespace {

constexpr double kGravity = 9.81;        // [m/s²]
constexpr double kRollingInertia = 1.4;  // m + I / r² of a solid sphere, over m
using L = BallLayout;
// velocities v = [v_WE; ω_WB; v_WB]
constexpr int kVelocityEndEffector = 0, kVelocityOmega = 3, kVelocityBall = 6, kVelocities = 9,
              kPositions = 10;

Eigen::Vector3d end_effector_normal(const BallState& state) {
  return (state.p_WE - state.p_WB).normalized();
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d result;
  result << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return result;
}

/// One contact: the map from v to the velocity of its first body relative to the second.
struct Contact {
  double gap;
  Eigen::Vector3d normal;
  Eigen::Matrix<double, 3, kVelocities> relative_velocity;
};

// the end effector against the ball's surface point r n away from the ball's centre
Contact end_effector_contact(const BallModelParameters& parameters, const BallState& state) {
  const Eigen::Vector3d n = end_effector_normal(state);
  Contact contact{
      (state.p_WE - state.p_WB).norm() - parameters.end_effector_radius - parameters.ball_radius, n,
      Eigen::Matrix<double, 3, kVelocities>::Zero()};
  auto& relative = contact.relative_velocity;
  relative.middleCols<3>(kVelocityEndEffector).setIdentity();
  relative.middleCols<3>(kVelocityOmega) = cross_matrix(parameters.ball_radius * n);  // −ω × r n
  relative.middleCols<3>(kVelocityBall) = -Eigen::Matrix3d::Identity();
  return contact;
}

// the ball's lowest point against the table
Contact table_contact(const BallModelParameters& parameters, const BallState& state) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  Contact contact{state.p_WB.z() - parameters.ball_radius - parameters.table_height, up,
                  Eigen::Matrix<double, 3, kVelocities>::Zero()};
  auto& relative = contact.relative_velocity;
  relative.middleCols<3>(kVelocityOmega) = cross_matrix(parameters.ball_radius * up);  // ω × (−r ẑ)
  relative.middleCols<3>(kVelocityBall).setIdentity();
  return contact;
}

// rows of J_t: n_e edges +t −t +s −s of the speed of the contact's first body relative to the
// second
void fill_edges(Eigen::Ref<Eigen::MatrixXd> rows, const Contact& contact) {
  Eigen::Vector3d t, s;
  tangents(contact.normal, t, s);
  rows.row(0) = t.transpose() * contact.relative_velocity;
  rows.row(1) = -rows.row(0);
  rows.row(2) = s.transpose() * contact.relative_velocity;
  rows.row(3) = -rows.row(2);
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

ContactSystem ball_contact_system(const BallModelParameters& parameters, const BallState& state,
                                  const std::vector<BallContact>& contacts) {
  ContactSystem system;
  system.q = to_vector(state).head<kPositions>();

  // q̇ = ½ [0; ω] ⊗ q_WB = ½ G ω, and Gᵀ G = I for a unit quaternion
  const auto& q = state.q_WB;
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
  system.d_v.segment<2>(kVelocityBall) = kRollingInertia * state.a_WB;

  const auto n_c = static_cast<Eigen::Index>(contacts.size());
  system.phi.resize(n_c);
  system.mu.resize(n_c);
  system.J_n.resize(n_c, kVelocities);
  system.J_t.resize(n_c * L::n_e, kVelocities);
  for (Eigen::Index i = 0; i < n_c; ++i) {
    const bool table = contacts[static_cast<std::size_t>(i)] == BallContact::kTable;
    const Contact contact =
        table ? table_contact(parameters, state) : end_effector_contact(parameters, state);
    system.phi[i] = contact.gap;
    system.mu[i] = table ? parameters.friction_table : parameters.friction_end_effector;
    system.J_n.row(i) = contact.normal.transpose() * contact.relative_velocity;
    fill_edges(system.J_t.middleRows(i * L::n_e, L::n_e), contact);
  }
  return system;
}

Eigen::Vector3d contact_force(const Eigen::Vector3d& normal, double lambda_n,
                              const Eigen::Matrix<double, 4, 1, Eigen::DontAlign>& edges) {
  Eigen::Vector3d t, s;
  tangents(normal, t, s);
  return normal * lambda_n + t * (edges[0] - edges[1]) + s * (edges[2] - edges[3]);
}

Eigen::Vector3d force_on_end_effector(const BallState& state,
                                      const Eigen::Ref<const Eigen::VectorXd>& lambda) {
  return contact_force(end_effector_normal(state), lambda[L::normal_end_effector],
                       lambda.segment<L::n_e>(L::tangent_end_effector));
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
