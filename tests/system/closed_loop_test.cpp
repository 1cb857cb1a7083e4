// Plant, emulated sensing, planner and impedance law in one process: what the whole is for.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "controller/task/circle.hpp"
#include "controller/task/line.hpp"
#include "controller/task/path.hpp"
#include "tests/support/run.hpp"

using namespace c3rt;

namespace {

struct Course {
  double turns = 0.0;          // of the ball about the circle's centre
  double largest_error = 0.0;  // distance to the circle after the first quarter turn [m]
  double in_band = 0.0;        // part of that time in which it is less than kBand
};

constexpr double kBand = 0.02;  // [m]

Course run(const std::string& scenario_name, std::uint64_t seed, double seconds,
           const std::vector<std::string>& overrides = {}) {
  const config::Scenario scenario = config::load_scenario(
      std::string(C3RT_SOURCE_DIRECTORY "/config/scenarios/") + scenario_name + ".yaml", overrides);
  const auto& circle = *scenario.task.motion.as<c3rt::task::Circle>();
  test::Run loop(scenario, seed);
  Course course;
  double previous = 0.0;
  int judged = 0, inside = 0;
  while (loop.time() < seconds) {
    loop.step_1ms();
    const Eigen::Vector2d ball = loop.plant().state().objects[0].p_WB.head<2>() - circle.center;
    const double alpha = std::atan2(ball.x(), ball.y());
    course.turns += std::remainder(alpha - previous, 2.0 * M_PI) / (2.0 * M_PI);
    previous = alpha;
    if (course.turns <= 0.25) continue;
    const double error = std::abs(ball.norm() - circle.radius);
    course.largest_error = std::max(course.largest_error, error);
    ++judged;
    if (error < kBand) ++inside;
  }
  course.in_band = static_cast<double>(inside) / std::max(judged, 1);
  return course;
}

}  // namespace

TEST_CASE(
    "closed loop: the real arm rolls the ball round the slow circle without leaving the 2 cm "
    "band") {
  const Course course = run("circle_slow", 1, 25.0);
  CHECK(course.turns > 1.0);
  CHECK(course.largest_error < 0.02);
}

TEST_CASE("closed loop: with 1 mm of noise the ball still goes round, whatever the seed") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Course course = run("circle_fast", seed, 25.0);
    CAPTURE(seed);
    CHECK(course.turns > 1.0);
    CHECK(course.largest_error < 0.06);
  }
}

TEST_CASE("closed loop: other balls go round with the same settings") {
  struct Ball {
    double radius, mass;
  };
  // at the density of the shipped one, then lighter and heavier
  for (const Ball ball : {Ball{0.02, 0.0338}, Ball{0.025, 0.066}, Ball{0.04, 0.27},
                          Ball{0.05, 0.528}, Ball{0.0315, 0.05}, Ball{0.0315, 0.4}}) {
    CAPTURE(ball.radius, ball.mass);
    const std::string radius = std::to_string(ball.radius), mass = std::to_string(ball.mass);
    const std::vector<std::string> of_ball{
        "planner.model.ball_radius_m=" + radius, "planner.model.ball_mass_kg=" + mass,
        "plant.objects.0.radius_m=" + radius, "plant.objects.0.mass_kg=" + mass};
    const Course fast = run("circle_fast", 4, 20.0, of_ball);
    CHECK(fast.turns > 1.0);
    CHECK(fast.largest_error < 0.03);
    const Course slow = run("circle_slow", 4, 26.0, of_ball);
    CHECK(slow.turns > 1.0);
    CHECK(slow.largest_error < 0.02);
  }
}

TEST_CASE("closed loop: C3+ and the convex projection roll it round, too, without and with noise") {
  for (const char* projection : {"plus", "convex"}) {
    CAPTURE(projection);
    const Course slow = run(std::string("circle_slow_") + projection, 1, 20.0);
    CHECK(slow.turns > 1.0);
    CHECK(slow.largest_error < 0.02);
    const Course fast = run(std::string("circle_fast_") + projection, 1, 20.0);
    CHECK(fast.turns > 1.0);
    CHECK(fast.largest_error < 0.03);
  }
}

TEST_CASE(
    "closed loop: sampled places alone roll it round as the scenario asks, without a heuristic in "
    "time") {
  // three circles of 30 s at most, 95 % of the time in the band; its ball leaves the band at times
  const Course course = run("circle_sampling", 1, 90.0, {"vision.source=emulated"});
  CHECK(course.turns > 3.0);
  CHECK(course.in_band > 0.95);
  CHECK(course.largest_error < 0.05);
}

TEST_CASE("closed loop: a table tilted by one degree, which nobody told it, keeps the ball") {
  // without the press on the ball these were lost after 3 to 10 s
  for (const std::uint64_t seed : {1, 6, 20}) {
    const Course course =
        run("circle_tilted", seed, 30.0,
            {"plant.table_tilt_rad.0=0.01745", "vision.emulated.noise_m=0.00006"});
    CAPTURE(seed);
    CHECK(course.turns > 1.0);
    CHECK(course.largest_error < 0.06);
  }
}

