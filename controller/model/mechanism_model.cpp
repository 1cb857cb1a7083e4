#include "controller/model/mechanism_model.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "controller/model/ball_model.hpp"
#include "controller/model/support_points.hpp"

namespace c3rt::model {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using scene::Coordinate;
using scene::Surface;

constexpr int kMostDirections = 8;
constexpr double kMostFriction = 10.0;

[[noreturn]] void fail(const std::string& expected, const std::string& got) {
  throw std::invalid_argument("mechanism: expected " + expected + ", got " + got);
}

SystemLayout layout_of(const MechanismParameters& p, const std::vector<std::string>& contacts) {
  SystemLayout layout;
  const auto turns = [](const Coordinate& of) {
    return of.kind == Coordinate::Kind::kHinge || of.kind == Coordinate::Kind::kRotation;
  };
  for (const Coordinate& of : p.mechanism->coordinates())
    layout.x.push_back({of.name, turns(of) ? "rad" : "m"});
  for (const Coordinate& of : p.mechanism->coordinates())
    layout.x.push_back({of.rate, turns(of) ? "rad_per_s" : "m_per_s"});
  for (const scene::Motor& motor : p.mechanism->motors())
    layout.u.push_back({motor.name, motor.turns ? "n_m" : "n"});
  const LambdaLayout order(p.contact_model, static_cast<int>(contacts.size()), 2 * p.directions);
  layout.lambda.resize(static_cast<std::size_t>(order.size()));
  const char* force = order.has_normal() ? "n" : "n_s";
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const int contact = static_cast<int>(i);
    const auto at = [&](int row) -> Quantity& {
      return layout.lambda[static_cast<std::size_t>(row)];
    };
    if (order.has_normal()) {
      at(order.gamma(contact)) = {contacts[i] + "_gamma", "m_per_s"};
      at(order.normal(contact)) = {contacts[i] + "_normal", force};
    }
    for (int edge = 0; edge < order.edge_count(); ++edge) {
      at(order.edges(contact) + edge) = {contacts[i] + "_edge_" + std::to_string(edge + 1), force};
    }
  }
  return layout;
}

void check(const MechanismParameters& p) {
  if (!p.mechanism) fail("one", "none");
  if (p.contacts.empty()) fail("contacts, as between: [FIRST, SECOND]", "none");
  if (p.directions < 0 || p.directions > kMostDirections) {
    fail("0 to " + std::to_string(kMostDirections) + " directions of friction",
         std::to_string(p.directions));
  }
  if (p.across && (!p.across->allFinite() || !(p.across->norm() > 0.0)))
    fail("a direction that the first one of friction is across", "none");
}

/// The surfaces of a geom, of a body with what is fixed to it, or of the world.
std::vector<int> surfaces_of(const scene::Mechanism& mechanism, const std::string& name) {
  const std::vector<Surface>& surfaces = mechanism.surfaces();
  const auto body = [&](const Surface& of) -> const std::string& {
    return mechanism.bodies()[static_cast<std::size_t>(of.body)].object.name;
  };
  std::vector<int> geoms, bodies, fixed;
  std::set<std::string> known;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Surface& of = surfaces[i];
    if (of.name == name) geoms.push_back(static_cast<int>(i));
    if (body(of) == name) bodies.push_back(static_cast<int>(i));
    if (of.owner == name) fixed.push_back(static_cast<int>(i));
    known.insert({of.name, body(of), of.owner});
  }
  for (const std::vector<int>* found : {&geoms, &bodies, &fixed})
    if (!found->empty()) return *found;
  std::string names;
  for (const std::string& each : known) names += (names.empty() ? "" : ", ") + each;
  fail("a body or geom that can touch: one of " + names, "\"" + name + "\"");
}

