#include "config/scenario.hpp"

#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>

using c3rt::config::ConfigError;
using c3rt::config::load_scenario;
using Catch::Matchers::Contains;

namespace {

const std::string kFolder = C3RT_SOURCE_DIRECTORY "/config/scenarios/";

std::string error_of(const std::vector<std::string>& overrides) {
  try {
    (void)load_scenario(kFolder + "circle_slow.yaml", overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("scenario: every shipped file can be loaded, and is named as its file") {
  for (const char* name : {"circle_slow", "circle_fast", "circle_vision"}) {
    const c3rt::config::Scenario scenario = load_scenario(kFolder + name + ".yaml");
    CHECK(scenario.name == name);
    CHECK(scenario.task.circle.radius == 0.1);
    CHECK(scenario.planner.circle.lead == scenario.task.circle.lead);
    CHECK_FALSE(scenario.criteria.empty());
    CHECK_FALSE(scenario.plant.world.balls.empty());
  }
}

TEST_CASE("scenario: a numerical example is refused as one of the four processes") {
  for (const char* name : {"cart_pole", "cart_pole_hardware", "finger_gaiting", "pivoting"}) {
    CHECK_THROWS_WITH(load_scenario(kFolder + name + ".yaml"),
                      Contains("example: expected no such key") && Contains("c3rt run"));
  }
}

TEST_CASE("scenario: a key of any room that is out of range is refused by line, key and range") {
  CHECK_THAT(error_of({"planner.horizon=99"}),
             Contains("planner.horizon: expected an integer in [1, 10], got \"99\""));
  CHECK_THAT(error_of({"impedance.rate_hz=1"}),
             Contains("impedance.rate_hz: expected a number in"));
  CHECK_THAT(error_of({"plant.step_s=1"}), Contains("plant.step_s: expected a number in"));
  CHECK_THAT(error_of({"vision.source=radar"}),
             Contains("vision.source: expected one of cameras, emulated"));
  CHECK_THAT(error_of({"timing.solve_time_s=-1"}), Contains("timing.solve_time_s"));
  CHECK_THAT(error_of({"task.loops=0.5"}), Contains("task.loops: expected an integer"));
  CHECK_THAT(error_of({"criteria.0.name=beauty"}), Contains("criteria.0.name: expected one of"));
  CHECK_THAT(error_of({"planner.c3.qp=gurobi"}),
             Contains("planner.c3.qp: expected one of direct, "));
}

TEST_CASE("scenario: a key that nobody knows is refused, wherever it stands") {
  std::ifstream file(kFolder + "circle_slow.yaml");
  std::ostringstream text;
  text << file.rdbuf();
  const std::string whole = text.str();
  for (const std::string section : {"task:", "timing:", "planner:", "  c3:", "  approach:",
                                    "plant:", "impedance:", "  gains:", "vision:", "  filter:"}) {
    const std::size_t at = whole.find("\n" + section);
    REQUIRE(at != std::string::npos);
    const std::size_t end = whole.find('\n', at + 1);
    const std::string indent(section.find_first_not_of(' ') + 2, ' ');
    const std::string path = std::string(C3RT_BINARY_DIRECTORY) + "/unknown_key.yaml";
    std::ofstream(path) << whole.substr(0, end) << "\n"
                        << indent << "typo_s: 1" << whole.substr(end);
    CAPTURE(section);
    CHECK_THROWS_WITH(load_scenario(path), Contains("typo_s: unknown key"));
  }
}
