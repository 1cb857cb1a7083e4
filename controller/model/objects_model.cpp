#include "controller/model/objects_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "controller/model/ball_model.hpp"
#include "controller/model/support_points.hpp"
#include "controller/scene/cross_matrix.hpp"
#include "controller/scene/distance.hpp"

namespace c3rt::model {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using scene::cross_matrix;
using L = ObjectsLayout;

constexpr double kGravity = 9.81;  // [m/s²]
constexpr int kMostObjects = 4;
constexpr int kEndEffector = ContactPair::kEndEffector, kTable = ContactPair::kTable;

/// How many objects are in the model.
int planned(const ObjectsParameters& parameters) {
  return parameters.closest > 0 ? parameters.closest : static_cast<int>(parameters.objects.size());
}

Layout objects_layout(const ObjectsParameters& parameters,
                      const std::vector<SupportPoints>& support) {
  const int n = planned(parameters), all = static_cast<int>(parameters.objects.size());
  const L order{n};
  Layout layout;
  layout.n_x = order.n_x();
  layout.n_v = order.n_v();
  layout.n_u = L::n_u;
  layout.n_e = L::n_e;
  layout.p_WE = L::effector;
  layout.v_WE = order.n_v() + L::effector;
  layout.effector_v = L::effector;
  layout.x = {{"end_effector_xy", layout.p_WE, 2, kEndEffector},
              {"end_effector_z", layout.p_WE + 2, 1, kEndEffector}};
  for (int i = 0; i < n; ++i) {
    layout.x.push_back({"object_xy", L::position(i), 2, i});
    layout.x.push_back({"object_z", L::position(i) + 2, 1, i});
    layout.x.push_back({"object_rotation", L::rotation(i), 3, i});
  }
  layout.x.push_back({"end_effector_velocity", layout.v_WE, 3, kEndEffector});
  for (int i = 0; i < n; ++i) {
    layout.x.push_back({"object_velocity", order.n_v() + L::position(i), 3, i});
    layout.x.push_back({"object_angular_velocity", order.n_v() + L::rotation(i), 3, i});
  }
  for (int i = 0; i < (parameters.each_object ? n : 1); ++i)
    layout.contacts.push_back({"end_effector_object", "end_effector", {kEndEffector, i}});
  for (int i = 0; i < n; ++i) {
    for (int point = 0; point < support[static_cast<std::size_t>(i)].size(); ++point)
      layout.contacts.push_back({"object_table", "table", {i, kTable}});
  }
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) layout.contacts.push_back({"object_object", "object", {i, j}});
  }
  layout.world.table_height = parameters.table_height;
  layout.world.effector.radius = parameters.end_effector_radius;
  layout.world.body_count = all;
  for (int i = 0; i < all; ++i) {
    const scene::Object& object = parameters.objects[static_cast<std::size_t>(i)];
    layout.world.body(i).name = object.name.c_str();
    layout.world.body(i).shape = object.shape();
  }
  return layout;
}

/// How a contact's first body moves relative to its second: v_1 + ω_1 × r_1 − v_2 − ω_2 × r_2.
struct Contact {
  double distance, mu;
  Vector3d normal, t, s;
  int first, second;           // bodies by ContactPair's words
  Vector3d r_first, r_second;  // from their origins to the point, in W
};

std::vector<SupportPoints> support_of(const ObjectsParameters& parameters) {
  const std::size_t n = parameters.objects.size();
  if (n < 1 || n > static_cast<std::size_t>(kMostObjects)) {
    throw std::invalid_argument("planning model of objects: expected 1 to " +
                                std::to_string(kMostObjects) + " of them, got " +
                                std::to_string(n));
  }
  std::vector<SupportPoints> result;
  for (const scene::Object& object : parameters.objects)
    result.emplace_back(object, parameters.support_points);
  if (parameters.closest < 0 || parameters.closest > static_cast<int>(n)) {
    throw std::invalid_argument("planning model of objects: expected " + std::to_string(n) +
                                " of them or fewer in the model, got " +
                                std::to_string(parameters.closest));
  }
  const auto differs = [&](const SupportPoints& of) { return of.size() != result.front().size(); };
  if (planned(parameters) < static_cast<int>(n) &&
      std::any_of(result.begin(), result.end(), differs)) {
    throw std::invalid_argument("planning model of the closest objects: expected objects with " +
                                std::to_string(result.front().size()) +
                                " support points each, got another number");
  }
  return result;
}

