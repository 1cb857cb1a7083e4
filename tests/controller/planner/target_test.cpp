#include "controller/planner/target.hpp"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "controller/task/circle.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Catch::Contains;

namespace {

constexpr double kDegree = M_PI / 180.0;
const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

/// As the circles of the paper have it: reach of 0.35 to 0.75 m by −0.3 to 0.3 m.
TargetLimits limits(int balls = 1) {
  Parameters parameters{};
  parameters.model.bodies = balls;
  parameters.approach.reach_min = {0.35, -0.3};
  parameters.approach.reach_max = {0.75, 0.3};
  return target_limits(parameters);
}

TargetVerdict circle(double x, double y, double radius, double lead_deg) {
  return check(task::Circle{{x, y}, radius, lead_deg * kDegree}, limits());
}

TargetVerdict point(double x, double y) { return check(PointTarget{{x, y}}, limits()); }

}  // namespace

TEST_CASE("target: the scenario's own, hold, and what lies within reach are taken") {
  CHECK(check(ScenarioTarget{}, limits()).ok());
  CHECK(check(HoldTarget{}, limits(3)).ok());
  CHECK(circle(0.55, 0.0, 0.1, 20.0).ok());
  CHECK(circle(0.55, 0.0, 0.1, -20.0).ok());
  CHECK(circle(0.5, 0.1, 0.06, 15.0).ok());
  CHECK(point(0.5, 0.0).ok());
  CHECK(point(0.6, -0.25).sentence.empty());
}

TEST_CASE("target: a circle is wholly within reach, with a margin for the ball's own errors") {
  for (const auto& [x, y] : {std::pair{5.0, 5.0}, {0.40, 0.0}, {0.70, 0.0}, {0.55, 0.25}}) {
    const TargetVerdict verdict = circle(x, y, 0.1, 20.0);
    CAPTURE(x, y);
    CHECK(verdict.fault == TargetFault::kOutOfReach);
    CHECK_THAT(verdict.sentence,
               Contains("expected a centre with x in [0.47, 0.63] and y in [-0.18, 0.18] m for a "
                        "circle of radius 0.1 m, got ("));
  }
  CHECK(circle(0.47, -0.18, 0.1, 20.0).ok());
  CHECK_FALSE(circle(0.469, -0.18, 0.1, 20.0).ok());
}

TEST_CASE("target: radius and lead are those that were shown to hold the ball") {
  for (const double radius : {0.5, 5.0, 0.011, 0.0, -0.1}) {
    CAPTURE(radius);
    const TargetVerdict verdict = circle(0.55, 0.0, radius, 20.0);
    CHECK(verdict.fault == TargetFault::kRadius);
    CHECK_THAT(verdict.sentence, Contains("expected a radius of 0.06 to 0.15 m, got"));
  }
  for (const double lead : {-180.0, 180.0, 400.0, 0.0, 3.0, -60.0, 40.0}) {
    CAPTURE(lead);
    const TargetVerdict verdict = circle(0.55, 0.0, 0.1, lead);
    CHECK(verdict.fault == TargetFault::kLead);
    CHECK_THAT(verdict.sentence,
               Contains("expected a lead of 10 to 30 deg, or -10 to -30 deg, got"));
  }
}

TEST_CASE("target: numbers that are not finite are refused, whichever it is") {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    CHECK(circle(bad, 0.0, 0.1, 20.0).fault == TargetFault::kNotFinite);
    CHECK(circle(0.55, bad, 0.1, 20.0).fault == TargetFault::kNotFinite);
    CHECK(circle(0.55, 0.0, bad, 20.0).fault == TargetFault::kNotFinite);
    CHECK(circle(0.55, 0.0, 0.1, bad).fault == TargetFault::kNotFinite);
    CHECK(point(bad, 0.0).fault == TargetFault::kNotFinite);
    CHECK(point(0.5, bad).fault == TargetFault::kNotFinite);
  }
}

TEST_CASE("target: a point is within reach") {
  const TargetVerdict verdict = point(0.9, 0.0);
  CHECK(verdict.fault == TargetFault::kOutOfReach);
  CHECK_THAT(verdict.sentence,
             Contains("expected a point with x in [0.37, 0.73] and y in [-0.28, 0.28] m, got (0.9, "
                      "0)"));
}

TEST_CASE("target: circles and points are for one ball") {
  for (const Target& target :
       {Target(task::Circle{{0.55, 0.0}, 0.1, 20.0 * kDegree}), Target(PointTarget{{0.55, 0.0}})}) {
    const TargetVerdict verdict = check(target, limits(3));
    CHECK(verdict.fault == TargetFault::kSeveralBalls);
    CHECK_THAT(verdict.sentence, Contains("3 balls"));
  }
}
