#include "controller/planner/strategy/heuristic.hpp"

#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "controller/planner/strategy/time_heuristic.hpp"
#include "controller/task/circle.hpp"
#include "controller/task/line.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {
const HeuristicParameters kHeuristic{1.0,  0.5,  0.004, 0.02, {0.0951, 0.0911, 0.0691},
                                     0.0,  0.01, 0.03,  0.0,  false,
                                     10.0, 1.0,  1.0,   0.03, 0.1};
const Geometry kGeometry{0.0195, -0.0245};
constexpr double kRadius = 0.0315;
}  // namespace

TEST_CASE(
    "heuristic: a cycle is half a second of return in three parts, then a second of rolling") {
  CHECK(phase_at(kHeuristic, 0.0) == Phase::kReturnUp);
  CHECK(phase_at(kHeuristic, 0.16) == Phase::kReturnUp);
  CHECK(phase_at(kHeuristic, 0.17) == Phase::kReturnSideways);
  CHECK(phase_at(kHeuristic, 0.34) == Phase::kReturnDown);
  CHECK(phase_at(kHeuristic, 0.5) == Phase::kRoll);
  CHECK(phase_at(kHeuristic, 1.49) == Phase::kRoll);
  CHECK(phase_at(kHeuristic, 1.51) == Phase::kReturnUp);
  CHECK(phase_at(kHeuristic, 1500.01) == Phase::kReturnUp);
}

TEST_CASE("heuristic: the end effector is drawn above the ball, then up, behind it, and down") {
  const Vector3d end_effector(0.5, 0.05, 0.06), ball(0.55, 0.1, 0.007);
  const Vector2d target(0.55 + 0.1, 0.1);  // straight along +x
  const auto at = [&](Phase phase) {
    return end_effector_target(kHeuristic, kGeometry, phase, end_effector, kRadius, ball, target);
  };
  CHECK((at(Phase::kRoll) - Vector3d(0.55, 0.1, 0.062)).norm() < 1e-12);  // FIGURES 4.6
  CHECK((at(Phase::kReturnUp) - Vector3d(0.5, 0.05, 0.0951 - 0.0245)).norm() < 1e-12);
  CHECK((at(Phase::kReturnSideways) - Vector3d(0.53, 0.1, 0.0911 - 0.0245)).norm() < 1e-12);
  CHECK((at(Phase::kReturnDown) - Vector3d(0.53, 0.1, 0.0691 - 0.0245)).norm() < 1e-12);
}

TEST_CASE("heuristic: a ball on its target gives a finite target above it") {
  const Vector3d ball(0.55, 0.1, 0.007);
  const Vector3d target = end_effector_target(kHeuristic, kGeometry, Phase::kReturnDown, ball,
                                              kRadius, ball, ball.head<2>());
  CHECK(target.allFinite());
}

TEST_CASE("planner mode: what comes next in every situation") {
  const auto situation = [](bool state, bool ball, bool hold, bool reached, bool returning) {
    Known known{};
    known.state_fresh = state;
    known.spheres_at_hand = ball;
    known.hold_requested = hold;
    known.start_pose_reached = reached;
    known.returning = returning;
    return known;
  };
  for (const TimeHeuristicMode mode :
       {TimeHeuristicMode::kWait, TimeHeuristicMode::kApproach, TimeHeuristicMode::kRoll,
        TimeHeuristicMode::kReturn, TimeHeuristicMode::kRest, TimeHeuristicMode::kHold}) {
    CHECK(next(mode, situation(false, true, false, true, false)) == TimeHeuristicMode::kWait);
    CHECK(next(mode, situation(true, false, false, true, false)) == TimeHeuristicMode::kHold);
    CHECK(next(mode, situation(true, true, true, true, false)) == TimeHeuristicMode::kHold);
  }
  CHECK(next(TimeHeuristicMode::kWait, situation(true, true, false, true, true)) ==
        TimeHeuristicMode::kApproach);
  CHECK(next(TimeHeuristicMode::kHold, situation(true, true, false, true, true)) ==
        TimeHeuristicMode::kApproach);
  CHECK(next(TimeHeuristicMode::kApproach, situation(true, true, false, false, true)) ==
        TimeHeuristicMode::kApproach);
  CHECK(next(TimeHeuristicMode::kApproach, situation(true, true, false, true, true)) ==
        TimeHeuristicMode::kReturn);
  CHECK(next(TimeHeuristicMode::kReturn, situation(true, true, false, false, true)) ==
        TimeHeuristicMode::kReturn);
  CHECK(next(TimeHeuristicMode::kReturn, situation(true, true, false, false, false)) ==
        TimeHeuristicMode::kRoll);
  CHECK(next(TimeHeuristicMode::kRoll, situation(true, true, false, false, true)) ==
        TimeHeuristicMode::kReturn);
  // to another ball through the air
  Known other = situation(true, true, false, false, true);
  other.other_sphere = true;
  CHECK(next(TimeHeuristicMode::kRoll, other) == TimeHeuristicMode::kApproach);
  other.spheres_at_hand = false;
  CHECK(next(TimeHeuristicMode::kRoll, other) == TimeHeuristicMode::kHold);
  // a ball is brought to rest before the end effector leaves it
  Known rest = situation(true, true, false, false, false);
  rest.rest_wanted = true;
  CHECK(next(TimeHeuristicMode::kRoll, rest) == TimeHeuristicMode::kRest);
  CHECK(next(TimeHeuristicMode::kRest, rest) == TimeHeuristicMode::kRest);
  rest.sphere_left = true;
  CHECK(next(TimeHeuristicMode::kRest, rest) == TimeHeuristicMode::kHold);
  // where the robot did not follow, what was going on is over
  Known left = situation(true, true, false, false, false);
  left.robot_left = true;
  CHECK(next(TimeHeuristicMode::kRoll, left) == TimeHeuristicMode::kApproach);
  CHECK(next(TimeHeuristicMode::kRest, left) == TimeHeuristicMode::kApproach);
}

