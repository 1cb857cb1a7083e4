#include "controller/planner/strategy/free_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "controller/planner/strategy/surface_samples.hpp"

namespace c3rt::planner {
namespace {

constexpr double kLook = 0.005;  // between two looks at a line [m]
constexpr double kAway = 0.5;    // a line that begins too near comes away by this much of itself
constexpr double kBrakingShare = 0.8;  // of the acceleration, so that no corner is run past
constexpr double kTurning = 2.0;       // and the most that the velocity changes, in accelerations
constexpr double kBetter = 3e-4;       // by so much a place is farther from all bodies [m]
constexpr double kOff = 1e-3;  // farther than it has to be, so that the next line begins clear [m]
constexpr double kLongestStep = 0.02;  // of the reference, at most; a period may be longer [s]

constexpr int kRing = 32;            // points round a body
constexpr int kRingMoves = 12;       // of each, towards the body
constexpr double kRingOff = 2.5e-3;  // a line between two of them is this much nearer at most [m]
constexpr double kSeenFrom = 0.5;    // from where they are moved there [m]
constexpr int kMostCorners = scene::kMaxBodies * kRing + 2;

/// Points of a way: its ends, and rings round the bodies.
struct Points {
  std::array<Eigen::Vector3d, kMostCorners> at;
  int count = 0;
  void add(const Eigen::Vector3d& point) noexcept { at[static_cast<std::size_t>(count++)] = point; }
};

/// Seen from the body's middle, the first points from outside that are no nearer than clear.
void add_ring(const scene::Scene& scene, int body, double height,
              const FreeMotionParameters& parameters, Points& points) noexcept {
  const scene::Body& of = scene.body(body);
  const Eigen::Vector3d middle(of.p_WB.x(), of.p_WB.y(), height);
  scene::Effector effector = scene.effector;
  for (int i = 0; i < kRing; ++i) {
    const double angle = 2.0 * M_PI * i / kRing;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    double far = extent(of, out) + kSeenFrom;
    for (int move = 0; move < kRingMoves; ++move) {
      effector.p_WE = middle + far * out;
      far -= scene::gap(effector, of).distance - parameters.clear - kRingOff;
    }
    const Eigen::Vector3d point = middle + far * out;
    if (parameters.reach.contains(point.head<2>()) &&
        nearest_gap(scene, point).distance >= parameters.clear)
      points.add(point);
  }
}

}  // namespace

bool line_is_free(const scene::Scene& scene, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                  double clear) noexcept {
  const double length = (to - from).norm();
  const double first = nearest_gap(scene, from).distance;
  const int looks = static_cast<int>(std::ceil(length / kLook));
  for (int i = 1; i <= looks; ++i) {
    const double part = static_cast<double>(i) / looks;
    const double least = std::min(clear, first + kAway * part * length);
    if (nearest_gap(scene, from + part * (to - from)).distance < least) return false;
  }
  return true;
}

Eigen::Vector3d next_corner(const scene::Scene& scene, const Eigen::Vector3d& from,
                            const Eigen::Vector3d& goal, double safe, double clear) noexcept {
  if (line_is_free(scene, from, goal, clear)) return goal;
  Eigen::Vector3d above(goal.x(), goal.y(), std::max(safe, goal.z()));
  if (line_is_free(scene, from, above, clear)) return above;
  const scene::Gap gap = nearest_gap(scene, from);
  Eigen::Vector3d up(from.x(), from.y(), std::max(safe, from.z()));
  if (gap.distance >= clear || gap.normal.z() > 0.9) return up;
  // level, as the table is below; no farther than to the middle between two faces, and from there
  // up along both
  const Eigen::Vector3d level(gap.normal.x(), gap.normal.y(), 0.0);
  const Eigen::Vector3d off =
      (clear + kOff - gap.distance) / std::max(level.norm(), 0.1) * level.normalized();
  for (const double part : {1.0, 0.5, 0.25}) {
    if (nearest_gap(scene, from + part * off).distance > gap.distance + kBetter)
      return from + part * off;
  }
  return up;
}

Leg next_leg_beside(const scene::Scene& scene, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& goal, const FreeMotionParameters& parameters) noexcept {
  const double clear = parameters.clear;
  if (line_is_free(scene, from, goal, clear)) return {goal, (goal - from).norm()};
  Points points;
  points.add(goal);
  points.add(from);
  for (int i = 0; i < scene.body_count; ++i) add_ring(scene, i, goal.z(), parameters, points);
  // Dijkstra's method from the goal back to here, so that the first leg is known at the end
  std::array<double, kMostCorners> left;
  std::array<std::size_t, kMostCorners> next{};
  std::array<bool, kMostCorners> done{};
  left.fill(std::numeric_limits<double>::infinity());
  left[0] = 0.0;
  const auto count = static_cast<std::size_t>(points.count);
  for (std::size_t round = 0; round < count; ++round) {
    std::size_t nearest = count;
    for (std::size_t i = 0; i < count; ++i) {
      if (!done[i] && std::isfinite(left[i]) && (nearest == count || left[i] < left[nearest]))
        nearest = i;
    }
    if (nearest == count) break;
    if (nearest == 1) return {points.at[next[1]], left[1]};
    done[nearest] = true;
    for (std::size_t i = 1; i < count; ++i) {
      const double through = left[nearest] + (points.at[i] - points.at[nearest]).norm();
      if (done[i] || through >= left[i]) continue;
      if (!line_is_free(scene, points.at[i], points.at[nearest], clear)) continue;
      left[i] = through;
      next[i] = nearest;
    }
  }
  const scene::Gap gap = nearest_gap(scene, from);
  const double off = std::max(0.0, clear + kOff - gap.distance);
  const Eigen::Vector3d level(gap.normal.x(), gap.normal.y(), 0.0);
  const Eigen::Vector3d corner = from + off * level.normalized();
  if (off <= kOff || !parameters.reach.contains(corner.head<2>())) return {from, 0.0};
  return {corner, off};
}

void FreeMotion::begin(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& v_WE) noexcept {
  reference_ = p_WE;
  velocity_ = v_WE;
  there_ = blocked_ = false;
}

void FreeMotion::step(const ApproachInput& input, const scene::Scene& scene,
                      const Eigen::Vector3d& goal, double safe) noexcept {
  there_ = false;
  if (!input.follows) {
    begin(input.p_WE, Eigen::Vector3d::Zero());
    return;
  }
  const Eigen::Vector3d lead = reference_ - input.p_WE;
  if (lead.norm() > parameters_.leash) {
    reference_ = input.p_WE + lead * (parameters_.leash / lead.norm());
    velocity_.setZero();
  }
  const int steps = static_cast<int>(std::ceil(input.period / kLongestStep - 1e-3));
  for (int i = 0; i < steps && !there_; ++i) advance(input.period / steps, scene, goal, safe);
}

void FreeMotion::advance(double period, const scene::Scene& scene, const Eigen::Vector3d& goal,
                         double safe) noexcept {
  Leg leg{};
  if (parameters_.over) {
    leg.corner = next_corner(scene, reference_, goal, safe, parameters_.clear);
    leg.left = (leg.corner - reference_).norm();
  } else {
    leg = next_leg_beside(scene, reference_, goal, parameters_);
    blocked_ = leg.left == 0.0 && leg.corner != goal;
  }
  const Eigen::Vector3d way = leg.corner - reference_;
  const double to_go = way.norm(), step = parameters_.acceleration * period;
  const double stopping = std::sqrt(2.0 * kBrakingShare * parameters_.acceleration * leg.left);
  const double speed = std::min({parameters_.speed, velocity_.norm() + step, stopping});
  if (to_go <= speed * period || to_go < 1e-6) {
    reference_ = leg.corner;
    there_ = (leg.corner - goal).isZero(1e-9);
    // it goes on round a body, but rests where it turns upwards or down
    velocity_ = leg.left > to_go + 1e-9 ? Eigen::Vector3d(speed / std::max(to_go, 1e-9) * way)
                                        : Eigen::Vector3d::Zero();
    return;
  }
  const Eigen::Vector3d change = speed / to_go * way - velocity_;
  velocity_ += change * std::min(1.0, kTurning * step / std::max(change.norm(), 1e-12));
  const Eigen::Vector3d before = reference_;
  reference_ += velocity_ * period;
  // all corners are within reach, but past one of them the velocity carries on
  if (!parameters_.over && parameters_.reach.contains(before.head<2>())) {
    reference_.head<2>() =
        reference_.head<2>().cwiseMax(parameters_.reach.min()).cwiseMin(parameters_.reach.max());
    velocity_ = (reference_ - before) / period;
  }
}

}  // namespace c3rt::planner
