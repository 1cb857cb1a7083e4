#include "controller/planner/task.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace c3rt::planner;
using Eigen::Vector2d;

namespace {
const CircleTask kCircle{{0.55, 0.0}, 0.1, 20.0 * M_PI / 180.0};
// a square of 0.1 m, a corner every 2 s: 8 s a round
const PathTask kSquare{
    {{0.5, -0.05}, {0.6, -0.05}, {0.6, 0.05}, {0.5, 0.05}}, 2.0, Between::kInterpolate, 0.0, true};
const LineTask kLine{0.55, -0.01, -0.1, 0.08};
}  // namespace

TEST_CASE("circle target: it lies on the circle, the lead ahead, clockwise seen from above") {
  // phase 0 is the positive y axis; 20 degrees on, x has grown
  const Vector2d target = circle_target(kCircle, {0.55, 0.1});
  CHECK(target.x() == Approx(0.55 + 0.1 * std::sin(kCircle.lead)));
  CHECK(target.y() == Approx(0.1 * std::cos(kCircle.lead)));
  for (double phase = -3.0; phase < 3.2; phase += 0.3) {
    for (const double radius : {0.02, 0.1, 0.3}) {
      const Vector2d ball = kCircle.center + radius * Vector2d(std::sin(phase), std::cos(phase));
      const Vector2d on_circle = circle_target(kCircle, ball) - kCircle.center;
      CHECK(on_circle.norm() == Approx(0.1));
      const double turned =
          std::remainder(std::atan2(on_circle.x(), on_circle.y()) - phase, 2.0 * M_PI);
      CHECK(turned == Approx(kCircle.lead));
    }
  }
}
TEST_CASE(
    "path: at constant speed along straight lines between the way-points, round after round") {
  CHECK((path_point(kSquare, 0.0) - Vector2d(0.5, -0.05)).norm() < 1e-12);
  CHECK((path_point(kSquare, 0.5) - Vector2d(0.525, -0.05)).norm() < 1e-12);
  CHECK((path_point(kSquare, 3.0) - Vector2d(0.6, 0.0)).norm() < 1e-12);
  CHECK((path_point(kSquare, 7.5) - Vector2d(0.5, -0.025)).norm() < 1e-12);  // back to the first
  CHECK(round_duration(kSquare) == Approx(8.0));
  for (double t = 0.0; t < 8.0; t += 0.37) {
    CHECK((path_point(kSquare, t + 80.0) - path_point(kSquare, t)).norm() < 1e-12);
    // 0.1 m in 2 s
    const double step = (path_point(kSquare, t + 1e-6) - path_point(kSquare, t)).norm();
    CHECK(step == Approx(0.05e-6).epsilon(1e-3));
  }
}

TEST_CASE("path: held, it stays at a way-point for the interval and jumps to the next") {
  PathTask held = kSquare;
  held.between = Between::kHold;
  for (int i = 0; i < 12; ++i) {
    const Vector2d& point = held.points[static_cast<std::size_t>(i % 4)];
    CHECK(path_point(held, 2.0 * i + 1e-9) == point);
    CHECK(path_point(held, 2.0 * i + 1.999) == point);
  }
}

TEST_CASE("path: before the task begins it is at the first way-point") {
  CHECK(path_point(kSquare, -3.0) == kSquare.points.front());
}

TEST_CASE("target: a path is looked at a lead ahead, and stage by stage only where it previews") {
  PathTask path = kSquare;
  path.lead = 0.3;
  const Vector2d ball(0.1, 0.2);  // of no matter
  CHECK(target(path, 1.0, 0.4, ball) == path_point(kSquare, 1.7));
  path.preview = false;
  CHECK(target(path, 1.0, 0.4, ball) == path_point(kSquare, 1.3));
}