class ObjectsModel final : public PlanningModel {
 public:
  ObjectsModel(const ObjectsParameters& parameters, std::vector<SupportPoints> support)
      : PlanningModel(objects_layout(parameters, support)),
        parameters_(parameters),
        support_(std::move(support)),
        n_(planned(parameters)) {
    for (const scene::Object& object : parameters_.objects)
      inverse_inertia_.emplace_back(object.inertia.inverse());
    std::vector<int> points(static_cast<std::size_t>(n_), 0);
    for (const ModelContact& contact : layout().contacts) {
      const bool with_table = contact.bodies.second == kTable;
      point_.push_back(with_table ? points[static_cast<std::size_t>(contact.bodies.first)]++ : -1);
    }
  }

  void state(const scene::Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const override {
    state_about(scene, scene, x);
  }

  int body(int i, const scene::Scene& about) const noexcept override {
    return chosen(about)[static_cast<std::size_t>(i)];
  }

  void state_about(const scene::Scene& scene, const scene::Scene& about,
                   Eigen::Ref<Eigen::VectorXd> x) const override {
    const Chosen of = chosen(about);
    auto q = x.head(layout().n_v);
    auto v = x.tail(layout().n_v);
    q.segment<3>(L::effector) = scene.effector.p_WE;
    v.segment<3>(L::effector) = scene.effector.v_WE;
    for (int i = 0; i < n_; ++i) {
      const int object = of[static_cast<std::size_t>(i)];
      const scene::Body& body = scene.body(object);
      const Eigen::Quaterniond q_now = about.body(object).q_WB, q_then = body.q_WB;
      const Eigen::AngleAxisd turned(q_then * q_now.conjugate());
      q.segment<3>(L::position(i)) = body.p_WB;
      q.segment<3>(L::rotation(i)) = std::remainder(turned.angle(), 2.0 * M_PI) * turned.axis();
      v.segment<3>(L::position(i)) = body.v_WB;
      v.segment<3>(L::rotation(i)) = body.omega_WB;
    }
  }

  void evaluate(const scene::Scene& scene, const std::vector<int>& contacts,
                ContactSystem& system) const override {
    const int n_v = layout().n_v;
    system.q.setZero(n_v);
    system.q.segment<3>(L::effector) = scene.effector.p_WE;
    system.N_q.setIdentity(n_v, n_v);
    system.N_q_plus.setIdentity(n_v, n_v);
    system.M_inverse.setZero(n_v, n_v);
    system.J_f_q.setZero(n_v, n_v);
    system.J_f_v.setZero(n_v, n_v);
    system.J_f_u.setZero(n_v, L::n_u);
    system.d_v.setZero(n_v);
    system.M_inverse.diagonal()
        .segment<3>(L::effector)
        .setConstant(1.0 / parameters_.end_effector_mass);
    system.J_f_u.block<3, 3>(L::effector, 0) =
        system.M_inverse.block<3, 3>(L::effector, L::effector);
    Now now{scene, chosen(scene), {}};
    for (int i = 0; i < n_; ++i) {
      const scene::Body& body = scene.body(now.object(i));
      const Matrix3d R = Eigen::Quaterniond(body.q_WB).toRotationMatrix();
      now.places[static_cast<std::size_t>(i)] = {body.p_WB, R};
      free_body(i, now.object(i), body, R, system);
    }
    const auto n_c = static_cast<Eigen::Index>(contacts.size());
    system.phi.resize(n_c);
    system.distance.resize(n_c);
    system.mu.resize(n_c);
    system.J_n.setZero(n_c, n_v);
    system.J_t.setZero(n_c * L::n_e, n_v);
    for (Eigen::Index i = 0; i < n_c; ++i) {
      const Contact contact = at(contacts[static_cast<std::size_t>(i)], now);
      system.distance[i] = contact.distance;
      system.phi[i] =
          contact.first == kEndEffector ? no_overlap(contact.distance) : contact.distance;
      system.mu[i] = contact.mu;
      const Eigen::Index edges = i * L::n_e;
      add_row(contact, contact.normal, system.J_n.row(i));
      add_row(contact, contact.t, system.J_t.row(edges));
      add_row(contact, contact.s, system.J_t.row(edges + 2));
      system.J_t.row(edges + 1) = -system.J_t.row(edges);
      system.J_t.row(edges + 3) = -system.J_t.row(edges + 2);
    }
  }

 private:
  using Chosen = std::array<int, kMostObjects>;
  /// The scene with the objects that are in the model.
  struct Now {
    const scene::Scene& scene;
    Chosen chosen;
    std::array<scene::Place, kMostObjects> places;  // of each that is in the model

    int object(int i) const noexcept { return chosen[static_cast<std::size_t>(i)]; }
    const scene::Place& place(int i) const noexcept { return places[static_cast<std::size_t>(i)]; }
  };

  /// Which objects are in the model, in their order.
  Chosen chosen(const scene::Scene& scene) const noexcept {
    const int all = static_cast<int>(parameters_.objects.size());
    Chosen order{};
    for (int i = 0; i < all; ++i) order[static_cast<std::size_t>(i)] = i;
    if (n_ == all) return order;
    int nearest = 0;
    double least = gap_to(0, scene).distance;
    for (int i = 1; i < all; ++i) {
      const double distance = gap_to(i, scene).distance;
      if (distance < least) {
        least = distance;
        nearest = i;
      }
    }
    // by how many others leave less room between them and it, along the line of their middles
    std::size_t count = 0;
    const auto reach = [&](int i, const Vector3d& direction) {
      return scene::reach(object(i).shape(), scene.body(i).q_WB.conjugate() * direction);
    };
    std::array<double, kMostObjects> room{};
    for (int i = 0; i < all; ++i) {
      const Vector3d between = scene.body(i).p_WB - scene.body(nearest).p_WB;
      const Vector3d direction = between.stableNormalized();
      room[static_cast<std::size_t>(i)] =
          i == nearest ? -std::numeric_limits<double>::infinity()
                       : between.norm() - reach(nearest, direction) - reach(i, -direction);
    }
    const auto less = [&](int i, int j) {
      const double of_i = room[static_cast<std::size_t>(i)],
                   of_j = room[static_cast<std::size_t>(j)];
      return of_i < of_j || (of_i == of_j && i < j);
    };
    for (int i = 0; i < all; ++i) {
      int nearer = 0;
      for (int j = 0; j < all; ++j) nearer += less(j, i) ? 1 : 0;
      if (nearer < n_) order[count++] = i;
    }
    return order;
  }

  scene::Gap gap_to(int i, const scene::Scene& scene) const noexcept {
    scene::Effector effector = scene.effector;
    effector.radius = parameters_.end_effector_radius;
    scene::Body body = scene.body(i);
    body.shape = object(i).shape();
    return scene::gap(effector, body);
  }

  const scene::Object& object(int i) const noexcept {
    return parameters_.objects[static_cast<std::size_t>(i)];
  }

  /// Newton and Euler: f of v is gravity, of ω −I⁻¹ (ω × I ω), which turns where the body turns.
  void free_body(int i, int of, const scene::Body& body, const Matrix3d& R,
                 ContactSystem& system) const {
    const Matrix3d inertia = R * object(of).inertia * R.transpose();
    const Matrix3d inverse_inertia =
        R * inverse_inertia_[static_cast<std::size_t>(of)] * R.transpose();
    const Vector3d& omega = body.omega_WB;
    const Vector3d f = -inverse_inertia * omega.cross(inertia * omega);
    const Matrix3d by_omega =
        -inverse_inertia * (cross_matrix(omega) * inertia - cross_matrix(inertia * omega));
    const int p = L::position(i), r = L::rotation(i);
    system.q.segment<3>(p) = body.p_WB;
    system.M_inverse.diagonal().segment<3>(p).setConstant(1.0 / object(of).mass);
    system.M_inverse.block<3, 3>(r, r) = inverse_inertia;
    system.J_f_q.block<3, 3>(r, r) = by_omega * cross_matrix(omega) - cross_matrix(f);
    system.J_f_v.block<3, 3>(r, r) = by_omega;
    system.J_f_v.diagonal().segment<3>(p).array() -= parameters_.damping;
    system.J_f_v.diagonal().segment<3>(r).array() -= parameters_.damping;
    system.d_v[p + 2] = -kGravity;
    system.d_v.segment<3>(r) = f - by_omega * omega;
  }

  Contact at(int contact, const Now& now) const {
    const ContactPair& bodies = layout().contacts[static_cast<std::size_t>(contact)].bodies;
    if (bodies.first == kEndEffector) return with_effector(bodies.second, now);
    if (bodies.second == kTable)
      return with_table(bodies.first, point_[static_cast<std::size_t>(contact)], now);
    return of_two(bodies.first, bodies.second, now);
  }

  Contact with_effector(int i, const Now& now) const {
    const int first = parameters_.each_object ? i : 0, last = parameters_.each_object ? i : n_ - 1;
    int nearest = first;
    scene::Gap found{};
    for (int j = first; j <= last; ++j) {
      const scene::Gap gap = gap_to(now.object(j), now.scene);
      if (j == first || gap.distance < found.distance) {
        found = gap;
        nearest = j;
      }
    }
    Contact contact{found.distance,
                    parameters_.friction_end_effector,
                    found.normal,
                    {},
                    {},
                    kEndEffector,
                    nearest,
                    Vector3d::Zero(),
                    now.scene.effector.p_WE -
                        (found.distance + parameters_.end_effector_radius) * found.normal -
                        now.place(nearest).p};
    tangents(contact.normal, contact.t, contact.s);
    return contact;
  }

  Contact with_table(int i, int point, const Now& now) const {
    const scene::Place& place = now.place(i);
    const SupportPoints::Point& of = support_[static_cast<std::size_t>(now.object(i))].below(
        place.R)[static_cast<std::size_t>(point)];
    const Vector3d arm = place.R * of.p_B - of.radius * Vector3d::UnitZ();
    const double turned = point * M_PI / 8.0;
    return {place.p.z() + arm.z() - parameters_.table_height,
            parameters_.friction_table,
            Vector3d::UnitZ(),
            {std::cos(turned), std::sin(turned), 0.0},
            {-std::sin(turned), std::cos(turned), 0.0},
            i,
            kTable,
            arm,
            Vector3d::Zero()};
  }

  Contact of_two(int i, int j, const Now& now) const {
    const scene::Place &first = now.place(i), &second = now.place(j);
    const scene::Separation found = scene::separation(object(now.object(i)).shape(), first,
                                                      object(now.object(j)).shape(), second);
    Contact contact{found.distance,
                    parameters_.friction_objects,
                    found.normal,
                    {},
                    {},
                    i,
                    j,
                    found.p_first - first.p,
                    found.p_first - found.distance * found.normal - second.p};
    tangents(contact.normal, contact.t, contact.s);
    return contact;
  }

  /// The row of J along a direction; it is 0 before.
  template <typename Row>
  static void add_row(const Contact& contact, const Vector3d& direction, Row&& row) {
    const auto add = [&](int body, const Vector3d& arm, double sign) {
      if (body == kTable) return;
      if (body == kEndEffector) {
        row.template segment<3>(L::effector) += sign * direction.transpose();
        return;
      }
      row.template segment<3>(L::position(body)) += sign * direction.transpose();
      row.template segment<3>(L::rotation(body)) += sign * arm.cross(direction).transpose();
    };
    add(contact.first, contact.r_first, 1.0);
    add(contact.second, contact.r_second, -1.0);
  }

  ObjectsParameters parameters_;
  std::vector<SupportPoints> support_;
  int n_;  // objects that are in the model
  std::vector<Matrix3d> inverse_inertia_;
  std::vector<int> point_;  // of each contact with the table, which support point; else −1
};

}  // namespace

