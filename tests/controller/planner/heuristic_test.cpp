#include "controller/planner/heuristic.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "controller/planner/planner.hpp"

using namespace c3rt::planner;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {
const HeuristicParameters kHeuristic{1.0, 0.5, 0.004, 0.02, {0.0951, 0.0911, 0.0691}};
const c3rt::model::BallModelParameters kModel{0.01, 0.0195, 0.132, 0.0315, -0.0245, 1.0, 1.0};
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
    return end_effector_target(kHeuristic, kModel, phase, end_effector, ball, target);
  };
  CHECK((at(Phase::kRoll) - Vector3d(0.55, 0.1, 0.062)).norm() < 1e-12);  // FIGURES 4.6
  CHECK((at(Phase::kReturnUp) - Vector3d(0.5, 0.05, 0.0951 - 0.0245)).norm() < 1e-12);
  CHECK((at(Phase::kReturnSideways) - Vector3d(0.53, 0.1, 0.0911 - 0.0245)).norm() < 1e-12);
  CHECK((at(Phase::kReturnDown) - Vector3d(0.53, 0.1, 0.0691 - 0.0245)).norm() < 1e-12);
}

TEST_CASE("heuristic: a ball on its target gives a finite target above it") {
  const Vector3d ball(0.55, 0.1, 0.007);
  const Vector3d target =
      end_effector_target(kHeuristic, kModel, Phase::kReturnDown, ball, ball, ball.head<2>());
  CHECK(target.allFinite());
}

TEST_CASE("planner mode: what comes next in every situation") {
  const auto situation = [](bool state, bool ball, bool hold, bool reached, bool returning) {
    return Situation{state, ball, hold, reached, returning};
  };
  for (const Mode mode : {Mode::kWait, Mode::kApproach, Mode::kRoll, Mode::kReturn, Mode::kHold}) {
    CHECK(next(mode, situation(false, true, false, true, false)) == Mode::kWait);
    CHECK(next(mode, situation(true, false, false, true, false)) == Mode::kHold);
    CHECK(next(mode, situation(true, true, true, true, false)) == Mode::kHold);
  }
  CHECK(next(Mode::kWait, situation(true, true, false, true, true)) == Mode::kApproach);
  CHECK(next(Mode::kHold, situation(true, true, false, true, true)) == Mode::kApproach);
  CHECK(next(Mode::kApproach, situation(true, true, false, false, true)) == Mode::kApproach);
  CHECK(next(Mode::kApproach, situation(true, true, false, true, true)) == Mode::kReturn);
  CHECK(next(Mode::kReturn, situation(true, true, false, false, true)) == Mode::kReturn);
  CHECK(next(Mode::kReturn, situation(true, true, false, false, false)) == Mode::kRoll);
  CHECK(next(Mode::kRoll, situation(true, true, false, false, true)) == Mode::kReturn);
}
