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
task::Limits limits(int balls = 1) {
  Parameters parameters{};
  parameters.model.bodies = balls;
  parameters.approach.reach_min = {0.35, -0.3};
  parameters.approach.reach_max = {0.75, 0.3};
  return target_limits(parameters);
}

Target circle_target(double x, double y, double radius, double lead_deg) {
  return load_target({"circle",
                      {{"center_m", {x, y}, ""},
                       {"radius_m", {radius}, ""},
                       {"lead_rad", {lead_deg * kDegree}, ""}}});
}
std::string circle(double x, double y, double radius, double lead_deg) {
  return refusal(task::Task(task::Circle{{x, y}, radius, lead_deg * kDegree}), limits());
}

Target pose(double x, double y) {
  return load_target(
      {"pose",
       {{"goals_m", {x, y}, ""}, {"position_tolerance_m", {0.01}, ""}, {"hold_s", {1.0}, ""}}});
}
/// What is said of a request that no planner knows.
std::string said(const task::Request& request) {
  try {
    load_target(request);
    return "taken";
  } catch (const task::RequestError& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("target: the scenario's own, hold, and what lies within reach are taken") {
  CHECK(refusal(ScenarioTarget{}, limits()).empty());
  CHECK(refusal(HoldTarget{}, limits(3)).empty());
  CHECK(circle(0.55, 0.0, 0.1, 20.0).empty());
  CHECK(circle(0.55, 0.0, 0.1, -20.0).empty());
  CHECK(circle(0.5, 0.1, 0.06, 15.0).empty());
  CHECK(refusal(circle_target(0.55, 0.0, 0.1, 20.0), limits()).empty());
  CHECK(refusal(pose(0.5, 0.0), limits()).empty());
  CHECK(refusal(pose(0.6, -0.25), limits()).empty());
}

TEST_CASE("target: a circle is wholly within reach, with a margin for the ball's own errors") {
  for (const auto& [x, y] : {std::pair{5.0, 5.0}, {0.40, 0.0}, {0.70, 0.0}, {0.55, 0.25}}) {
    CAPTURE(x, y);
    CHECK_THAT(circle(x, y, 0.1, 20.0),
               Contains("expected a centre with x in [0.47, 0.63] and y in [-0.18, 0.18] m for a "
                        "circle of radius 0.1 m, got ("));
  }
  CHECK(circle(0.47, -0.18, 0.1, 20.0).empty());
  CHECK_FALSE(circle(0.469, -0.18, 0.1, 20.0).empty());
}

TEST_CASE("target: radius and lead are those that were shown to hold the ball") {
  for (const double radius : {0.5, 5.0, 0.011, 0.0, -0.1}) {
    CAPTURE(radius);
    CHECK_THAT(circle(0.55, 0.0, radius, 20.0),
               Contains("expected a radius of 0.06 to 0.15 m, got"));
  }
  for (const double lead : {-180.0, 180.0, 400.0, 0.0, 3.0, -60.0, 40.0}) {
    CAPTURE(lead);
    CHECK_THAT(circle(0.55, 0.0, 0.1, lead),
               Contains("expected a lead of 10 to 30 deg, or -10 to -30 deg, got"));
  }
}

TEST_CASE("target: numbers that are not finite are refused, whichever it is") {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    CHECK_THROWS_AS(circle_target(bad, 0.0, 0.1, 20.0), task::RequestError);
    CHECK_THROWS_AS(circle_target(0.55, bad, 0.1, 20.0), task::RequestError);
    CHECK_THROWS_AS(circle_target(0.55, 0.0, bad, 20.0), task::RequestError);
    CHECK_THROWS_AS(circle_target(0.55, 0.0, 0.1, bad), task::RequestError);
    CHECK_THROWS_AS(pose(bad, 0.0), task::RequestError);
    CHECK_THROWS_AS(pose(0.5, bad), task::RequestError);
    // a task that no loader has seen
    CHECK_THAT(circle(bad, 0.0, 0.1, 20.0), Contains("expected finite numbers"));
    CHECK_THAT(circle(0.55, 0.0, bad, 20.0), Contains("expected finite numbers"));
  }
}

TEST_CASE("target: a goal, a way-point and a line are within reach") {
  CHECK_THAT(refusal(pose(0.9, 0.0), limits()),
             Contains("expected a goal with x in [0.37, 0.73] and y in [-0.28, 0.28] m, got (0.9, "
                      "0)"));
  const auto path = [](double x, double interval) {
    return load_target({"path",
                        {{"points_m", {0.5, 0.0, x, 0.1}, ""},
                         {"interval_s", {interval}, ""},
                         {"between", {}, "interpolate"},
                         {"lead_s", {0.0}, ""},
                         {"preview", {1.0}, ""}}});
  };
  CHECK(refusal(path(0.6, 2.0), limits()).empty());
  CHECK_THAT(refusal(path(0.74, 2.0), limits()),
             Contains("expected points with x in [0.37, 0.73]"));
  CHECK_THAT(refusal(path(0.6, 0.1), limits()), Contains("expected at most 0.3 m/s"));
  const auto line = [](double y_end) {
    return load_target({"line",
                        {{"x_m", {0.55}, ""},
                         {"step_m", {-0.02}, ""},
                         {"y_end_m", {y_end}, ""},
                         {"spacing_m", {0.08}, ""}}});
  };
  CHECK(refusal(line(-0.1), limits()).empty());
  CHECK(refusal(line(-0.1), limits(3)).empty());
  // the farthest of three has its place 0.16 m past the end
  CHECK(refusal(line(-0.2), limits()).empty());
  CHECK_THAT(refusal(line(-0.2), limits(3)), Contains("expected a line and places past its end"));
}

TEST_CASE("target: a pose of one of several bodies, or of each, where the strategy can do that") {
  const Target several = load_target({"pose",
                                      {{"goals_m", {0.5, 0.0, 0.6, 0.1}, ""},
                                       {"object", {2, 0}, ""},
                                       {"position_tolerance_m", {0.01}, ""},
                                       {"hold_s", {1.0}, ""}}});
  Parameters parameters{};
  parameters.model.bodies = 3;
  parameters.approach.reach_min = {0.35, -0.3};
  parameters.approach.reach_max = {0.75, 0.3};
  CHECK_THAT(refusal(several, target_limits(parameters)), Contains("3 bodies"));
  parameters.strategy = "sampling";
  CHECK(refusal(several, target_limits(parameters)).empty());
  CHECK(refusal(pose(0.5, 0.0), target_limits(parameters)).empty());
  parameters.model.bodies = 2;
  CHECK(refusal(several, target_limits(parameters)) == "expected objects of 0 to 1, got 2");
}

TEST_CASE("target: circles, paths and poses are for one ball") {
  for (const Target& target : {circle_target(0.55, 0.0, 0.1, 20.0), pose(0.55, 0.0)})
    CHECK_THAT(refusal(target, limits(3)), Contains("3 bodies"));
}

TEST_CASE("target: what no planner knows is refused with what was expected, and what came") {
  const task::Request circle{
      "circle", {{"center_m", {0.55, 0.0}, ""}, {"radius_m", {0.1}, ""}, {"lead_rad", {0.35}, ""}}};
  CHECK(said(circle) == "taken");
  CHECK(said({"spiral", {}}) ==
        "kind: expected one of scenario, hold, circle, path, line, pose, got \"spiral\"");
  CHECK(said({"hold", {}}) == "taken");
  CHECK(said({"hold", {{"radius_m", {0.1}, ""}}}) ==
        "hold: expected no parameters, got \"radius_m\"");
  task::Request request = circle;
  request.parameters.erase(request.parameters.begin() + 1);
  CHECK(said(request) == "circle: radius_m: expected a number from 0.01 to 0.5, got nothing");
  request = circle;
  request.parameters[1].name = "radius";
  CHECK(said(request) == "circle: radius_m: expected a number from 0.01 to 0.5, got nothing");
  request = circle;
  request.parameters.push_back({"radios_m", {0.1}, ""});
  CHECK(said(request) ==
        "circle: expected no other parameters than center_m, radius_m, lead_rad, got \"radios_m\"");
  request = circle;
  request.parameters.push_back(circle.parameters[0]);
  CHECK(said(request) == "circle: center_m: expected once, got it twice");
  request = circle;
  request.parameters[0].values = {0.55};
  CHECK(said(request) == "circle: center_m: expected 2 numbers from -1 to 1, got 1 numbers");
  request = circle;
  request.parameters[1].values = {7.0};
  CHECK(said(request) == "circle: radius_m: expected a number from 0.01 to 0.5, got 7");
  request.parameters[1] = {"radius_m", {}, "large"};
  CHECK(said(request) == "circle: radius_m: expected a number from 0.01 to 0.5, got \"large\"");
  const auto path = [](const std::vector<double>& points, const std::string& between,
                       double preview) {
    return task::Request{"path",
                         {{"points_m", points, ""},
                          {"interval_s", {2.0}, ""},
                          {"between", {}, between},
                          {"lead_s", {0.0}, ""},
                          {"preview", {preview}, ""}}};
  };
  CHECK(said(path({0.5, 0.0, 0.6, 0.1}, "hold", 0.0)) == "taken");
  CHECK(said(path({0.5, 0.0, 0.6}, "hold", 0.0)) ==
        "path: points_m: expected 2 to 1000 times 2 numbers from -1 to 1, got 3 numbers");
  CHECK(said(path({0.5, 0.0, 0.6, 0.1}, "jump", 0.0)) ==
        "path: between: expected one of hold, interpolate, got \"jump\"");
  CHECK(said(path({0.5, 0.0, 0.6, 0.1}, "hold", 0.5)) == "path: preview: expected 0 or 1, got 0.5");
}

TEST_CASE("target: a run's seed draws the goals that its planner works at") {
  const Target drawn = load_target({"pose",
                                    {{"random_goals", {3}, ""},
                                     {"random_x_m", {0.45, 0.6}, ""},
                                     {"random_y_m", {-0.1, 0.1}, ""},
                                     {"position_tolerance_m", {0.01}, ""},
                                     {"hold_s", {1.0}, ""}}});
  Parameters parameters{};
  parameters.task = std::get<task::Task>(drawn);
  const auto first = [&](std::uint64_t seed) {
    return seeded(parameters, seed).task.goal(task::State{}, 0)->at;
  };
  CHECK(first(7) == first(7));
  CHECK(first(7) != first(8));
  CHECK(first(7) == parameters.task.seeded(7).goal(task::State{}, 0)->at);
}