TEST_CASE(
    "closed loop: the ball follows a rectangle in time, never 2 cm from the point of the time") {
  const config::Scenario scenario =
      config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/path_rectangle.yaml");
  const auto& path = *scenario.task.motion.as<c3rt::task::Path>();
  test::Run loop(scenario, 1);
  double start = -1.0, largest = 0.0, squares = 0.0;
  int rows = 0;
  Eigen::AlignedBox2d visited;
  while (start < 0.0 || loop.time() - start < path.round_duration()) {
    loop.step_1ms();
    REQUIRE(loop.time() < 100.0);
    const bool rolling = loop.mode() == planner::Mode::kTask;
    if (start < 0.0 && rolling) start = loop.time();
    if (start < 0.0 || loop.time() - start < 1.0) continue;
    const Eigen::Vector2d ball = loop.plant().state().objects[0].p_WB.head<2>();
    const double error = (ball - path.point(loop.time() - start)).norm();
    largest = std::max(largest, error);
    squares += error * error;
    ++rows;
    visited.extend(ball);
  }
  CHECK(largest < 0.02);
  CHECK(std::sqrt(squares / rows) < 0.01);
  // all round: the sides are 0.1 m and 0.2 m
  CHECK(visited.sizes().x() > 0.09);
  CHECK(visited.sizes().y() > 0.19);
}

