#include "controller/model/pushed_box.hpp"

#include <cmath>

#include "controller/model/ball_model.hpp"
#include "controller/scene/cross_matrix.hpp"

namespace c3rt::model {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using scene::cross_matrix;
using L = PushedBoxLayout;

constexpr double kGravity = 9.81;  // [m/s²]
// velocities v = [v_WE; v_WB; ω_WB]
constexpr int kVelocityEffector = 0, kVelocityBox = 3, kVelocityOmega = 6;

Layout pushed_box_layout(const PushedBoxParameters& parameters) {
  Layout layout;
  layout.n_x = L::n_x;
  layout.n_v = L::n_v;
  layout.n_u = L::n_u;
  layout.n_e = L::n_e;
  layout.x = {{"end_effector_xy", L::p_WE, 2, ContactPair::kEndEffector},
              {"end_effector_z", L::p_WE + 2, 1, ContactPair::kEndEffector},
              {"box_xy", L::p_WB, 2, 0},
              {"box_z", L::p_WB + 2, 1, 0},
              {"box_rotation", L::rotation, 3, 0},
              {"end_effector_velocity", L::v_WE, 3, ContactPair::kEndEffector},
              {"box_velocity", L::v_WB, 3, 0},
              {"box_angular_velocity", L::omega_WB, 3, 0}};
  layout.p_WE = L::p_WE;
  layout.v_WE = L::v_WE;
  layout.effector_v = kVelocityEffector;
  layout.contacts = {{"end_effector_box", "end_effector", {ContactPair::kEndEffector, 0}}};
  for (int corner = 0; corner < L::n_c - 1; ++corner)
    layout.contacts.push_back({"box_table", "table", {0, ContactPair::kTable}});
  layout.world.table_height = parameters.table_height;
  layout.world.effector.radius = parameters.end_effector_radius;
  layout.world.body_count = 1;
  layout.world.body(0).name = "box";
  layout.world.body(0).shape = scene::Shape::box(parameters.half_sizes);
  return layout;
}

/// The map from v to the velocity of a contact's first body relative to the second.
struct Contact {
  double distance, mu;
  Vector3d normal, t, s;
  Eigen::Matrix<double, 3, L::n_v> relative_velocity;
};

class PushedBox final : public PlanningModel {
 public:
  explicit PushedBox(const PushedBoxParameters& parameters)
      : PlanningModel(pushed_box_layout(parameters)), parameters_(parameters) {
    const Vector3d sides = 2.0 * parameters.half_sizes;
    const Vector3d squares = sides.cwiseAbs2();
    inertia_ =
        parameters.box_mass / 12.0 *
        Vector3d(squares.y() + squares.z(), squares.x() + squares.z(), squares.x() + squares.y());
  }

