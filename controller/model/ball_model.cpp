#include "controller/model/ball_model.hpp"

#include <cmath>

#include "controller/scene/cross_matrix.hpp"

namespace c3rt::model {
namespace {

using scene::cross_matrix;

constexpr double kGravity = 9.81;        // [m/s²]
constexpr double kRollingInertia = 1.4;  // m + I / r² of a solid sphere, over m
using L = BallLayout;
// velocities v = [v_WE; ω_WB; v_WB]
constexpr int kVelocityEndEffector = 0, kVelocityOmega = 3, kVelocityBall = 6, kVelocities = 9,
              kPositions = 10;

Eigen::Vector3d from_ball(const scene::Scene& scene) {
  return scene.effector.p_WE - scene.body(0).p_WB;
}

/// One contact: the map from v to the velocity of its first body relative to the second.
struct Contact {
  double gap;
  Eigen::Vector3d normal;
  Eigen::Matrix<double, 3, kVelocities> relative_velocity;
};

// the end effector against the ball's surface point r n away from the ball's centre
Contact end_effector_contact(const BallModelParameters& parameters, const scene::Scene& scene) {
  const Eigen::Vector3d n = from_ball(scene).normalized();
  Contact contact{from_ball(scene).norm() - parameters.end_effector_radius - parameters.ball_radius,
                  n, Eigen::Matrix<double, 3, kVelocities>::Zero()};
  auto& relative = contact.relative_velocity;
  relative.middleCols<3>(kVelocityEndEffector).setIdentity();
  relative.middleCols<3>(kVelocityOmega) = cross_matrix(parameters.ball_radius * n);  // −ω × r n
  relative.middleCols<3>(kVelocityBall) = -Eigen::Matrix3d::Identity();
  return contact;
}

// the ball's lowest point against the table
Contact table_contact(const BallModelParameters& parameters, const scene::Scene& scene) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  Contact contact{scene.body(0).p_WB.z() - parameters.ball_radius - parameters.table_height, up,
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

BallStateVector ball_state(const scene::Scene& scene) {
  const scene::Body& ball = scene.body(0);
  BallStateVector x;
  x << scene.effector.p_WE, ball.q_WB.w(), ball.q_WB.x(), ball.q_WB.y(), ball.q_WB.z(), ball.p_WB,
      scene.effector.v_WE, ball.omega_WB, ball.v_WB;
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

ContactSystem ball_contact_system(const BallModelParameters& parameters, const scene::Scene& scene,
                                  const std::vector<BallContact>& contacts) {
  ContactSystem system;
  system.q = ball_state(scene).head<kPositions>();

  // q̇ = ½ [0; ω] ⊗ q_WB = ½ G ω, and Gᵀ G = I for a unit quaternion
  const auto& q = scene.body(0).q_WB;
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
  system.d_v.segment<2>(kVelocityBall) = kRollingInertia * scene.body(0).a_WB;

  const auto n_c = static_cast<Eigen::Index>(contacts.size());
  system.phi.resize(n_c);
  system.mu.resize(n_c);
  system.J_n.resize(n_c, kVelocities);
  system.J_t.resize(n_c * L::n_e, kVelocities);
  for (Eigen::Index i = 0; i < n_c; ++i) {
    const bool table = contacts[static_cast<std::size_t>(i)] == BallContact::kTable;
    const Contact contact =
        table ? table_contact(parameters, scene) : end_effector_contact(parameters, scene);
    system.phi[i] = contact.gap;
    system.mu[i] = table ? parameters.friction_table : parameters.friction_end_effector;
    system.J_n.row(i) = contact.normal.transpose() * contact.relative_velocity;
    fill_edges(system.J_t.middleRows(i * L::n_e, L::n_e), contact);
  }
  system.distance = system.phi;
  return system;
}

namespace {

Layout rolling_ball_layout(const BallModelParameters& parameters) {
  Layout layout;
  layout.n_x = L::n_x;
  layout.n_v = kVelocities;
  layout.n_u = L::n_u;
  layout.n_e = L::n_e;
  layout.x = {{"end_effector", L::p_WE, 3, ContactPair::kEndEffector},
              {"", L::q_WB, 4, 0},
              {"ball_xy", L::p_WB, 2, 0},
              {"ball_z", L::p_WB + 2, 1, 0},
              {"end_effector_velocity", L::v_WE, 3, ContactPair::kEndEffector},
              {"ball_velocity", L::omega_WB, 3, 0},
              {"ball_velocity", L::v_WB, 3, 0}};
  layout.p_WE = L::p_WE;
  layout.v_WE = L::v_WE;
  layout.effector_v = kVelocityEndEffector;
  layout.contacts = {{"end_effector_ball", "end_effector", {ContactPair::kEndEffector, 0}},
                     {"ball_table", "table", {0, ContactPair::kTable}}};
  layout.world.effector.radius = parameters.end_effector_radius;
  layout.world.table_height = parameters.table_height;
  layout.world.body_count = 1;
  layout.world.body(0).name = "ball";
  layout.world.body(0).shape = scene::Shape::sphere(parameters.ball_radius);
  return layout;
}

class RollingBall final : public PlanningModel {
 public:
  explicit RollingBall(const BallModelParameters& parameters)
      : PlanningModel(rolling_ball_layout(parameters)), parameters_(parameters) {}

  void state(const scene::Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const override {
    x = ball_state(scene);
  }
  void evaluate(const scene::Scene& scene, const std::vector<int>& contacts,
                ContactSystem& system) const override {
    std::vector<BallContact> chosen;
    for (const int i : contacts)
      chosen.push_back(i == 0 ? BallContact::kEndEffector : BallContact::kTable);
    system = ball_contact_system(parameters_, scene, chosen);
  }

 private:
  BallModelParameters parameters_;
};

}  // namespace

std::unique_ptr<PlanningModel> make_rolling_ball(const BallModelParameters& parameters) {
  return std::make_unique<RollingBall>(parameters);
}

ModelKind rolling_ball_kind() {
  return {"rolling_ball",
          1,
          1,
          {{"end_effector_mass_kg", 1e-4, 100},
           {"end_effector_radius_m", 1e-3, 1},
           {"ball_mass_kg", 1e-3, 100},
           {"ball_radius_m", 1e-3, 1},
           {"table_height_m", -2, 2},
           {"friction_end_effector", 0, 10},
           {"friction_table", 0, 10}},
          [](const ModelValues& of, int) {
            return make_rolling_ball({of["end_effector_mass_kg"], of["end_effector_radius_m"],
                                      of["ball_mass_kg"], of["ball_radius_m"], of["table_height_m"],
                                      of["friction_end_effector"], of["friction_table"]});
          },
          "ball_mass_kg",
          "ball_radius_m"};
}

}  // namespace c3rt::model
