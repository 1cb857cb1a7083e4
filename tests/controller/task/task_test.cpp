#include "controller/task/task.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "controller/task/circle.hpp"
#include "controller/task/line.hpp"
#include "controller/task/path.hpp"
#include "controller/task/pose.hpp"
#include "controller/task/request.hpp"

using namespace c3rt;
using namespace c3rt::task;
using Eigen::Vector2d;

namespace {
const Circle kCircle{{0.55, 0.0}, 0.1, 20.0 * M_PI / 180.0};
// a square of 0.1 m, a corner every 2 s: 8 s a round
const Path kSquare{
    {{0.5, -0.05}, {0.6, -0.05}, {0.6, 0.05}, {0.5, 0.05}}, 2.0, Between::kInterpolate, 0.0, true};
const Line kLine{0.55, -0.01, -0.1, 0.08};

scene::Scene with(const Vector2d& body) {
  scene::Scene scene;
  scene.body_count = 1;
  scene.body(0).p_WB << body, 0.0;
  return scene;
}
}  // namespace

TEST_CASE("circle target: it lies on the circle, the lead ahead, clockwise seen from above") {
  // phase 0 is the positive y axis; 20 degrees on, x has grown
  const Vector2d target = kCircle.next({0.55, 0.1});
  CHECK(target.x() == Approx(0.55 + 0.1 * std::sin(kCircle.lead)));
  CHECK(target.y() == Approx(0.1 * std::cos(kCircle.lead)));
  for (double phase = -3.0; phase < 3.2; phase += 0.3) {
    for (const double radius : {0.02, 0.1, 0.3}) {
      const Vector2d ball = kCircle.center + radius * Vector2d(std::sin(phase), std::cos(phase));
      const Vector2d on_circle = kCircle.next(ball) - kCircle.center;
      CHECK(on_circle.norm() == Approx(0.1));
      const double turned =
          std::remainder(std::atan2(on_circle.x(), on_circle.y()) - phase, 2.0 * M_PI);
      CHECK(turned == Approx(kCircle.lead));
    }
  }
}
TEST_CASE(
    "path: at constant speed along straight lines between the way-points, round after round") {
  CHECK((kSquare.point(0.0) - Vector2d(0.5, -0.05)).norm() < 1e-12);
  CHECK((kSquare.point(0.5) - Vector2d(0.525, -0.05)).norm() < 1e-12);
  CHECK((kSquare.point(3.0) - Vector2d(0.6, 0.0)).norm() < 1e-12);
  CHECK((kSquare.point(7.5) - Vector2d(0.5, -0.025)).norm() < 1e-12);  // back to the first
  CHECK(kSquare.round_duration() == Approx(8.0));
  for (double t = 0.0; t < 8.0; t += 0.37) {
    CHECK((kSquare.point(t + 80.0) - kSquare.point(t)).norm() < 1e-12);
    // 0.1 m in 2 s
    const double step = (kSquare.point(t + 1e-6) - kSquare.point(t)).norm();
    CHECK(step == Approx(0.05e-6).epsilon(1e-3));
  }
}

TEST_CASE("path: held, it stays at a way-point for the interval and jumps to the next") {
  Path held = kSquare;
  held.between = Between::kHold;
  for (int i = 0; i < 12; ++i) {
    const Vector2d& point = held.points[static_cast<std::size_t>(i % 4)];
    CHECK(held.point(2.0 * i + 1e-9) == point);
    CHECK(held.point(2.0 * i + 1.999) == point);
  }
}

TEST_CASE("path: before the task begins it is at the first way-point") {
  CHECK(kSquare.point(-3.0) == kSquare.points.front());
}

TEST_CASE("target: a path is looked at a lead ahead, and stage by stage only where it previews") {
  Path path = kSquare;
  path.lead = 0.3;
  const Vector2d ball(0.1, 0.2);  // of no matter
  CHECK(path.target(with(ball), 0, 1.0, 0.4) == kSquare.point(1.7));
  path.preview = false;
  CHECK(path.target(with(ball), 0, 1.0, 0.4) == kSquare.point(1.3));
}

