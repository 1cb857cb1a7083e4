#include "controller/planner/strategy/free_motion.hpp"

#include <algorithm>
#include <cmath>

#include "controller/planner/strategy/surface_samples.hpp"

namespace c3rt::planner {
namespace {

constexpr double kLook = 0.005;   // between two looks at a line [m]
constexpr double kAway = 0.5;     // a line that begins too near comes away by this much of itself
constexpr double kBraking = 0.8;  // of the acceleration, so that no corner is run past
constexpr double kTurning = 2.0;  // and the most that the velocity changes, in accelerations
constexpr double kBetter = 3e-4;  // by so much a place is farther from all bodies [m]
constexpr double kOff = 1e-3;  // farther than it has to be, so that the next line begins clear [m]

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

void FreeMotion::begin(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& v_WE) noexcept {
  reference_ = p_WE;
  velocity_ = v_WE;
  there_ = false;
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
  const Eigen::Vector3d corner = next_corner(scene, reference_, goal, safe, parameters_.clear);
  const Eigen::Vector3d way = corner - reference_;
  const double to_go = way.norm(), step = parameters_.acceleration * input.period;
  const double stopping = std::sqrt(2.0 * kBraking * parameters_.acceleration * to_go);
  const double speed = std::min({parameters_.speed, velocity_.norm() + step, stopping});
  if (to_go <= speed * input.period || to_go < 1e-6) {
    reference_ = corner;
    there_ = (corner - goal).isZero(1e-9);
    velocity_.setZero();
    return;
  }
  const Eigen::Vector3d change = speed / to_go * way - velocity_;
  velocity_ += change * std::min(1.0, kTurning * step / std::max(change.norm(), 1e-12));
  reference_ += velocity_ * input.period;
}

}  // namespace c3rt::planner
