#include "config/robot.hpp"

#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

#include "config/directory.hpp"
#include "config/extends.hpp"
#include "tests/config/error_of.hpp"

using namespace c3rt::config;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
namespace fs = std::filesystem;
using c3rt::test::error_of;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Panda's description with one text replaced, in a file of its own.
std::string other_robot(const std::string& from, const std::string& to) {
  std::string text = text_of(directory() / "robots/panda.yaml");
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  const std::string path = std::string(C3RT_BINARY_DIRECTORY) + "/other_robot.yaml";
  std::ofstream(path) << text.replace(at, from.size(), to);
  return path;
}

Tree with_robot(const std::string& robot, const std::string& more = "") {
  const std::string file = std::string(C3RT_BINARY_DIRECTORY) + "/robot_scenario.yaml";
  return compose("extends: circle_slow\nrobot: " + robot + "\n" + more, file);
}

}  // namespace

TEST_CASE("robot: every shipped description can be read") {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(directory() / "robots")) {
    CAPTURE(entry.path());
    const Robot robot = load_robot(entry.path().stem().string());
    CHECK((robot.q_min.array() < robot.q_max.array()).all());
    CHECK(robot.end_effector.sphere_radius > 0);
    ++count;
  }
  CHECK(count >= 1);
}

TEST_CASE("robot: a scenario has the robot's values where it says nothing else") {
  const Tree tree = load_composed((directory() / "scenarios/circle_slow.yaml").string());
  const std::string panda = (directory() / "robots/panda.yaml").string();
  const Tree& limits = *tree.find("impedance")->find("limits");
  CHECK(*limits.find("q_min_rad")->place.file == panda);
  CHECK(limits.find("q_min_rad")->list[3].scalar == "-3.0718");
  CHECK(*limits.find("workspace_min_m")->place.file != panda);
  CHECK(tree.find("planner")->find("model")->find("end_effector_radius_m")->scalar == "0.0195");
  CHECK(tree.find("robot")->find("flange")->scalar == "panda_link8");
  CHECK(tree.find("robot")->find("scenario") == nullptr);

  const Tree own = with_robot("panda", "impedance: {limits: {q_min_rad: [1, 2, 3, 4, 5, 6, 7]}}\n");
  CHECK(own.find("impedance")->find("limits")->find("q_min_rad")->list[6].scalar == "7");
}

TEST_CASE(
    "robot: another one is named by its path, seen from the file that names it, or by --set") {
  const std::string other =
      other_robot("sphere_radius_m: &radius 0.0195", "sphere_radius_m: &radius 0.03");
  for (const std::string& name :
       {other, std::string("other_robot.yaml"), std::string("./other_robot.yaml")}) {
    const Tree tree = with_robot(name);
    CHECK(tree.find("planner")->find("model")->find("end_effector_radius_m")->scalar == "0.03");
    CHECK(tree.find("robot")->find("end_effector")->find("sphere_radius_m")->scalar == "0.03");
  }
  Section root = Document::load((directory() / "scenarios/circle_slow.yaml").string(),
                                {"impedance.limits.tau_rate_max_nm_per_s=5", "robot=" + other});
  CHECK(load_robot(root).end_effector.sphere_radius == 0.03);
  CHECK(root.section("impedance").section("limits").number("tau_rate_max_nm_per_s", {0, 10}) ==
        5.0);
}

TEST_CASE("robot: without a name it is the Panda") {
  Section root = Document::parse("name: x\n", "x.yaml");
  CHECK(load_robot(root).flange == "panda_link8");
}

TEST_CASE("robot: what is wrong in a description is refused by its file and line") {
  CHECK_THAT(error_of([] { (void)with_robot("pandas"); }),
             Contains("robot_scenario.yaml:2: robot: expected the name of a robot in ") &&
                 EndsWith("got \"pandas\""));
  CHECK_THAT(error_of([] { (void)with_robot("absent.yaml"); }),
             Contains(":2: robot: expected a file"));
  CHECK_THAT(error_of([] { (void)with_robot("[panda]"); }),
             Contains(":2: robot: expected the name of a robot or a path"));
  const auto error = [](const std::string& from, const std::string& to) {
    const std::string other = other_robot(from, to);
    return error_of([&] {
      Section root = Document::parse("extends: circle_slow\nrobot: " + other + "\n", "x.yaml");
      (void)load_robot(root);
    });
  };
  CHECK_THAT(error("mass_kg: 0.269", "mass_kg: -1"),
             Contains("other_robot.yaml:22: robot.end_effector.mass_kg: expected a number in"));
  CHECK_THAT(error("flange: panda_link8", "flnge: panda_link8"), Contains("robot.flange: missing"));
  CHECK_THAT(error("flange: panda_link8", "flange: panda_link8\ncolour: red"),
             Contains("other_robot.yaml:4: robot.colour: unknown key"));
  CHECK_THAT(error("-2.8973, -1.7628", "3, -1.7628"),
             Contains("robot.joints.q_max_rad: expected every entry above"));
}