/// A sphere's distance is exact where it overlaps, too.
scene::Separation apart(const scene::Shape& first, const scene::Place& of_first,
                        const scene::Shape& second, const scene::Place& of_second) noexcept {
  const auto of_sphere = [](double radius, const Vector3d& center, const scene::Shape& other,
                            const scene::Place& place) {
    const scene::Nearest near = scene::nearest(other, place.R.transpose() * (center - place.p));
    const Vector3d normal = place.R * near.normal;
    return scene::Separation{near.distance - radius, normal, center - radius * normal};
  };
  if (first.kind == scene::ShapeKind::kSphere)
    return of_sphere(first.radius, of_first.p, second, of_second);
  if (second.kind == scene::ShapeKind::kSphere) {
    const scene::Separation found = of_sphere(second.radius, of_second.p, first, of_first);
    return {found.distance, -found.normal, found.p_first - found.distance * found.normal};
  }
  return scene::separation(first, of_first, second, of_second);
}

}  // namespace

/// Two surfaces, or one support point of a body and a plane.
struct MechanismModel::Candidate {
  int first, second;                  // rigid bodies
  int first_surface, second_surface;  // the first −1: a body's support point
  std::shared_ptr<const SupportPoints> support = nullptr;
  int point = -1;
  double mu;
};

/// Those of one `between`.
struct MechanismModel::Group {
  std::size_t first, count, chosen;  // candidates, and how many of them are in the model
};

struct MechanismModel::Plan {
  std::vector<Candidate> candidates;
  std::vector<Group> groups;
  std::vector<std::string> names;  // of the contacts in the model
};

MechanismModel::~MechanismModel() = default;

namespace {

/// What a body lies on a plane with: of those of its surfaces that are meant.
scene::Object lying(const scene::Mechanism& mechanism, const std::vector<int>& surfaces) {
  scene::Union parts;
  for (const int surface : surfaces)
    parts.parts.push_back(mechanism.surfaces()[static_cast<std::size_t>(surface)].part);
  return scene::make_object("", 1.0, Matrix3d::Identity(), 0.0, std::move(parts));
}

}  // namespace

MechanismModel::Plan MechanismModel::plan(const MechanismParameters& parameters) {
  check(parameters);
  const scene::Mechanism& mechanism = *parameters.mechanism;
  const auto surface = [&](int i) -> const Surface& {
    return mechanism.surfaces()[static_cast<std::size_t>(i)];
  };
  Plan plan;
  std::vector<Candidate>& candidates = plan.candidates;
  for (const Between& between : parameters.contacts) {
    Group group{candidates.size(), 0, 0};
    const std::vector<int> first = surfaces_of(mechanism, between.first),
                           second = surfaces_of(mechanism, between.second);
    const auto friction = [&](double a, double b) {
      return between.friction.value_or(std::max(a, b));
    };
    for (const int a : first) {
      for (const int b : second) {
        if (surface(a).body == surface(b).body || surface(a).is_plane || surface(b).is_plane)
          continue;
        candidates.push_back({surface(a).body, surface(b).body, a, b, nullptr, -1,
                              friction(surface(a).friction, surface(b).friction)});
      }
    }
    // of each body and each plane the support points
    const auto on_planes = [&](const std::vector<int>& bodies, const std::vector<int>& planes) {
      std::set<int> rigid;
      for (const int of : bodies)
        if (!surface(of).is_plane) rigid.insert(surface(of).body);
      for (const int plane : planes) {
        for (const int body : rigid) {
          if (!surface(plane).is_plane || surface(plane).body == body) continue;
          std::vector<int> parts;
          double rough = surface(plane).friction;
          for (const int of : bodies) {
            if (surface(of).body != body || surface(of).is_plane) continue;
            parts.push_back(of);
            rough = std::max(rough, surface(of).friction);
          }
          const auto support = std::make_shared<const SupportPoints>(lying(mechanism, parts),
                                                                     parameters.support_points);
          for (int point = 0; point < support->size(); ++point) {
            candidates.push_back({body, surface(plane).body, -1, plane, support, point,
                                  between.friction.value_or(rough)});
          }
        }
      }
    };
    on_planes(first, second);
    on_planes(second, first);
    group.count = candidates.size() - group.first;
    if (group.count == 0)
      fail("two that can touch", "\"" + between.first + "\" and \"" + between.second + "\"");
    if (between.closest < 0) fail("closest: 0 or more", std::to_string(between.closest));
    if (between.friction && !(*between.friction >= 0.0 && *between.friction <= kMostFriction))
      fail("friction: 0 to 10", std::to_string(*between.friction));
    group.chosen = between.closest == 0
                       ? group.count
                       : std::min(group.count, static_cast<std::size_t>(between.closest));
    for (std::size_t i = 0; i < group.chosen; ++i) {
      plan.names.push_back(between.first + "_" + between.second +
                           (group.chosen > 1 ? "_" + std::to_string(i + 1) : ""));
    }
    plan.groups.push_back(group);
  }
  return plan;
}