  void state(const scene::Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const override {
    state_about(scene, scene, x);
  }

  void state_about(const scene::Scene& scene, const scene::Scene& about,
                   Eigen::Ref<Eigen::VectorXd> x) const override {
    const scene::Body& box = scene.body(0);
    const Eigen::Quaterniond q_now = about.body(0).q_WB, q = box.q_WB;
    const Eigen::AngleAxisd turned(q * q_now.conjugate());
    x.segment<3>(L::p_WE) = scene.effector.p_WE;
    x.segment<3>(L::p_WB) = box.p_WB;
    x.segment<3>(L::rotation) = std::remainder(turned.angle(), 2.0 * M_PI) * turned.axis();
    x.segment<3>(L::v_WE) = scene.effector.v_WE;
    x.segment<3>(L::v_WB) = box.v_WB;
    x.segment<3>(L::omega_WB) = box.omega_WB;
  }

  void evaluate(const scene::Scene& scene, const std::vector<int>& contacts,
                ContactSystem& system) const override {
    const scene::Body& box = scene.body(0);
    const Matrix3d R = Eigen::Quaterniond(box.q_WB).toRotationMatrix();
    const Matrix3d inertia = R * inertia_.asDiagonal() * R.transpose();
    const Matrix3d inverse_inertia = R * inertia_.cwiseInverse().asDiagonal() * R.transpose();

    system.q.resize(L::n_v);
    system.q << scene.effector.p_WE, box.p_WB, Vector3d::Zero();
    system.N_q = Eigen::MatrixXd::Identity(L::n_v, L::n_v);
    system.N_q_plus = system.N_q;
    system.M_inverse = Eigen::MatrixXd::Zero(L::n_v, L::n_v);
    system.M_inverse.diagonal()
        .segment<3>(kVelocityEffector)
        .setConstant(1.0 / parameters_.end_effector_mass);
    system.M_inverse.diagonal().segment<3>(kVelocityBox).setConstant(1.0 / parameters_.box_mass);
    system.M_inverse.block<3, 3>(kVelocityOmega, kVelocityOmega) = inverse_inertia;

    // f of ω is −I⁻¹ (ω × I ω); where the box turns, f turns with it
    const Vector3d& omega = box.omega_WB;
    const Vector3d f = -inverse_inertia * omega.cross(inertia * omega);
    const Matrix3d by_omega =
        -inverse_inertia * (cross_matrix(omega) * inertia - cross_matrix(inertia * omega));
    system.J_f_q = Eigen::MatrixXd::Zero(L::n_v, L::n_v);
    system.J_f_q.block<3, 3>(kVelocityOmega, L::rotation) =
        by_omega * cross_matrix(omega) - cross_matrix(f);
    system.J_f_v = Eigen::MatrixXd::Zero(L::n_v, L::n_v);
    system.J_f_v.block<3, 3>(kVelocityOmega, kVelocityOmega) = by_omega;
    system.J_f_u = Eigen::MatrixXd::Zero(L::n_v, L::n_u);
    system.J_f_u.topRows<3>() = system.M_inverse.topLeftCorner<3, 3>();
    system.d_v = Eigen::VectorXd::Zero(L::n_v);
    system.d_v[kVelocityBox + 2] = -kGravity;
    system.d_v.segment<3>(kVelocityOmega) = f - by_omega * omega;

    const auto n_c = static_cast<Eigen::Index>(contacts.size());
    system.phi.resize(n_c);
    system.distance.resize(n_c);
    system.mu.resize(n_c);
    system.J_n.resize(n_c, L::n_v);
    system.J_t.resize(n_c * L::n_e, L::n_v);
    for (Eigen::Index i = 0; i < n_c; ++i) {
      const int chosen = contacts[static_cast<std::size_t>(i)];
      const Contact contact = chosen == 0 ? with_effector(scene) : with_table(box, R, chosen - 1);
      system.distance[i] = contact.distance;
      system.phi[i] = chosen == 0 ? no_overlap(contact.distance) : contact.distance;
      system.mu[i] = contact.mu;
      system.J_n.row(i) = contact.normal.transpose() * contact.relative_velocity;
      auto edges = system.J_t.middleRows<L::n_e>(i * L::n_e);
      edges.row(0) = contact.t.transpose() * contact.relative_velocity;
      edges.row(1) = -edges.row(0);
      edges.row(2) = contact.s.transpose() * contact.relative_velocity;
      edges.row(3) = -edges.row(2);
    }
  }

 private:
  Contact with_effector(const scene::Scene& scene) const {
    scene::Effector effector = scene.effector;
    effector.radius = parameters_.end_effector_radius;
    scene::Body box = scene.body(0);
    box.shape = scene::Shape::box(parameters_.half_sizes);
    const scene::Gap found = scene::gap(effector, box);
    Contact contact;
    contact.distance = found.distance;
    contact.mu = parameters_.friction_end_effector;
    contact.normal = found.normal;
    tangents(contact.normal, contact.t, contact.s);
    const Vector3d on_box =
        effector.p_WE - (found.distance + effector.radius) * found.normal - box.p_WB;
    contact.relative_velocity.setZero();
    contact.relative_velocity.middleCols<3>(kVelocityEffector).setIdentity();
    contact.relative_velocity.middleCols<3>(kVelocityBox) = -Matrix3d::Identity();
    contact.relative_velocity.middleCols<3>(kVelocityOmega) = cross_matrix(on_box);
    return contact;
  }

  Contact with_table(const scene::Body& box, const Matrix3d& R, int corner) const {
    const Vector3d signs((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0, -1.0);
    const Vector3d arm = R * signs.cwiseProduct(parameters_.half_sizes);
    const double turned = corner * M_PI / 8.0;
    Contact contact;
    contact.distance = box.p_WB.z() + arm.z() - parameters_.table_height;
    contact.mu = parameters_.friction_table;
    contact.normal = Vector3d::UnitZ();
    contact.t << std::cos(turned), std::sin(turned), 0.0;
    contact.s << -std::sin(turned), std::cos(turned), 0.0;
    contact.relative_velocity.setZero();
    contact.relative_velocity.middleCols<3>(kVelocityBox).setIdentity();
    contact.relative_velocity.middleCols<3>(kVelocityOmega) = -cross_matrix(arm);
    return contact;
  }

  PushedBoxParameters parameters_;
  Vector3d inertia_;  // about the box's own axes [kg m²]
};

}  // namespace

std::unique_ptr<PlanningModel> make_pushed_box(const PushedBoxParameters& parameters) {
  return std::make_unique<PushedBox>(parameters);
}

ModelKind pushed_box_kind() {
  return {"pushed_box",
          1,
          1,
          {{"end_effector_mass_kg", 1e-4, 100},
           {"end_effector_radius_m", 1e-3, 1},
           {"box_mass_kg", 1e-3, 100},
           {"box_half_x_m", 1e-3, 1},
           {"box_half_y_m", 1e-3, 1},
           {"box_half_z_m", 1e-3, 1},
           {"table_height_m", -2, 2},
           {"friction_end_effector", 0, 10},
           {"friction_table", 0, 10}},
          [](const ModelValues& of, int) {
            return make_pushed_box(
                {of["end_effector_mass_kg"], of["end_effector_radius_m"], of["box_mass_kg"],
                 Vector3d(of["box_half_x_m"], of["box_half_y_m"], of["box_half_z_m"]),
                 of["table_height_m"], of["friction_end_effector"], of["friction_table"]});
          },
          "box_mass_kg",
          "box_half_x_m"};
}

}  // namespace c3rt::model