namespace {

/// Brings the balls of a line's scenario along it. @return the largest distance to the line of a
/// ball that is not past the end [m]; infinity if they are not all past it within `seconds`
double bring_along_the_line(const std::string& scenario_name, std::uint64_t seed, double seconds) {
  const config::Scenario scenario = config::load_scenario(
      std::string(C3RT_SOURCE_DIRECTORY "/config/scenarios/") + scenario_name + ".yaml");
  const auto& line = *scenario.task.motion.as<c3rt::task::Line>();
  const std::size_t balls = scenario.plant.world.objects.size();
  test::Run loop(scenario, seed);
  std::vector<double> beside(balls, 0.0);  // until each has arrived
  while (loop.time() < seconds) {
    loop.step_1ms();
    bool arrived = true;
    for (std::size_t i = 0; i < balls; ++i) {
      const Eigen::Vector3d ball = loop.plant().state().objects[i].p_WB;
      if (line.past_end(ball.y())) continue;
      arrived = false;
      beside[i] = std::abs(ball.x() - line.x);
    }
    if (arrived) return *std::max_element(beside.begin(), beside.end());
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

TEST_CASE("closed loop: two balls are brought along the line, past its end and near it") {
  for (const std::uint64_t seed : {1, 2}) {
    CAPTURE(seed);
    CHECK(bring_along_the_line("two_balls", seed, 40.0) < 0.03);
  }
}

TEST_CASE("closed loop: C3+ brings three balls along the line, and four") {
  CHECK(bring_along_the_line("three_balls_plus", 1, 60.0) < 0.03);
  // with less room between two balls, seen a second ahead, one jammed with the next and was lost
  CHECK(bring_along_the_line("four_balls", 8, 80.0) < 0.03);
}

TEST_CASE("closed loop: the convex projection brings three balls along the line") {
  CHECK(bring_along_the_line("three_balls_convex", 1, 60.0) < 0.03);
}

namespace {

std::string scenario_file(const std::string& name) {
  return C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml";
}

/// The emulated sensor in the place of cameras, with their noise.
std::vector<std::string> emulated(const std::string& name) {
  if (name != "circle_vision") return {};
  return {"vision.source=emulated", "vision.emulated.noise_m=0.00006"};
}

double ball_speed(test::Run& loop, int ball) {
  return loop.plant().state().objects[static_cast<std::size_t>(ball)].v_WB.head<2>().norm();
}

}  // namespace

TEST_CASE(
    "closed loop: hold brings a rolling ball to rest and leaves it, and then it goes on round") {
  struct Start {
    const char* scenario;
    std::uint64_t seed;
    double at;  // in Phase I and in Phase II [s]
  };
  for (const Start& start :
       {Start{"circle_slow", 1, 7.9}, Start{"circle_slow", 2, 8.3}, Start{"circle_fast", 3, 7.9},
        Start{"circle_fast", 2, 8.7}, Start{"circle_vision", 4, 8.3}}) {
    CAPTURE(start.scenario, start.seed, start.at);
    const config::Scenario scenario =
        config::load_scenario(scenario_file(start.scenario), emulated(start.scenario));
    const auto& circle = *scenario.task.motion.as<c3rt::task::Circle>();
    test::Run loop(scenario, start.seed);
    loop.until(start.at);
    REQUIRE(ball_speed(loop, 0) > 0.02);
    loop.hold();
    loop.step_1ms();
    loop.until(start.at + 0.1);
    CHECK_THAT(describe(loop.planner().activity(), scenario.planner, loop.time()),
               Catch::Contains("bringing ball 0 to rest"));
    loop.until(start.at + 5.0);
    CHECK(loop.mode() == planner::Mode::kHold);
    CHECK(loop.planner().activity().cause == planner::Cause::kAsked);
    // nothing resists it: in a minute it creeps less than the circle's margin to the reach
    CHECK(ball_speed(loop, 0) < 0.004);
    CHECK(loop.plant().state().p_WE.z() > 0.1);

    loop.go_on();
    double turns = 0.0, previous = 0.0, error = 0.0;
    const double resumed = loop.time();
    while (loop.time() < resumed + 16.0) {
      loop.step_1ms();
      const Eigen::Vector2d ball = loop.plant().state().objects[0].p_WB.head<2>() - circle.center;
      const double alpha = std::atan2(ball.x(), ball.y());
      if (loop.time() > resumed + 0.002)
        turns += std::remainder(alpha - previous, 2.0 * M_PI) / (2.0 * M_PI);
      previous = alpha;
      if (loop.time() > resumed + 8.0)
        error = std::max(error, std::abs(ball.norm() - circle.radius));
    }
    CHECK(turns > 0.3);
    CHECK(error < 0.02);
    CHECK(loop.planner().counters().body_lost == 0);
  }
}

TEST_CASE("closed loop: a hold that ends while the ball is being stopped goes on at once") {
  for (const double hold : {0.3, 2.0}) {
    CAPTURE(hold);
    test::Run loop(config::load_scenario(scenario_file("circle_slow")), 1);
    loop.until(8.3);
    loop.hold();
    loop.until(8.3 + hold);
    CHECK(loop.mode() == planner::Mode::kRest);
    loop.go_on();
    loop.until(16.0);
    CHECK(ball_speed(loop, 0) > 0.01);
    const Eigen::Vector2d ball = loop.plant().state().objects[0].p_WB.head<2>();
    CHECK(std::abs((ball - Eigen::Vector2d(0.55, 0.0)).norm() - 0.1) < 0.02);
  }
}

TEST_CASE("closed loop: hold stops the worked ball of three, and the line goes on") {
  const config::Scenario scenario = config::load_scenario(scenario_file("three_balls_plus"));
  const auto& line = *scenario.task.motion.as<c3rt::task::Line>();
  test::Run loop(scenario, 1);
  loop.until(8.3);
  loop.hold();
  loop.until(12.5);
  CHECK(loop.mode() == planner::Mode::kHold);
  for (int ball = 0; ball < 3; ++ball) CHECK(ball_speed(loop, ball) < 0.004);
  loop.go_on();
  int arrived = 0;
  while (arrived < 3 && loop.time() < 80.0) {
    loop.step_1ms();
    arrived = 0;
    for (int i = 0; i < 3; ++i)
      arrived += line.past_end(loop.plant().state().objects[static_cast<std::size_t>(i)].p_WB.y());
  }
  CHECK(arrived == 3);
}

TEST_CASE(
    "closed loop: on a table that resists, a ball that nobody sees for a second is taken up") {
  const config::Scenario scenario = config::load_scenario(scenario_file("circle_service"));
  for (const double at : {7.9, 8.3, 9.1}) {
    for (const bool silent : {false, true}) {
      CAPTURE(at, silent);
      test::Run loop(scenario, 1);
      loop.until(at);
      // vision is stopped, or no camera sees the ball
      if (silent) {
        loop.running.vision = false;
      } else {
        loop.set_in_view(false);
      }
      loop.until(at + 0.7);
      CHECK(loop.planner().activity().cause ==
            (silent ? planner::Cause::kVisionSilent : planner::Cause::kBodyNotInView));
      loop.until(at + 1.0);
      loop.running.vision = true;
      loop.set_in_view(true);
      loop.until(at + 7.0);
      const auto& p_WB = loop.plant().state().objects[0].p_WB;
      const Eigen::Vector2d before = p_WB.head<2>();
      loop.until(at + 10.0);
      const Eigen::Vector2d ball = p_WB.head<2>();
      CHECK((ball - before).norm() > 0.03);  // it rolls on
      CHECK(std::abs((ball - Eigen::Vector2d(0.55, 0.0)).norm() - 0.1) < 0.02);
    }
  }
}

TEST_CASE("closed loop: a pose as a target brings the ball there, and keeps it within 1 cm") {
  for (const std::uint64_t seed : {1, 2}) {
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0.55, 0.0), Eigen::Vector2d(0.45, 0.15)}) {
      CAPTURE(seed, point.x(), point.y());
      const config::Scenario scenario = config::load_scenario(scenario_file("circle_slow"));
      test::Run loop(scenario, seed);
      loop.until(9.0);
      loop.bring_to(point);
      while (loop.planner().activity().cause != planner::Cause::kAtTarget && loop.time() < 40.0)
        loop.step_1ms();
      CHECK(loop.planner().activity().cause == planner::Cause::kAtTarget);
      const double until = loop.time() + 15.0;
      double farthest = 0.0;
      while (loop.time() < until) {
        loop.step_1ms();
        const Eigen::Vector2d ball = loop.plant().state().objects[0].p_WB.head<2>();
        farthest = std::max(farthest, (ball - point).norm());
      }
      CHECK(farthest < 0.01);
    }
  }
}
