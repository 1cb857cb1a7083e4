#include "cli/example/trials.hpp"

#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cli/example/pictures.hpp"
#include "cli/example/plants.hpp"
#include "config/section.hpp"
#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli;
using nlohmann::ordered_json;
using Names = std::vector<std::string>;

std::string file(const std::string& name) {
  return C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml";
}

ExampleScenario scenario(const std::string& name, const Names& overrides = {}) {
  return load_example(file(name), overrides);
}

Names keys(const ordered_json& object) {
  Names names;
  for (const auto& item : object.items()) names.push_back(item.key());
  return names;
}

bool never() { return false; }

}  // namespace

TEST_CASE("every shipped example can be loaded, is named as its file and has a criterion") {
  for (const char* name : {"cart_pole", "cart_pole_hardware", "finger_gaiting", "pivoting"}) {
    CAPTURE(name);
    REQUIRE(is_example(file(name)));
    const ExampleScenario loaded = scenario(name);
    CHECK(loaded.name == name);
    CHECK_FALSE(loaded.criteria.empty());
  }
  CHECK_FALSE(is_example(file("circle_slow")));
}

TEST_CASE("an example refuses unknown keys and criteria") {
  CHECK_THROWS_WITH(scenario("cart_pole", {"criteria.0.name=beauty"}),
                    Catch::Contains("criteria.0.name: expected one of success_rate"));
  CHECK_THROWS_WITH(scenario("cart_pole", {"control.horizon=0"}),
                    Catch::Contains("control.horizon"));
  CHECK_THROWS_AS(scenario("cart_pole", {"no.such.key=1"}), config::ConfigError);
  const Folder folder;
  const std::string path = (folder.path() / "x.yaml").string();
  std::ofstream(path) << std::ifstream(file("cart_pole")).rdbuf() << "\ntypo: 1\n";
  CHECK_THROWS_WITH(load_example(path), Catch::Contains("typo: unknown key"));
}

TEST_CASE("the report of an example has exactly the keys that other programs read") {
  const ExampleScenario cart_pole = scenario("cart_pole", {"control.duration_s=0.1"});
  const ordered_json json = to_json(report_on(cart_pole, 4, run_trials(cart_pole, 4, never)));
  REQUIRE(keys(json) == Names{"scenario", "seed", "result", "criteria", "trials_wanted",
                              "success_rate", "mean_cost_to_go", "accumulated_cost", "solves",
                              "solve_time_s", "trials"});
  REQUIRE(keys(json["trials"][0]) == Names{"succeeded", "accumulated_cost", "mean_cost_to_go",
                                           "plans_not_rolled_out", "controller_failures",
                                           "plant_failed", "overshoot", "final_state"});
  CHECK(keys(json["criteria"][0]) == Names{"name", "value", "limit", "met"});
  CHECK(keys(json["solve_time_s"]) == Names{"p50", "p95", "p99", "max"});
  CHECK(json["seed"] == 4);
  CHECK(json["solves"] == 10);
  CHECK(json["result"] == "criteria not met");
  CHECK(json["trials"][0]["final_state"].size() == 4);
}

TEST_CASE("the success rate counts trials, and a criterion is met at its limit") {
  ExampleScenario cart_pole = scenario("cart_pole");
  cart_pole.criteria = {{"success_rate", 0.75, {}}, {"accumulated_cost", {}, 2.4}};
  TrialsResult result;
  const Trial success{true, 1.0, 3.0, 0, 0, false, 0.0, Eigen::Vector4d::Zero()};
  Trial failure = success;
  failure.succeeded = false;
  failure.accumulated_cost = 7.0;
  result.trials = {success, failure, success, success};
  const ExampleReport report = report_on(cart_pole, 1, result);
  CHECK(report.success_rate == 0.75);
  CHECK(report.accumulated_cost == 2.5);
  REQUIRE(report.criteria.size() == 2);
  CHECK(report.criteria[0].met);
  CHECK_FALSE(report.criteria[1].met);
  CHECK(report.result == "criteria not met");
}