TEST_CASE(
    "line: a ball is drawn a step along it and towards it, and no farther than its own place past "
    "the end") {
  CHECK((kLine.next({0.552, 0.0}, 0) - Vector2d(0.55, -0.01)).norm() < 1e-15);
  // the last ball's place is a step past the end, the others' are farther by the spacing each
  CHECK((kLine.next({0.55, -0.105}, 0) - Vector2d(0.55, -0.11)).norm() < 1e-15);
  CHECK((kLine.next({0.55, -0.105}, 1) - Vector2d(0.55, -0.115)).norm() < 1e-15);
  CHECK((kLine.next({0.55, -0.3}, 2) - Vector2d(0.55, -0.29)).norm() < 1e-15);
  CHECK(kLine.way_to_go({0.5, 0.0}, 1) == Approx(0.19));
  const Line mirrored{0.55, 0.01, 0.1, 0.08};
  CHECK((mirrored.next({0.55, 0.105}, 1) - Vector2d(0.55, 0.115)).norm() < 1e-15);
  CHECK(mirrored.way_to_go({0.5, 0.0}, 1) == Approx(0.19));
}

TEST_CASE("target velocity: of a previewed path that moves, and of nothing else") {
  CHECK((kSquare.velocity(0.5, 0.3) - Vector2d(0.05, 0.0)).norm() < 1e-12);
  CHECK((kSquare.velocity(1.9, 0.3) - Vector2d(0.0, 0.05)).norm() < 1e-12);
  Path path = kSquare;
  path.preview = false;
  CHECK(path.velocity(0.5, 0.3).isZero());
  path = kSquare;
  path.between = Between::kHold;
  CHECK(path.velocity(0.5, 0.3).isZero());
  CHECK(kCircle.velocity(0.5, 0.3).isZero());
  CHECK(kLine.velocity(0.5, 0.3).isZero());
}

TEST_CASE("target: state-based tasks do not depend on time") {
  const Vector2d ball(0.52, 0.07);
  for (const double t : {0.0, 3.0, 1e4}) {
    CHECK(kCircle.target(with(ball), 0, t, 0.5) == kCircle.next(ball));
    CHECK((kLine.target(with(ball), 0, t, 0.5) - Vector2d(0.53, 0.06)).norm() < 1e-15);
  }
}

TEST_CASE("line: a ball has arrived when it is past the end in the line's direction") {
  CHECK_FALSE(kLine.past_end(0.0));
  CHECK(kLine.past_end(-0.1));
  CHECK(kLine.past_end(-0.2));
  const Line other_way{0.55, 0.01, 0.1, 0.08};
  CHECK_FALSE(other_way.past_end(0.0));
  CHECK(other_way.past_end(0.11));
}

TEST_CASE(
    "path error: to the line of a state-based task, to the point of the time of one in time") {
  CHECK(kCircle.error(5.0, {0.55, 0.13}) == Approx(0.03));
  CHECK(kCircle.error(5.0, {0.55, 0.0}) == Approx(0.1));
  CHECK(kLine.error(5.0, {0.53, -7.0}) == Approx(0.02));
  // after 3 s the point is (0.6, 0): 30 mm and 40 mm off
  CHECK(kSquare.error(3.0, {0.63, 0.04}) == Approx(0.05));
}

TEST_CASE("path error: held and interpolated paths differ by at most the way between way-points") {
  Path held = kSquare;
  held.between = Between::kHold;
  // a ball that moves with the interpolated path is up to a whole side ahead of the held point
  CHECK(held.error(1.999, kSquare.point(1.999)) == Approx(0.1).margin(1e-3));
  CHECK(held.error(2.0, kSquare.point(2.0)) == Approx(0.0).margin(1e-12));
}

TEST_CASE("request: a parameter is read as a person writes it") {
  const auto same = [](const std::string& text, const std::vector<double>& values,
                       const std::string& word) {
    const Parameter parameter = parse_parameter(text);
    return parameter.name == "key" && parameter.values == values && parameter.word == word;
  };
  CHECK(same("key=0.08", {0.08}, ""));
  CHECK(same("key=0.55,-1e-2,3", {0.55, -0.01, 3.0}, ""));
  CHECK(same("key=true", {1.0}, ""));
  CHECK(same("key=false", {0.0}, ""));
  CHECK(same("key=hold", {}, "hold"));
  CHECK(same("key=0.5,", {}, "0.5,"));
  CHECK(same("key=1 2", {}, "1 2"));
  for (const char* wrong : {"", "key", "key=", "=1"})
    CHECK_THROWS_AS(parse_parameter(wrong), RequestError);
}

TEST_CASE("middle: of a circle its centre, of a path the mean of its points, of a line its x") {
  CHECK(kCircle.middle() == kCircle.center);
  CHECK((kSquare.middle() - Vector2d(0.55, 0.0)).norm() < 1e-12);
  CHECK(kLine.middle().x() == 0.55);
}