MechanismModel::MechanismModel(const MechanismParameters& parameters)
    : MechanismModel(parameters, plan(parameters)) {}

MechanismModel::MechanismModel(const MechanismParameters& parameters, Plan plan)
    : SystemModel(layout_of(parameters, plan.names)),
      parameters_(parameters),
      candidates_(std::move(plan.candidates)),
      groups_(std::move(plan.groups)),
      places_(mechanism().bodies().size()),
      measured_(candidates_.size()),
      found_(plan.names.size()),
      J_first_(3, mechanism().n_v()),
      J_second_(3, mechanism().n_v()) {
  order_.reserve(candidates_.size());
}

scene::Place MechanismModel::place_of(int surface) const noexcept {
  const Surface& of = mechanism().surfaces()[static_cast<std::size_t>(surface)];
  const scene::Place& body = places_[static_cast<std::size_t>(of.body)];
  return {body.p + body.R * of.part.p_BP, body.R * of.part.R_BP};
}

void MechanismModel::measure(const Candidate& candidate, Contact& contact) const {
  contact.first = candidate.first;
  contact.second = candidate.second;
  contact.first_surface = candidate.first_surface;
  contact.second_surface = candidate.second_surface;
  contact.mu = candidate.mu;
  const scene::Place second = place_of(candidate.second_surface);
  if (candidate.support) {
    const scene::Place& body = places_[static_cast<std::size_t>(candidate.first)];
    const SupportPoints::Point& point = candidate.support->below(
        second.R.transpose() * body.R)[static_cast<std::size_t>(candidate.point)];
    contact.normal = second.R.col(2);
    contact.p_first = body.p + body.R * point.p_B - point.radius * contact.normal;
    contact.distance = contact.normal.dot(contact.p_first - second.p);
  } else {
    const auto shape = [&](int i) -> const scene::Shape& {
      return mechanism().surfaces()[static_cast<std::size_t>(i)].part.shape;
    };
    const scene::Separation found =
        apart(shape(candidate.first_surface), place_of(candidate.first_surface),
              shape(candidate.second_surface), second);
    contact.distance = found.distance;
    contact.normal = found.normal;
    contact.p_first = found.p_first;
  }
  contact.p_second = contact.p_first - contact.distance * contact.normal;
  tangents(contact.normal, contact.t, contact.s);
  if (parameters_.across) {
    const Vector3d across = parameters_.across->cross(contact.normal);
    if (across.norm() > 1e-6 * parameters_.across->norm()) {
      contact.t = across.normalized();
      contact.s = contact.normal.cross(contact.t);
    }
  }
  if (candidate.support && parameters_.directions > 1) {
    // aligned edges resist no turn while a body slides along one
    const double turned = candidate.point * M_PI / (4.0 * parameters_.directions);
    const Vector3d t = contact.t, s = contact.s;
    contact.t = std::cos(turned) * t + std::sin(turned) * s;
    contact.s = std::cos(turned) * s - std::sin(turned) * t;
  }
}

void MechanismModel::choose(const Group& group, std::size_t& count) const {
  order_.clear();
  for (std::size_t i = group.first; i < group.first + group.count; ++i)
    order_.push_back(static_cast<int>(i));
  const auto chosen = order_.begin() + static_cast<std::ptrdiff_t>(group.chosen);
  const auto distance = [&](int i) { return measured_[static_cast<std::size_t>(i)].distance; };
  std::nth_element(order_.begin(), chosen, order_.end(), [&](int a, int b) {
    return distance(a) < distance(b) || (distance(a) == distance(b) && a < b);
  });
  std::sort(order_.begin(), chosen);
  for (auto at = order_.begin(); at != chosen; ++at)
    found_[count++] = measured_[static_cast<std::size_t>(*at)];
}

