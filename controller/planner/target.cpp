#include "controller/planner/target.hpp"

#include <cmath>
#include <cstdio>

#include "controller/task/circle.hpp"

namespace c3rt::planner {
namespace {

constexpr double kMargin = 0.02;         // of the way inside the reach [m]
constexpr Interval kRadius{0.06, 0.15};  // that were shown to hold the ball [m]
constexpr Interval kLead{10.0 * M_PI / 180.0, 30.0 * M_PI / 180.0};  // the same [rad]
constexpr double kDegree = M_PI / 180.0;                             // [rad]

template <typename... Numbers>
std::string text(const char* format, Numbers... numbers) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, numbers...);
  return buffer;
}

// what is told as the limit is within it, whatever the rounding
bool inside(const Interval& interval, double value) {
  constexpr double kRounding = 1e-9;
  return value >= interval.min - kRounding && value <= interval.max + kRounding;
}

TargetVerdict fault(TargetFault kind, std::string sentence) { return {kind, std::move(sentence)}; }

TargetVerdict several(const TargetLimits& limits, const char* what) {
  return fault(TargetFault::kSeveralBalls,
               text("expected hold or scenario, as this scenario has %d balls; got a %s, which is "
                    "for one ball",
                    limits.balls, what));
}

TargetVerdict check_circle(const task::Circle& circle, const TargetLimits& limits) {
  if (limits.balls != 1) return several(limits, "circle");
  if (!circle.center.allFinite() || !std::isfinite(circle.radius) || !std::isfinite(circle.lead)) {
    return fault(TargetFault::kNotFinite,
                 text("expected finite numbers, got centre (%g, %g) m, radius %g m, lead %g deg",
                      circle.center.x(), circle.center.y(), circle.radius, circle.lead / kDegree));
  }
  if (!inside(limits.radius, circle.radius)) {
    return fault(TargetFault::kRadius, text("expected a radius of %g to %g m, got %g m",
                                            limits.radius.min, limits.radius.max, circle.radius));
  }
  if (!inside(limits.lead, std::abs(circle.lead))) {
    return fault(TargetFault::kLead,
                 text("expected a lead of %.0f to %.0f deg, or -%.0f to -%.0f deg, got %g deg",
                      limits.lead.min / kDegree, limits.lead.max / kDegree,
                      limits.lead.min / kDegree, limits.lead.max / kDegree, circle.lead / kDegree));
  }
  const double r = circle.radius;
  if (!inside({limits.x.min + r, limits.x.max - r}, circle.center.x()) ||
      !inside({limits.y.min + r, limits.y.max - r}, circle.center.y())) {
    return fault(TargetFault::kOutOfReach,
                 text("expected a centre with x in [%g, %g] and y in [%g, %g] m for a circle of "
                      "radius %g m, got (%g, %g)",
                      limits.x.min + r, limits.x.max - r, limits.y.min + r, limits.y.max - r, r,
                      circle.center.x(), circle.center.y()));
  }
  return {TargetFault::kNone, {}};
}

TargetVerdict check_point(const PointTarget& target, const TargetLimits& limits) {
  if (limits.balls != 1) return several(limits, "point");
  const Eigen::Vector2d& p = target.point;
  if (!p.allFinite()) {
    return fault(TargetFault::kNotFinite,
                 text("expected finite numbers, got the point (%g, %g) m", p.x(), p.y()));
  }
  if (!inside(limits.x, p.x()) || !inside(limits.y, p.y())) {
    return fault(TargetFault::kOutOfReach,
                 text("expected a point with x in [%g, %g] and y in [%g, %g] m, got (%g, %g)",
                      limits.x.min, limits.x.max, limits.y.min, limits.y.max, p.x(), p.y()));
  }
  return {TargetFault::kNone, {}};
}

}  // namespace

TargetLimits target_limits(const Parameters& parameters) {
  const ApproachParameters& reach = parameters.approach;
  return {parameters.model.bodies,
          {reach.reach_min.x() + kMargin, reach.reach_max.x() - kMargin},
          {reach.reach_min.y() + kMargin, reach.reach_max.y() - kMargin},
          kRadius,
          kLead};
}

TargetVerdict check(const Target& target, const TargetLimits& limits) {
  if (const auto* circle = std::get_if<task::Circle>(&target)) return check_circle(*circle, limits);
  if (const auto* point = std::get_if<PointTarget>(&target)) return check_point(*point, limits);
  return {TargetFault::kNone, {}};
}

std::string describe(const Target& target) {
  if (const auto* circle = std::get_if<task::Circle>(&target)) {
    return text("circle about (%g, %g) m, radius %g m, lead %g deg", circle->center.x(),
                circle->center.y(), circle->radius, circle->lead / kDegree);
  }
  if (const auto* to = std::get_if<PointTarget>(&target))
    return text("point (%g, %g) m", to->point.x(), to->point.y());
  return std::holds_alternative<HoldTarget>(target) ? "hold" : "the scenario's own task";
}

}  // namespace c3rt::planner
