#include "config/scenario.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>

#include "controller/example/load_experiment.hpp"
#include "controller/planner/c3_controller.hpp"
#include "controller/scene/object.hpp"
#include "controller/task/circle.hpp"
#include "controller/task/line.hpp"
#include "controller/task/path.hpp"
#include "plant_emulator/plant.hpp"

using c3rt::config::ConfigError;
using c3rt::config::Document;
using c3rt::config::load_scenario;
using c3rt::config::Section;
using c3rt::task::Circle;
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

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  REQUIRE(file);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// circle_slow with another section `task`.
c3rt::config::Scenario with_task(const std::string& task) {
  const std::string circle = read_file(kFolder + "circle_slow.yaml");
  const std::size_t at = circle.find("task:\n"), end = circle.find("\ncriteria:");
  REQUIRE(at != std::string::npos);
  REQUIRE(end != std::string::npos);
  return c3rt::config::read_scenario(
      Document::parse(circle.substr(0, at) + task + circle.substr(end), "other.yaml"));
}

const std::string kPath =
    "task: {kind: path, points_m: [[0.5, 0], [0.6, 0.1]], interval_s: 2, between: hold, "
    "lead_s: 0.1, preview: true, loops: 3, duration_s: 20}";
const std::string kLine =
    "task: {kind: line, x_m: 0.55, step_m: -0.01, y_end_m: -0.1, spacing_m: 0.08, duration_s: 20}";

}  // namespace

TEST_CASE("scenario: every shipped file can be loaded, and is named as its file") {
  int scenarios = 0, examples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    const std::string file = entry.path().string();
    CAPTURE(file);
    Section root = Document::load(file);
    if (root.has("example")) {
      CHECK(root.name("name") == entry.path().stem());
      CHECK_NOTHROW(c3rt::example::load_experiment(root));
      ++examples;
      continue;
    }
    const c3rt::config::Scenario scenario = load_scenario(file);
    CHECK(scenario.name == entry.path().stem());
    CHECK_FALSE(scenario.description.empty());
    CHECK(std::string(scenario.task.motion.kind()) == scenario.planner.task.kind());
    CHECK_FALSE(scenario.criteria.empty());
    CHECK_FALSE(scenario.plant.world.objects.empty());
    ++scenarios;
  }
  CHECK(scenarios >= 21);
  CHECK(examples >= 4);
}

TEST_CASE("scenario: the task of a circle is the planner's, too") {
  const c3rt::config::Scenario scenario = load_scenario(kFolder + "circle_slow.yaml");
  const auto& circle = *scenario.task.motion.as<c3rt::task::Circle>();
  CHECK(circle.radius == 0.1);
  CHECK(scenario.planner.task.as<c3rt::task::Circle>()->lead == circle.lead);
}