namespace {
const task::Line kLine{0.55, -0.01, -0.1, 0.08};

scene::Scene balls_at(const std::vector<Vector2d>& places) {
  scene::Scene scene;
  scene.body_count = static_cast<int>(places.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Vector2d at = i < places.size() ? places[i] : Vector2d::Zero();
    scene.bodies[i].p_WB << at, 0.0;
  }
  return scene;
}

int choice(const scene::Scene& scene, int now) {
  return sphere_to_work_on(kHeuristic, kLine, scene, now);
}
}  // namespace

TEST_CASE("heuristic: along a line the ball that is farthest behind is worked on") {
  CHECK(choice(balls_at({{0.55, 0.2}, {0.55, 0.05}}), 1) == 0);
  CHECK(choice(balls_at({{0.55, 0.05}, {0.55, 0.2}}), 0) == 1);
  CHECK(choice(balls_at({{0.55, 0.0}, {0.55, 0.13}, {0.55, 0.26}, {0.55, -0.13}}), 0) == 2);
  CHECK(sphere_to_work_on(kHeuristic, task::Circle{{0.55, 0.0}, 0.1, 0.3},
                          balls_at({{0.55, 0.05}, {0.55, 0.2}}), 0) == 0);
}

TEST_CASE("heuristic: a ball in the way of the one behind it goes first") {
  // 73 mm ahead, as the balls of the paper begin: rolling into it would jam both
  CHECK(choice(balls_at({{0.55, 0.1}, {0.55, 0.027}}), 0) == 1);
  // and the one in that one's way before both
  CHECK(choice(balls_at({{0.55, 0.1}, {0.55, 0.03}, {0.55, -0.04}}), 0) == 2);
  CHECK(choice(balls_at({{0.45, 0.1}, {0.55, 0.03}}), 0) == 0);  // beside it, not in the way
}

TEST_CASE("heuristic: a ball at its place is not in the way of the one behind it") {
  // places at -0.11 and -0.19: nothing would be won by touching the one that is there, for ever
  CHECK(choice(balls_at({{0.55, -0.085}, {0.55, -0.18}}), 0) == 0);
  CHECK(choice(balls_at({{0.55, -0.10}, {0.55, -0.195}}), 0) == 0);  // and a little past it
  CHECK(choice(balls_at({{0.55, -0.05}, {0.55, -0.14}}), 0) == 1);   // not yet there
}

TEST_CASE("heuristic: a ball that strays from the line or rolls past its place is looked after") {
  // places at -0.11 and -0.19: of the first two the other is nearly there
  CHECK(choice(balls_at({{0.55, -0.10}, {0.64, -0.19}}), 0) == 1);
  scene::Scene runaway = balls_at({{0.55, -0.10}, {0.55, -0.21}});
  CHECK(choice(runaway, 0) == 0);
  runaway.body(1).v_WB.y() = -0.1;
  CHECK(choice(runaway, 0) == 1);
}

TEST_CASE("heuristic: a change of balls has to be worth it") {
  // the places are 80 mm apart: ways of 0.21 and 0.35 m, of which 0.12 m beside the line
  const scene::Scene scene = balls_at({{0.55, 0.1}, {0.67, 0.04}});
  CHECK(choice(scene, 0) == 1);
  const scene::Scene alike = balls_at({{0.55, 0.1}, {0.56, 0.0}});  // 0.21 and 0.20 m
  CHECK(choice(alike, 0) == 0);
  CHECK(choice(alike, 1) == 1);
}