TEST_CASE("task: by value it is the same as the struct of its kind, which it gives back") {
  const Task circle = kCircle, path = kSquare, line = kLine;
  CHECK(std::string(circle.kind()) == "circle");
  CHECK(circle.as<Circle>()->lead == kCircle.lead);
  CHECK(circle.as<Path>() == nullptr);
  CHECK(path.error(3.0, {0.63, 0.04}) == kSquare.error(3.0, {0.63, 0.04}));
  CHECK(path.velocity(0.5, 0.3) == kSquare.velocity(0.5, 0.3));
  CHECK(line.target(with({0.552, 0.0}), 0, 0.0, 0.0) == kLine.next({0.552, 0.0}, 0));
  CHECK(line.middle() == kLine.middle());
}

TEST_CASE("task: only a line orders its bodies and has a place where they arrive") {
  const Task circle = kCircle, path = kSquare, line = kLine;
  scene::Scene scene = with({0.56, 0.02});
  scene.body_count = 2;
  scene.body(1).p_WB = {0.55, 0.08, 0.0};
  const std::optional<Along> first = line.along(scene, 0), second = line.along(scene, 1);
  REQUIRE(first);
  CHECK(first->beside == Approx(0.01));
  CHECK(first->place > second->place);  // the line goes to -y
  CHECK(first->way == Approx(kLine.way_to_go({0.56, 0.02}, 1)));
  CHECK(second->way == Approx(kLine.way_to_go({0.55, 0.08}, 0)));
  CHECK(line.arrived({0.5, -0.2}) == std::optional<bool>(true));
  CHECK(line.arrived({0.5, 0.0}) == std::optional<bool>(false));
  for (const Task* other : {&circle, &path}) {
    CHECK_FALSE(other->along(scene, 0));
    CHECK_FALSE(other->arrived({0.5, -0.2}));
  }
}

TEST_CASE("task: the outline is a closed line, but a line's, from where the bodies began") {
  Eigen::AlignedBox2d tracks;
  tracks.extend(Vector2d(0.5, -0.02));
  tracks.extend(Vector2d(0.6, 0.12));
  for (const Task& task : {Task(kCircle), Task(kSquare)}) {
    const auto outline = task.outline(tracks);
    CHECK(outline.front() == outline.back());
    for (const Vector2d& point : outline) {
      if (task.as<Circle>() != nullptr) CHECK(task.error(0.0, point) < 1e-12);
    }
  }
  const auto line = Task(kLine).outline(tracks);
  CHECK(line.front() == Vector2d(0.55, 0.12));
  CHECK(line.back() == Vector2d(0.55, -0.1));
}

TEST_CASE("progress: rounds of a path by its clock, bodies of a line that have arrived") {
  const auto rounds = kSquare.progress();
  rounds->add(20.0, {Vector2d::Zero()});
  CHECK(rounds->amount() == Approx(2.5));
  CHECK(rounds->completed() == 2);
  const auto balls = kLine.progress();
  balls->add(1.0, {{0.55, 0.0}, {0.55, -0.2}});
  CHECK(balls->amount() == 1.0);
  CHECK(balls->completed() == 0);
  balls->add(2.0, {{0.55, -0.11}, {0.55, -0.2}});
  CHECK(balls->completed() == 1);
  CHECK(balls->times() == std::vector<double>{2.0});
}

namespace {
/// Two goals for the first of two bodies: across, then turned by a quarter.
const Pose kPoses{
    {{{0.6, 0.0}, std::nullopt, 0.01, 3.15, 0.5}, {{0.6, 0.1}, M_PI / 2, 0.01, 0.1, 0.5}}};

Placement turned(double x, double y, double yaw) {
  return {Vector2d(x, y), Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()))};
}
}  // namespace