TEST_CASE("an interrupted run reports the trials that were finished, and passes nothing") {
  const ExampleScenario hardware =
      scenario("cart_pole_hardware", {"control.duration_s=0.1", "goal.success_min=[-1, -1, -9, -9]",
                                      "goal.success_max=[1, 1, 9, 9]"});
  int asked = 0;
  const TrialsResult result = run_trials(hardware, 1, [&] { return ++asked > 25; });
  CHECK(result.interrupted);
  REQUIRE(result.trials.size() == 2);  // of 10 control steps each
  const ExampleReport report = report_on(hardware, 1, result);
  CHECK(report.success_rate == 1.0);
  CHECK(report.result == "interrupted");
  CHECK(report.trials_wanted == 10);
}

TEST_CASE("a run interrupted before its first trial ended has nothing to report") {
  const ExampleScenario cart_pole = scenario("cart_pole");
  const TrialsResult result = run_trials(cart_pole, 1, [] { return true; });
  const ExampleReport report = report_on(cart_pole, 1, result);
  CHECK(report.trials.empty());
  CHECK(to_json(report)["success_rate"].is_null());
  CHECK_FALSE(report.criteria.at(0).met);
}

TEST_CASE("the nonlinear cart-pole falls as the linear one while the angle is small") {
  const example::Experiment hardware = scenario("cart_pole_hardware").experiment;
  const std::unique_ptr<example::Plant> plant = make_plant(hardware);
  example::LcsPlant linear(hardware);
  Eigen::VectorXd x = Eigen::Vector4d(0.0, 0.01, 0.0, 0.0), y = x, lambda;
  Eigen::VectorXd force = Eigen::VectorXd::Constant(1, 0.2), linear_lambda(2);
  plant->reset(x);
  linear.reset(y);
  for (int i = 0; i < 200; ++i) {
    REQUIRE(plant->step(force, x, lambda));
    REQUIRE(linear.step(force, y, linear_lambda));
  }
  CHECK(x[1] > 0.015);
  // both take steps of 1 ms: they differ by the nonlinearity and by the order of Euler's updates
  CHECK((x - y).cwiseAbs().maxCoeff() < 0.01 * y.cwiseAbs().maxCoeff());
  CHECK(lambda.isZero());
}

TEST_CASE("a mechanism of one's own pushes its disc to the goal in MuJoCo") {
  const ExampleScenario pusher =
      load_example(C3RT_SOURCE_DIRECTORY "/examples/pusher/pusher.yaml", {"start.trials=3"});
  CHECK(pusher.experiment.mujoco_plant);
  const TrialsResult result = run_trials(pusher, 1, never);
  REQUIRE(result.trials.size() == 3);
  for (const Trial& trial : result.trials) {
    CAPTURE(trial.final_state.transpose());
    CHECK(trial.succeeded);
    CHECK(trial.controller_failures == 0);
  }
  // drawn by the names of its joints and bodies, with the goal of what is weighed
  const std::vector<Panel> panels = trajectory_panels(pusher.experiment, result.first);
  REQUIRE(panels.size() == 3);
  CHECK(panels[0].curves[2].name == "disc_x");
  CHECK(panels[0].curves.back().y == Eigen::Vector2d(0.01, 0.01));
  CHECK(panels[2].curves[1].name == "force_y");
  // it moved over the floor, not through it, and pushing took no more than the motors have
  CHECK((result.first.x.row(4).array() - 0.02).abs().maxCoeff() < 2e-3);
  CHECK(result.first.u.cwiseAbs().maxCoeff() <= 20.0);
}

TEST_CASE("the table of a trajectory has a row for each state and a name for each column") {
  const Folder folder;
  for (const char* name : {"cart_pole", "finger_gaiting", "pivoting"}) {
    CAPTURE(name);
    const ExampleScenario example = scenario(name, {"control.duration_s=0.2", "start.trials=1"});
    const TrialsResult result = run_trials(example, 1, never);
    const c3::Sizes s = example::sizes(example.experiment);
    write_trajectory(folder.path() / "t.csv", example.experiment, result.first);
    std::ifstream stream(folder.path() / "t.csv");
    int rows = 0;
    for (std::string line; std::getline(stream, line); ++rows) {
      REQUIRE(std::count(line.begin(), line.end(), ',') == s.n_x + s.n_u + s.n_lambda + 1);
    }
    CHECK(rows == 1 + result.first.x.cols());
    CHECK(draw({{folder.path() / "t.png",
                 {name, trajectory_panels(example.experiment, result.first)}}}) == "");
  }
}