void MechanismModel::evaluate(const Eigen::Ref<const VectorXd>& x, ContactSystem& system) const {
  scene::Mechanism& mechanism = *parameters_.mechanism;
  const Eigen::Index n_v = mechanism.n_v();
  const auto q = x.head(n_v), v = x.tail(n_v);
  mechanism.evaluate(q, v, motion_);
  system.q = q;
  system.N_q = motion_.N_q;
  system.N_q_plus = motion_.N_q_inverse;
  system.M_inverse = motion_.M_inverse;
  system.J_f_q = motion_.J_q;
  system.J_f_v = motion_.J_v;
  system.J_f_u = motion_.J_u;
  system.d_v = motion_.f;
  system.d_v.noalias() -= motion_.J_q * q;
  system.d_v.noalias() -= motion_.J_v * v;

  for (std::size_t i = 0; i < places_.size(); ++i)
    places_[i] = mechanism.place(static_cast<int>(i));
  for (std::size_t i = 0; i < candidates_.size(); ++i) measure(candidates_[i], measured_[i]);
  std::size_t count = 0;
  for (const Group& group : groups_) choose(group, count);

  const auto n_contacts = static_cast<Eigen::Index>(found_.size());
  const Eigen::Index edges = n_e();
  system.phi.resize(n_contacts);
  system.distance.resize(n_contacts);
  system.mu.resize(n_contacts);
  system.J_n.resize(n_contacts, n_v);
  system.J_t.resize(n_contacts * edges, n_v);
  const auto driven = [&](int body) {
    return mechanism.bodies()[static_cast<std::size_t>(body)].driven;
  };
  for (Eigen::Index i = 0; i < n_contacts; ++i) {
    const Contact& contact = found_[static_cast<std::size_t>(i)];
    const bool pushes = contact.first != 0 && contact.second != 0 &&
                        driven(contact.first) != driven(contact.second);
    system.distance[i] = contact.distance;
    system.phi[i] = pushes ? no_overlap(contact.distance) : contact.distance;
    system.mu[i] = contact.mu;
    mechanism.jacobian(contact.first, contact.p_first, J_first_);
    mechanism.jacobian(contact.second, contact.p_second, J_second_);
    J_first_ -= J_second_;
    system.J_n.row(i).noalias() = contact.normal.transpose() * J_first_;
    for (Eigen::Index edge = 0; edge < edges; edge += 2) {
      const double angle = M_PI * static_cast<double>(edge) / static_cast<double>(edges);
      const Vector3d along = std::cos(angle) * contact.t + std::sin(angle) * contact.s;
      system.J_t.row(i * edges + edge).noalias() = along.transpose() * J_first_;
      system.J_t.row(i * edges + edge + 1) = -system.J_t.row(i * edges + edge);
    }
  }
}

lcs::Lcs MechanismModel::planning_system(const VectorXd& x, double dt) const {
  ContactSystem system;
  evaluate(x, system);
  return to_lcs(parameters_.contact_model, system, dt);
}

void MechanismModel::clip(Eigen::Ref<VectorXd> u) const {
  for (std::size_t i = 0; i < mechanism().motors().size(); ++i) {
    const scene::Motor& motor = mechanism().motors()[i];
    double& input = u[static_cast<Eigen::Index>(i)];
    input = std::min(std::max(input, motor.min), motor.max);
  }
}

SystemKind mechanism_kind() {
  ModelKey file{"mjcf"};
  file.names_mechanism = true;
  ModelKey contact_model{"contact_model", 0, 0, {"stewart_trinkle", "anitescu"}};
  ModelKey directions{"directions", 0, kMostDirections}, support{"support_points", 3, 4};
  return {"mechanism",
          {file, contact_model, directions, support},
          [](const ModelValues& of) -> std::shared_ptr<const SystemModel> {
            MechanismParameters parameters;
            parameters.mechanism = of.mechanism();
            parameters.contacts = of.contacts();
            parameters.contact_model = of["contact_model"] == 0.0 ? ContactModel::kStewartTrinkle
                                                                  : ContactModel::kAnitescu;
            parameters.directions = static_cast<int>(of["directions"]);
            parameters.support_points = static_cast<int>(of["support_points"]);
            return std::make_shared<MechanismModel>(parameters);
          }};
}

}  // namespace c3rt::model