TEST_CASE("pose: a goal is done when the body has stayed within its tolerances for the time") {
  State state;
  const auto at = [&](double time, const Placement& body) {
    kPoses.advance(time, {body}, state);
    return state.goal;
  };
  CHECK(at(0.0, {0.5, 0.0}) == 0);
  CHECK(at(1.0, {0.595, 0.0}) == 0);
  CHECK(at(1.4, {0.595, 0.0}) == 0);
  CHECK(at(1.45, {0.58, 0.0}) == 0);  // it was there, but has left
  CHECK(at(1.5, {0.605, 0.0}) == 0);
  CHECK(at(1.99, {0.605, 0.0}) == 0);
  CHECK(kPoses.goal(state, 0)->at == Vector2d(0.6, 0.0));
  CHECK(at(2.0, {0.605, 0.0}) == 1);  // half a second since it came back
  CHECK(kPoses.goal(state, 0)->at == Vector2d(0.6, 0.1));
  CHECK(*kPoses.goal(state, 0)->yaw == M_PI / 2);
  // the place alone is not enough for the second
  CHECK(at(3.0, turned(0.6, 0.1, 1.4)) == 1);
  CHECK(at(4.0, turned(0.6, 0.1, 1.4)) == 1);
  CHECK(at(5.0, turned(0.6, 0.1, 1.5)) == 1);
  CHECK(at(5.5, turned(0.6, 0.1, 1.5)) == 2);
  CHECK(kPoses.done(state));
  CHECK(kPoses.goal(state, 0)->at == Vector2d(0.6, 0.1));  // where it is kept
  CHECK(at(9.0, {0.0, 0.0}) == 2);                         // for good
}

TEST_CASE("pose: an angle error is the smallest turn, and any tilt counts") {
  const PoseGoal& goal = kPoses.goals[1];
  for (const double off : {0.0, 0.3, -0.3, 2.0, 3.0, -3.0}) {
    for (const double turns : {0.0, 1.0, -1.0}) {
      CAPTURE(off, turns);
      const Placement body = turned(0.6, 0.1, M_PI / 2 + off + 2 * M_PI * turns);
      CHECK(kPoses.angle_error(goal, body) == Approx(std::abs(off)).margin(1e-7));
    }
  }
  const Eigen::Quaterniond upright(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond tilted =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX())) * upright;
  CHECK(kPoses.angle_error(goal, {Vector2d(0.6, 0.1), tilted}) == Approx(0.4));
  CHECK(kPoses.angle_error(kPoses.goals[0], {Vector2d(0.6, 0.1), tilted}) == 0.0);
}

TEST_CASE("pose: by value the task keeps its state beside it, and other bodies stay") {
  const Task task = kPoses;
  State state;
  scene::Scene scene = with({0.6, 0.0});
  scene.body_count = 2;
  scene.body(1).p_WB = {0.5, 0.2, 0.0};
  CHECK(task.target(scene, 0, 0.0, 0.5) == Vector2d(0.6, 0.0));
  task.advance(1.0, scene, state);
  CHECK(state.goal == 0);
  task.advance(1.6, scene, state);
  CHECK(state.goal == 1);
  CHECK(task.target(scene, 0, 0.0, 0.5, state) == Vector2d(0.6, 0.1));
  CHECK(task.target(scene, 0, 0.0, 0.5) == Vector2d(0.6, 0.0));  // a state anew is its beginning
  CHECK(task.target(scene, 1, 0.0, 0.5, state) == Vector2d(0.5, 0.2));
  // what has no goals has no state
  for (const Task& other : {Task(kCircle), Task(kSquare), Task(kLine)}) {
    State untouched;
    other.advance(1.0, scene, untouched);
    CHECK(untouched.goal == 0);
    CHECK_FALSE(other.goal(untouched, 0));
  }
}

