#include "controller/planner/strategy/surface_samples.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::planner {
namespace {

constexpr double kFar = 2.0;          // the surface is looked at from here [m]
constexpr int kTries = 12;            // points
constexpr int kMoves = 12;            // of a point
constexpr double kExact = 5e-4;       // of the clearance [m]
constexpr double kColumnStep = 0.01;  // [m]

}  // namespace

scene::Gap nearest_gap(const scene::Scene& scene, const Eigen::Vector3d& p_WE) noexcept {
  scene::Effector effector = scene.effector;
  effector.p_WE = p_WE;
  scene::Gap least{1e9, Eigen::Vector3d::UnitZ()};
  for (int i = 0; i < scene.body_count; ++i) {
    const scene::Gap gap = scene::gap(effector, scene.body(i));
    if (gap.distance < least.distance) least = gap;
  }
  return least;
}

double extent(const scene::Body& body, const Eigen::Vector3d& direction) noexcept {
  scene::Effector eye;
  eye.p_WE = body.p_WB + kFar * direction;
  return kFar - scene::gap(eye, body).distance;
}

double top_of(const scene::Scene& scene) noexcept {
  double top = scene.table_height;
  for (int i = 0; i < scene.body_count; ++i) {
    const scene::Body& body = scene.body(i);
    top = std::max(top, body.p_WB.z() + extent(body, Eigen::Vector3d::UnitZ()));
  }
  return top;
}

bool column_is_free(const scene::Scene& scene, const SampleRules& rules,
                    const Eigen::Vector3d& place) noexcept {
  const int steps = static_cast<int>(std::ceil((rules.top - place.z()) / kColumnStep));
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector3d p_WE(place.x(), place.y(),
                               std::min(rules.top, place.z() + i * kColumnStep));
    if (nearest_gap(scene, p_WE).distance < rules.column) return false;
  }
  return true;
}

std::optional<Eigen::Vector3d> surface_sample(const scene::Scene& scene, int body,
                                              const SampleRules& rules,
                                              base::Random& random) noexcept {
  const scene::Body& of = scene.body(body);
  double round = 0.0;
  for (int i = 0; i < 8; ++i) {
    const double angle = 0.25 * M_PI * i;
    round = std::max(round, extent(of, {std::cos(angle), std::sin(angle), 0.0}));
  }
  scene::Effector effector = scene.effector;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    // always two numbers a try, so that a point does not depend on what became of others
    const double far = std::sqrt(random.uniform()), angle = 2.0 * M_PI * random.uniform();
    const Eigen::Vector2d about(std::cos(angle), std::sin(angle));
    const double radius = far * (round + rules.clearance + effector.radius);
    effector.p_WE << of.p_WB.head<2>() + radius * about, rules.height;
    bool there = false;
    for (int move = 0; move < kMoves && !there; ++move) {
      const scene::Gap gap = scene::gap(effector, of);
      const double too_far = gap.distance - rules.clearance;
      there = std::abs(too_far) < kExact;
      Eigen::Vector2d out = gap.normal.head<2>();
      // below a face that lies flat: outwards
      out = out.norm() < kLeastAlongTable ? about : Eigen::Vector2d(out.normalized());
      if (!there) effector.p_WE.head<2>() -= too_far * out;
    }
    const Eigen::Vector2d at = effector.p_WE.head<2>();
    if (!there || !rules.reach.contains(at) || at.norm() > rules.reach_radius) continue;
    if (column_is_free(scene, rules, effector.p_WE)) return effector.p_WE;
  }
  return std::nullopt;
}

}  // namespace c3rt::planner