std::unique_ptr<PlanningModel> make_objects_model(const ObjectsParameters& parameters) {
  return std::make_unique<ObjectsModel>(parameters, support_of(parameters));
}

ModelKind mjcf_kind() {
  ModelKey objects{"objects"};
  objects.names_objects = true;
  ModelKey support{"support_points", 3, 4};
  support.missing = 4.0;
  ModelKey closest{"closest_objects", 0, kMostObjects};
  closest.missing = 0.0;
  ModelKey with_effector{"end_effector_contacts", 0, 0, {"nearest", "each"}};
  with_effector.missing = 0.0;
  ModelKey friction_objects{"friction_objects", 0, 10};
  friction_objects.missing = 0.3;
  ModelKey mass_scale{"mass_scale", 0.01, 100}, size_scale{"size_scale", 0.5, 2};
  mass_scale.missing = size_scale.missing = 1.0;
  ModelKey damping{"damping_per_s", 0, 1000};
  damping.missing = 0.0;
  return {"mjcf",
          1,
          kMostObjects,
          {objects,
           {"end_effector_mass_kg", 1e-4, 100},
           {"end_effector_radius_m", 1e-3, 1},
           {"table_height_m", -2, 2},
           {"friction_end_effector", 0, 10},
           {"friction_table", 0, 10},
           friction_objects,
           support,
           with_effector,
           closest,
           mass_scale,
           size_scale,
           damping},
          [](const ModelValues& of, int) {
            std::vector<scene::Object> planned;
            for (const scene::Object& each : of.objects())
              planned.push_back(scene::scaled(each, of["mass_scale"], of["size_scale"]));
            return make_objects_model(
                {of["end_effector_mass_kg"], of["end_effector_radius_m"], of["table_height_m"],
                 of["friction_end_effector"], of["friction_table"], of["friction_objects"],
                 static_cast<int>(of["support_points"]), of["end_effector_contacts"] == 1.0,
                 std::move(planned), static_cast<int>(of["closest_objects"]), of["damping_per_s"]});
          },
          "",
          ""};
}

}  // namespace c3rt::model