TEST_CASE(
    "line: a ball is drawn a step along it and towards it, and no farther than its own place past "
    "the end") {
  CHECK((line_target(kLine, {0.552, 0.0}, 0) - Vector2d(0.55, -0.01)).norm() < 1e-15);
  // the last ball's place is a step past the end, the others' are farther by the spacing each
  CHECK((line_target(kLine, {0.55, -0.105}, 0) - Vector2d(0.55, -0.11)).norm() < 1e-15);
  CHECK((line_target(kLine, {0.55, -0.105}, 1) - Vector2d(0.55, -0.115)).norm() < 1e-15);
  CHECK((line_target(kLine, {0.55, -0.3}, 2) - Vector2d(0.55, -0.29)).norm() < 1e-15);
  CHECK(way_to_go(kLine, {0.5, 0.0}, 1) == Approx(0.19));
  const LineTask mirrored{0.55, 0.01, 0.1, 0.08};
  CHECK((line_target(mirrored, {0.55, 0.105}, 1) - Vector2d(0.55, 0.115)).norm() < 1e-15);
  CHECK(way_to_go(mirrored, {0.5, 0.0}, 1) == Approx(0.19));
}

TEST_CASE("target velocity: of a previewed path that moves, and of nothing else") {
  CHECK((target_velocity(kSquare, 0.5, 0.3) - Vector2d(0.05, 0.0)).norm() < 1e-12);
  CHECK((target_velocity(kSquare, 1.9, 0.3) - Vector2d(0.0, 0.05)).norm() < 1e-12);
  PathTask path = kSquare;
  path.preview = false;
  CHECK(target_velocity(path, 0.5, 0.3).isZero());
  path = kSquare;
  path.between = Between::kHold;
  CHECK(target_velocity(path, 0.5, 0.3).isZero());
  CHECK(target_velocity(kCircle, 0.5, 0.3).isZero());
  CHECK(target_velocity(kLine, 0.5, 0.3).isZero());
}

TEST_CASE("target: state-based tasks do not depend on time") {
  const Vector2d ball(0.52, 0.07);
  for (const double t : {0.0, 3.0, 1e4}) {
    CHECK(target(kCircle, t, 0.5, ball) == circle_target(kCircle, ball));
    CHECK((target(kLine, t, 0.5, ball) - Vector2d(0.53, 0.06)).norm() < 1e-15);
  }
}

TEST_CASE("line: a ball has arrived when it is past the end in the line's direction") {
  CHECK_FALSE(past_end(kLine, 0.0));
  CHECK(past_end(kLine, -0.1));
  CHECK(past_end(kLine, -0.2));
  const LineTask other_way{0.55, 0.01, 0.1, 0.08};
  CHECK_FALSE(past_end(other_way, 0.0));
  CHECK(past_end(other_way, 0.11));
}

TEST_CASE(
    "path error: to the line of a state-based task, to the point of the time of one in time") {
  CHECK(path_error(kCircle, 5.0, {0.55, 0.13}) == Approx(0.03));
  CHECK(path_error(kCircle, 5.0, {0.55, 0.0}) == Approx(0.1));
  CHECK(path_error(kLine, 5.0, {0.53, -7.0}) == Approx(0.02));
  // after 3 s the point is (0.6, 0): 30 mm and 40 mm off
  CHECK(path_error(kSquare, 3.0, {0.63, 0.04}) == Approx(0.05));
}

TEST_CASE("path error: held and interpolated paths differ by at most the way between way-points") {
  PathTask held = kSquare;
  held.between = Between::kHold;
  // a ball that moves with the interpolated path is up to a whole side ahead of the held point
  CHECK(path_error(held, 1.999, path_point(kSquare, 1.999)) == Approx(0.1).margin(1e-3));
  CHECK(path_error(held, 2.0, path_point(kSquare, 2.0)) == Approx(0.0).margin(1e-12));
}

TEST_CASE("middle: of a circle its centre, of a path the mean of its points, of a line its x") {
  CHECK(middle(kCircle) == kCircle.center);
  CHECK((middle(kSquare) - Vector2d(0.55, 0.0)).norm() < 1e-12);
  CHECK(middle(kLine).x() == 0.55);
}
