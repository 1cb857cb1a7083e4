#pragma once
// What a client may want instead of the scenario's task, and what of it can be reached.
#include <string>
#include <variant>

#include <Eigen/Core>

#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// The scenario's own task.
struct ScenarioTarget {};
/// The ball that is worked on is brought to rest, then the end effector leaves it.
struct HoldTarget {};
/// The ball is brought here and comes to rest; one that creeps away is brought back.
struct PointTarget {
  Eigen::Vector2d point;  // in W [m]
};

using Target = std::variant<ScenarioTarget, HoldTarget, task::Circle, PointTarget>;

/// A client's target is drawn no farther from the ball than this, or a ball that is far from a new
/// circle would be thrown at it [m].
constexpr double kTargetPace = 0.04;

struct Interval {
  double min, max;
};

/// What the targets of a scenario have to keep.
struct TargetLimits {
  int balls;        // circles and points are for one
  Interval x, y;    // of every point of the way, in W [m]
  Interval radius;  // of a circle [m]
  Interval lead;    // of a circle, in either direction [rad]
};

TargetLimits target_limits(const Parameters& parameters);

enum class TargetFault { kNone, kNotFinite, kRadius, kLead, kOutOfReach, kSeveralBalls };

struct TargetVerdict {
  TargetFault fault;
  std::string sentence;  // what was expected and what came; empty if there is no fault
  bool ok() const { return fault == TargetFault::kNone; }
};

/// Whether a target can be reached and done.
TargetVerdict check(const Target& target, const TargetLimits& limits);

/// "circle about (0.55, 0) m, radius 0.1 m, lead 20 deg"
std::string describe(const Target& target);

}  // namespace c3rt::planner
