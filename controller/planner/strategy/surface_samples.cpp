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
// How often a place is taken from which a push does nothing that is wanted, or the contrary: a plan
// may know better.
constexpr double kLeastTaken = 0.5;
// A body that slides on its whole face turns about a push that passes its middle at this part of
// its outer radius as fast, seen from there, as it moves.
constexpr double kTurningRadius = 0.6;

/// From 1, as wanted, to -1: how a body would move that is pushed along the table.
/// @param lever of the push about the body's middle, in units of its turning radius
double serves(const SampleRules& rules, const Eigen::Vector2d& push, double lever,
              double turning_radius) {
  const Eigen::Vector3d moves(push.x(), push.y(), rules.radian * lever / turning_radius);
  return moves.normalized().dot(rules.wanted.normalized());
}

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
  const bool all_alike = rules.wanted.isZero();
  std::optional<Eigen::Vector3d> passed_over;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    // always as many numbers a try, so that a point does not depend on what became of others
    const double taken = all_alike ? 0.0 : random.uniform();
    const double far = std::sqrt(random.uniform()), angle = 2.0 * M_PI * random.uniform();
    const Eigen::Vector2d about(std::cos(angle), std::sin(angle));
    const double radius = far * (round + rules.clearance + effector.radius);
    effector.p_WE << of.p_WB.head<2>() + radius * about, rules.height;
    bool there = false;
    Eigen::Vector2d away = about;
    for (int move = 0; move < kMoves && !there; ++move) {
      const scene::Gap gap = scene::gap(effector, of);
      const double too_far = gap.distance - rules.clearance;
      there = std::abs(too_far) < kExact;
      Eigen::Vector2d out = gap.normal.head<2>();
      // below a face that lies flat: outwards
      out = out.norm() < kLeastAlongTable ? about : Eigen::Vector2d(out.normalized());
      if (!there) effector.p_WE.head<2>() -= too_far * out;
      away = out;
    }
    const Eigen::Vector2d at = effector.p_WE.head<2>();
    if (!there || !rules.reach.contains(at) || at.norm() > rules.reach_radius) continue;
    if (!column_is_free(scene, rules, effector.p_WE)) continue;
    const Eigen::Vector2d touches =
        at - (rules.clearance + effector.radius) * away - of.p_WB.head<2>();
    const double turning_radius = kTurningRadius * round;
    const double lever = (touches.y() * away.x() - touches.x() * away.y()) / turning_radius;
    const double serving = all_alike ? 1.0 : serves(rules, -away, lever, turning_radius);
    if (taken <= kLeastTaken + (1.0 - kLeastTaken) * std::max(0.0, serving)) return effector.p_WE;
    passed_over = effector.p_WE;
  }
  return passed_over;
}

}  // namespace c3rt::planner