TEST_CASE(
    "scenario: every shipped path in time closes, starts at its ball and is no faster than 25 "
    "mm/s") {
  for (const char* name :
       {"path_circle", "path_line", "path_rectangle", "path_figure_eight", "path_n"}) {
    CAPTURE(name);
    const c3rt::config::Scenario scenario = load_scenario(kFolder + name + ".yaml");
    CHECK(scenario.name == name);
    const auto& path = *scenario.task.motion.as<c3rt::task::Path>();
    const Eigen::Vector2d ball = scenario.plant.world.objects.at(0).position;
    CHECK((ball - path.points.front()).norm() < 1e-9);
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const Eigen::Vector2d& next = path.points[(i + 1) % path.points.size()];
      CHECK((next - path.points[i]).norm() / path.interval < 0.025);
    }
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

TEST_CASE("scenario: each kind of task is read, and the planner has the same") {
  const c3rt::config::Scenario path_scenario = with_task(kPath);
  const auto& path = *path_scenario.task.motion.as<c3rt::task::Path>();
  REQUIRE(path.points.size() == 2);
  CHECK(path.points[1] == Eigen::Vector2d(0.6, 0.1));
  CHECK(path.interval == 2.0);
  CHECK(path.between == c3rt::task::Between::kHold);
  CHECK(path.lead == 0.1);
  CHECK(path.preview);
  CHECK(path_scenario.task.loops == 3);
  CHECK(path_scenario.planner.task.as<c3rt::task::Path>() != nullptr);

  const c3rt::config::Scenario line_scenario = with_task(kLine);
  const auto& line = *line_scenario.task.motion.as<c3rt::task::Line>();
  CHECK(line.x == 0.55);
  CHECK(line.step == -0.01);
  CHECK(line.y_end == -0.1);
  CHECK(line.spacing == 0.08);
}

TEST_CASE("scenario: a task's keys are those of its kind alone") {
  const auto with = [](std::string task, const std::string& key) {
    return task.replace(task.size() - 1, 1, ", " + key + "}");
  };
  CHECK_THROWS_WITH(with_task(with(kPath, "radius_m: 0.1")),
                    Contains("task.radius_m: unknown key"));
  CHECK_THROWS_WITH(with_task(with(kLine, "loops: 1")), Contains("task.loops: unknown key"));
  CHECK_THROWS_WITH(with_task("task: {kind: circle, x_m: 0.5}"),
                    Contains("task.center_m: missing"));
  CHECK_THROWS_WITH(with_task("task: {kind: spiral}"),
                    Contains("task.kind: expected one of circle, path, line"));
  CHECK_THROWS_WITH(with_task("task: {kind: line, x_m: 0.55, step_m: 0, y_end_m: 0}"),
                    Contains("task.step_m: expected a step that is not 0"));
  CHECK_THROWS_WITH(with_task("task: {kind: path, points_m: [[0.5, 0], [0.6]]}"),
                    Contains("task.points_m: expected a list of 2 to 1000 lists of 2 numbers") &&
                        Contains("at place 2"));
  CHECK_THROWS_WITH(with_task("task: {kind: path, points_m: [[0.5, 0]]}"),
                    Contains("task.points_m: expected a list of 2 to 1000"));
}

TEST_CASE("scenario: several balls have weights, contacts and friction of their own") {
  const auto error = [](const std::vector<std::string>& overrides) -> std::string {
    try {
      (void)load_scenario(kFolder + "two_balls.yaml", overrides);
    } catch (const c3rt::config::ConfigError& e) {
      return e.what();
    }
    return "";
  };
  const auto planner = load_scenario(kFolder + "two_balls.yaml").planner;
  CHECK(planner.model.kind == "rolling_balls");
  CHECK(planner.model.bodies == 2);
  CHECK(planner.model.pairs == std::set<std::string>{"ball_ball", "end_effector_ball"});
  REQUIRE(planner.roll.Q.at("ball_xy").size() == 2);
  CHECK(load_scenario(kFolder + "two_balls.yaml", {"planner.weights.roll.Q.ball_xy=7"})
            .planner.roll.Q.at("ball_xy") == std::vector<double>{7.0, 7.0});
  CHECK_THAT(error({"planner.weights.roll.Q.ball_xy=[1, 2, 3]"}),
             Contains("planner.weights.roll.Q.ball_xy: expected a list of 2 numbers"));
  CHECK_THAT(error({"planner.weights.roll.Q.ball_xy=heavy"}),
             Contains("planner.weights.roll.Q.ball_xy: expected a number in") &&
                 Contains("or a list of 2 of them"));
  CHECK_THAT(error({"planner.model.friction_balls=-1"}), Contains("planner.model.friction_balls"));
  CHECK_THAT(error({"planner.heuristic.room_ahead_m=2"}),
             Contains("planner.heuristic.room_ahead_m: expected a number in [0, 1]"));
  CHECK_THAT(error({"task.spacing_m=-1"}), Contains("task.spacing_m: expected a number in"));
  CHECK_THAT(error({"planner.model.contacts={end_effector_ball: false, ball_ball: false}"}),
             Contains("planner.model.contacts: expected at least one pair that is true"));
  CHECK_THAT(error({"planner.model.contacts={end_effector_ball: true, ball_table: true}"}),
             Contains("planner.model.contacts.ball_ball: missing"));
}

TEST_CASE("scenario: a key that nobody knows is refused, wherever it stands") {
  const std::string whole = read_file(kFolder + "circle_slow.yaml");
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

namespace {

/// A shipped scenario with changes, or the error.
std::string error_with(const std::string& base, const std::string& changes,
                       const std::vector<std::string>& overrides = {}) {
  try {
    (void)c3rt::config::read_scenario(Document::parse(
        "name: own\ndescription: none\nextends: " + base + "\n" + changes, "own.yaml", overrides));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("scenario: cameras are refused with an object that they cannot track, by its name") {
  const auto error = [](const std::string& base, const std::string& objects) {
    return error_with(base, "plant: {objects: [" + objects + "]}\nvision: {source: cameras}\n");
  };
  const std::string ball =
      "{shape: sphere, position_m: [0.55, 0.1], radius_m: 0.0315, mass_kg: 0.1}";
  CHECK(error("circle_slow", ball) == "no error");
  CHECK_THAT(
      error("push_box",
            "{mjcf: ../objects/bar.xml, name: ell, position_m: [0.5, 0], friction_table: 0.3}"),
      Contains("vision.source") && Contains("\"ell\"") && Contains("no sphere by its tags"));
  CHECK_THAT(error("push_box",
                   "{shape: box, position_m: [0.5, 0], half_sizes_m: [0.05, 0.05, "
                   "0.03], mass_kg: 0.5}"),
             Contains("vision.source") && Contains("\"box0\""));
}

TEST_CASE(
    "scenario: a planner that believes the table elsewhere than the plant has it is refused") {
  CHECK_THAT(error_with("push_box", "planner: {model: {table_height_m: 0.0}}\n"),
             Contains("planner.model") && Contains("plant.table_height_m, which is -0.0245") &&
                 Contains("got 0"));
  CHECK(error_with("push_box", "planner: {model: {table_height_m: -0.022}}\n") == "no error");
}

TEST_CASE("scenario: an end effector that would rub on the table is refused") {
  CHECK(error_with("push_t", "planner: {sampling: {height_m: 0.022}}\n") == "no error");
  CHECK_THAT(error_with("push_t", "planner: {sampling: {height_m: 0.02}}\n"),
             Contains("height_m: expected a number in [0.0215"));
}

TEST_CASE("scenario: what extends a shipped one is checked as a whole, by the line of each value") {
  CHECK(error_with("circle_fast", "planner: {rate_hz: 100}\n") == "no error");
  CHECK_THAT(error_with("circle_fast", "planner:\n  horizon: 99\n"),
             Catch::StartsWith("own.yaml:5: planner.horizon: expected an integer in [1, 10]"));
  CHECK_THAT(error_with("circle_fast", "planner:\n  horizn: 5\n"),
             Catch::StartsWith("own.yaml:5: planner.horizn: unknown key"));
  // the base is right for one ball, not for two
  CHECK_THAT(
      error_with("circle_fast",
                 "plant:\n  objects:\n"
                 "    - {shape: sphere, position_m: [0.55, 0.1], radius_m: 0.03, mass_kg: 0.1}\n"
                 "    - {shape: sphere, position_m: [0.45, 0.1], radius_m: 0.03, mass_kg: 0.1}\n"),
      Contains("circle_slow.yaml:") && Contains("planner.model.friction_balls: missing"));
  // a key of the base that the file's choice has no use for
  CHECK_THAT(error_with("circle_fast",
                        "task: {kind: line, x_m: 0.55, step_m: -0.01, y_end_m: -0.1, "
                        "spacing_m: 0.08}\n"),
             Contains("circle_slow.yaml:") && Contains("task.center_m: unknown key"));
}

TEST_CASE("scenario: what is not chosen may be absent, and is asked for where it is chosen") {
  struct Row {
    std::string absent, choice, error;
  };
  const std::string both = "planner: {weights: {roll: {KEY: ~}, return: {KEY: ~}}}\n";
  const auto weights = [&](const std::string& key) {
    std::string text = both;
    for (std::size_t at; (at = text.find("KEY")) != std::string::npos;) text.replace(at, 3, key);
    return text;
  };
  const Row rows[] = {
      {weights("plus"), "planner.c3.projection=plus",
       "planner.weights.roll.plus: missing, projection plus needs it"},
      {weights("convex"), "planner.c3.projection=convex",
       "planner.weights.roll.convex: missing, projection convex needs it"},
      {"planner: {c3: {projection: lcp}, weights: {roll: {U: ~}, return: {U: ~}}}\n",
       "planner.c3.projection=miqp", "planner.weights.roll.U: missing, projection miqp needs it"},
      {"planner: {c3: {projection: lcp, max_nodes: ~}}\n", "planner.c3.projection=miqp",
       "planner.c3.max_nodes: missing, projection miqp needs it"},
      {"planner: {c3: {osqp: ~}}\n", "planner.c3.qp=osqp",
       "planner.c3.osqp: missing, qp osqp needs it"},
      {"vision: {detector: ~}\n", "vision.source=cameras",
       "vision.detector: missing, source cameras needs it"},
      {"vision: {fusion: ~}\n", "vision.source=cameras",
       "vision.fusion: missing, source cameras needs it"},
      {"vision: {cameras: ~}\n", "vision.source=cameras",
       "vision.cameras: missing, source cameras needs it"},
      {"vision: {pixel_noise: ~}\n", "vision.source=cameras",
       "vision.pixel_noise: missing, source cameras needs it"},
      {"vision: {source: cameras, emulated: ~}\n", "vision.source=emulated",
       "vision.emulated: missing, source emulated needs it"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.absent, row.choice);
    CHECK(error_with("circle_slow", row.absent) == "no error");
    CHECK_THAT(error_with("circle_slow", row.absent, {row.choice}), Contains(row.error));
  }
}

TEST_CASE("scenario: cameras know what is no sphere by its tags, which must be there and differ") {
  CHECK_THAT(error_with("push_box", "", {"vision.source=cameras"}),
             Contains("vision.source: expected emulated, or sites tag36h11_ID in the MuJoCo model "
                      "of \"box0\""));
  CHECK_THAT(error_with("push_t", "", {"vision.source=cameras"}),
             Contains("vision.tags: expected the section, as cameras know \"t\" by its tags"));
  CHECK(error_with("push_t_cameras", "") == "no error");
  CHECK_THAT(error_with("push_t_cameras",
                        "planner: {model: {objects: [../objects/t.xml, ../objects/t.xml], "
                        "contacts: {object_object: true}}, "
                        "weights: {push: {G: {object_normal: 0.1, object_tangential: 0.1}}}}\n"
                        "plant: {objects: [{mjcf: ../objects/t.xml, position_m: [0.5, -0.2]}, "
                        "{mjcf: ../objects/t.xml, position_m: [0.5, 0.2]}]}\n"),
             Contains("objects whose tags differ, got tag 0 on \"t\" and on \"t1\""));
}

TEST_CASE("scenario: what is there is checked though it is not chosen") {
  CHECK_THAT(error_of({"planner.weights.roll.plus.g_eta=-1"}),
             Contains("planner.weights.roll.plus.g_eta: expected a number in"));
  CHECK_THAT(error_of({"planner.weights.return.convex.alpha=2"}),
             Contains("planner.weights.return.convex.alpha: expected a number in [0, 1]"));
  CHECK_THAT(error_of({"planner.c3.osqp.eps=0"}),
             Contains("planner.c3.osqp.eps: expected a number in"));
  CHECK_THAT(error_of({"vision.detector.rays=1"}),
             Contains("vision.detector.rays: expected an integer"));
  CHECK_THAT(error_with("circle_slow", "planner: {weights: {roll: {plus: {g_etta: 1}}}}\n"),
             Contains("own.yaml:4: planner.weights.roll.plus.g_etta: unknown key"));
  const auto final_scale = [](const std::string& contacts) {
    return error_with("circle_slow",
                      "planner: {weights: {roll: {plus: {final_scale: " + contacts + "}}}}\n");
  };
  CHECK(final_scale("{end_effector: 1000}") == "no error");
  CHECK_THAT(final_scale("{end_effector: 0.5}"),
             Contains("plus.final_scale.end_effector: expected a number in [1, "));
  CHECK_THAT(final_scale("{end_effector_cube: 2}"),
             Contains("plus.final_scale.end_effector_cube: unknown key"));
}

TEST_CASE("scenario: another end effector in the robot's description is that of arm and plant") {
  std::string robot = read_file(C3RT_SOURCE_DIRECTORY "/config/robots/panda.yaml");
  const std::string from = "sphere_center_m: 0.1265";
  REQUIRE(robot.find(from) != std::string::npos);
  robot.replace(robot.find(from), from.size(), "sphere_center_m: 0.16");
  const std::string path = std::string(C3RT_BINARY_DIRECTORY) + "/longer_robot.yaml";
  std::ofstream(path) << robot;
  const auto p_WE = [](const std::vector<std::string>& overrides) {
    const c3rt::config::Scenario scenario = load_scenario(kFolder + "circle_slow.yaml", overrides);
    c3rt::model::Arm arm(scenario.impedance.arm);
    c3rt::model::ArmState state;
    arm.update(scenario.plant.initial_q, c3rt::model::Vector7d::Zero(), state);
    // Pinocchio's arm and MuJoCo's
    const c3rt::plant::Plant plant(scenario.plant);
    CHECK((plant.state().p_WE - state.X_WE.translation()).norm() < 1e-6);
    return Eigen::Vector3d(state.X_WE.translation());
  };
  CHECK((p_WE({"robot=" + path}) - p_WE({})).norm() == Approx(0.16 - 0.1265));
}

TEST_CASE("scenario: what a robot's description says of a scenario is checked by its line") {
  const std::string robot = read_file(C3RT_SOURCE_DIRECTORY "/config/robots/panda.yaml");
  const std::string path = std::string(C3RT_BINARY_DIRECTORY) + "/wrong_robot.yaml";
  const auto error = [&](const std::string& from, const std::string& to) {
    std::string text = robot;
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    std::ofstream(path) << text.replace(at, from.size(), to);
    return error_of({"robot=" + path});
  };
  CHECK_THAT(error("    gains: {", "    gains: {typo: 1, "),
             Contains("wrong_robot.yaml:32: impedance.gains.typo: unknown key"));
  CHECK_THAT(
      error("initial_q_rad: [0.0,", "initial_q_rad: [3.0,"),
      Contains("wrong_robot.yaml:30: plant.initial_q_rad: expected joint 1 in [-2.897300, "));
}

TEST_CASE("scenario: objects to plan with come from MJCF files beside the one that names them") {
  const auto changed = [](const std::string& objects, const std::string& more = "") {
    const std::string base = kFolder + "push_box.yaml";
    return c3rt::config::read_scenario(Document::parse(
        "name: own\ndescription: none\nextends: " + base +
            "\nplanner:\n"
            "  model: {kind: mjcf, box_mass_kg: ~, box_half_x_m: ~, box_half_y_m: ~, box_half_z_m: "
            "~,\n"
            "    " +
            objects + more +
            ", contacts: {end_effector_box: ~, box_table: ~,\n"
            "    end_effector_object: true, object_table: true}}\n"
            "  weights: {push: {Q: {box_xy: ~, box_z: ~, box_rotation: ~, box_velocity: ~,\n"
            "    box_angular_velocity: ~, object_xy: 1, object_z: 0, object_rotation: 0.05,\n"
            "    object_velocity: 1.0e-4, object_angular_velocity: 1.0e-5}}}\n",
        kFolder + "own.yaml"));
  };
  const auto refused = [&](const std::string& objects, const std::string& more = "") {
    try {
      (void)changed(objects, more);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const auto scenario = changed("objects: ../objects/t.xml", ", size_scale: 0.98, mass_scale: 2");
  const auto& model = scenario.planner.model;
  CHECK(model.kind == "mjcf");
  REQUIRE(model.values.objects().size() == 1);
  CHECK(model.values.objects()[0].name == "t");
  CHECK(model.values["size_scale"] == 0.98);
  CHECK(model.values["support_points"] == 4.0);
  const auto planned = c3rt::planner::make_model(model);
  CHECK(planned->layout().n_c() == 5);
  CHECK(c3rt::scene::reach(planned->layout().world.body(0).shape, {1.0, 0.0, 0.0}) ==
        Approx(0.98 * 0.08));

  CHECK_THAT(refused("objects: ../objects/u.xml"), Contains("own.yaml:6: planner.model.objects"));
  CHECK_THAT(refused("objects: [../objects/t.xml, ../objects/box.xml]"),
             Contains("expected a list of 1 to 1 files"));
  CHECK_THAT(refused("objects: own_broken.xml"), Contains("expected a file that is there"));
  CHECK_THAT(refused("objects: ../scenarios/push_box.yaml"),
             Contains("objects that can be planned with"));
  CHECK_THAT(refused("objects: ../objects/t.xml", ", end_effector_contacts: all"),
             Contains("nearest, each"));
}