TEST_CASE("pose: goals of several bodies are done when all are there at the same time") {
  const PoseGoal first{{0.5, 0.1}, std::nullopt, 0.01, 3.15, 0.5, 0},
      second{{0.6, -0.1}, 0.3, 0.01, 0.1, 1.0, 1}, then{{0.5, 0.2}, std::nullopt, 0.01, 3.15, 0, 0};
  const Pose both{{first, second, then}};
  CHECK(both.bodies() == 2);
  State state;
  const auto at = [&](double time, const Placement& a, const Placement& b) {
    both.advance(time, {a, b}, state);
    return state.goal;
  };
  const Placement home(0.5, 0.1), away(0.5, 0.0), later(0.5, 0.2);
  CHECK(at(0.0, home, turned(0.6, -0.1, 0.0)) == 0);
  CHECK(at(9.0, home, turned(0.6, -0.1, 0.0)) == 0);  // the second is not
  CHECK(both.goal(state, 0)->at == Vector2d(0.5, 0.1));
  CHECK(*both.goal(state, 1)->yaw == 0.3);
  CHECK_FALSE(both.goal(state, 2));
  CHECK(at(10.0, home, turned(0.6, -0.1, 0.3)) == 0);
  CHECK(at(10.9, away, turned(0.6, -0.1, 0.3)) == 0);  // the first has left
  CHECK(at(11.0, home, turned(0.6, -0.1, 0.3)) == 0);
  CHECK(at(11.9, home, turned(0.6, -0.1, 0.3)) == 0);  // the longer one of their times counts
  CHECK(at(12.0, home, turned(0.6, -0.1, 0.3)) == 2);
  // the next one of a body leaves the other's as it is
  CHECK(both.goal(state, 0)->at == Vector2d(0.5, 0.2));
  CHECK(both.goal(state, 1)->at == Vector2d(0.6, -0.1));
  CHECK(at(13.0, later, turned(0.6, 0.0, 0.3)) == 2);
  CHECK(at(14.0, later, turned(0.6, -0.1, 0.3)) == 2);
  CHECK(at(15.0, later, turned(0.6, -0.1, 0.3)) == 3);
  CHECK(both.done(state));
  CHECK(both.error(0.0, {0.5, 0.3}, 0) == Approx(0.1));
  CHECK(both.error(0.0, {0.6, 0.0}, 1) == Approx(0.1));
  CHECK(both.error(0.0, {0.6, 0.0}, 2) == 0.0);
  // one that a scene has not is not waited for in vain: nothing is done
  State alone;
  both.advance(0.0, {home}, alone);
  CHECK(std::isnan(alone.reached_since));
}

TEST_CASE("progress: of goals of several bodies it tells the worst, and when all were there") {
  const auto progress = Task(Pose{{{{0.5, 0.1}, std::nullopt, 0.01, 3.15, 1.0, 0},
                                   {{0.6, -0.1}, 0.0, 0.01, 0.1, 1.0, 1}}})
                            .progress();
  const auto result = [&](const std::string& name) {
    for (const auto& [key, value] : progress->results()) {
      if (key == name) return value;
    }
    return kNone;
  };
  progress->add(0.0, {turned(0.5, 0.1, 0.0), turned(0.6, 0.0, 0.2)});
  CHECK(result("end_position_error_m") == Approx(0.1));
  CHECK(result("end_angle_error_rad") == Approx(0.2));
  CHECK(std::isnan(progress->judged_from()));
  progress->add(2.0, {turned(0.5, 0.106, 0.0), turned(0.6, -0.1, 0.05)});
  CHECK(progress->judged_from() == 2.0);
  CHECK(progress->completed() == 0);
  progress->add(3.0, {turned(0.5, 0.106, 0.0), turned(0.6, -0.1, 0.05)});
  CHECK(progress->completed() == 1);
  CHECK(progress->times() == std::vector<double>{3.0});
  CHECK(result("goals_reached") == 2.0);
  CHECK(result("end_position_error_m") == Approx(0.006));
  CHECK(result("end_angle_error_rad") == Approx(0.05));
}

TEST_CASE("progress: of poses it counts goals that are done, and tells the last one's errors") {
  const auto progress = Task(kPoses).progress();
  const auto result = [&](const std::string& name) {
    for (const auto& [key, value] : progress->results()) {
      if (key == name) return value;
    }
    return kNone;
  };
  const Placement other(0.0, 0.0);
  progress->add(0.0, {turned(0.6, 0.0, 0.0), other});
  progress->add(0.6, {turned(0.6, 0.0, 0.0), other});
  CHECK(progress->amount() == 1.0);
  CHECK(progress->completed() == 0);
  CHECK(std::isnan(progress->judged_from()));
  CHECK(std::isnan(result("goal_time_s")));
  CHECK(result("end_position_error_m") == Approx(0.1));
  CHECK(result("end_angle_error_rad") == Approx(M_PI / 2));
  progress->add(2.0, {turned(0.606, 0.1, 1.5), other});
  CHECK(progress->judged_from() == 2.0);
  progress->add(2.5, {turned(0.606, 0.1, 1.5), other});
  CHECK(progress->completed() == 1);
  CHECK(progress->times() == std::vector<double>{2.5});
  CHECK(result("goals_reached") == 2.0);
  CHECK(result("goal_time_s") == 2.5);
  CHECK(result("end_position_error_m") == Approx(0.006));
  CHECK(result("end_angle_error_rad") == Approx(M_PI / 2 - 1.5));
  // the figures are those that a scenario may name
  for (const auto& [key, value] : progress->results()) {
    const auto names = Task(kPoses).criteria();
    CHECK(std::find(names.begin(), names.end(), key) != names.end());
  }
}
