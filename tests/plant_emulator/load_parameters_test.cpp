#include "plant_emulator/load_parameters.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <unistd.h>

using namespace c3rt;
using namespace c3rt::plant;

namespace {

const std::string kYaml = R"(table_height_m: -0.0245
table_tilt_rad: [0.01, -0.02]
friction: {object_table: 0.9, object_end_effector: 0.8, object_object: 0.3, end_effector_table: 0.5}
rolling_friction_m: 0.0001
step_s: 0.0005
initial_q_rad: [0, 0.275, 0, -2.222, 0, 2.497, 0]
objects:
  - {shape: sphere, position_m: [0.55, 0.1], radius_m: 0.0315, mass_kg: 0.132}
  - {shape: sphere, position_m: [0.45, 0.1], radius_m: 0.02, mass_kg: 0.05}
)";

Parameters parse(const std::string& yaml) {
  return load_parameters(config::Document::parse(yaml, "test.yaml"), config::load_robot("panda"));
}

std::string replaced(const std::string& from, const std::string& to) {
  std::string yaml = kYaml;
  return yaml.replace(yaml.find(from), from.size(), to);
}

TEST_CASE("the plant's section is read key by key") {
  const Parameters p = parse(kYaml);
  CHECK(p.world.table_height == -0.0245);
  CHECK(p.world.table_tilt == Eigen::Vector2d(0.01, -0.02));
  CHECK(p.world.objects.at(0).friction_table == 0.9);
  CHECK(p.world.objects.at(0).friction_end_effector == 0.8);
  CHECK(p.world.friction.object_object == 0.3);
  CHECK(p.world.friction.end_effector_table == 0.5);
  CHECK(p.world.rolling_friction == 0.0001);
  CHECK(p.world.step == 0.0005);
  CHECK(p.initial_q[5] == 2.497);
  REQUIRE(p.world.objects.size() == 2);
  CHECK(p.world.objects[1].position == Eigen::Vector2d(0.45, 0.1));
  CHECK(p.world.objects[1].object.shape().radius == 0.02);
  CHECK(p.world.objects[1].object.mass == 0.05);
  CHECK(p.world.objects[0].start_spread == 0.0);
  CHECK(parse(replaced("0.132}", "0.132, start_spread_m: 0.01}")).world.objects[0].start_spread ==
        0.01);
}

TEST_CASE("the table's tilt and the ball's friction may be left to the seed") {
  CHECK_FALSE(parse(kYaml).world.tilt_drawn);
  CHECK_FALSE(parse(kYaml).world.friction_drawn);
  CHECK(parse(kYaml + "table_tilt_drawn: true\n").world.tilt_drawn);
  const auto friction = [](const std::string& bounds) {
    return replaced("end_effector_table: 0.5}",
                    "end_effector_table: 0.5, object_drawn: " + bounds + "}");
  };
  CHECK(parse(friction("[0.3, 1.2]")).world.friction_drawn == Eigen::Vector2d(0.3, 1.2));
  CHECK_THROWS_WITH(parse(friction("[1.2, 0.3]")), Catch::Contains("object_drawn"));
}

TEST_CASE("pushes and a hand that holds the ball may be asked for") {
  const std::string pushes =
      "pushes: {count: 3, from_s: 5, until_s: 50, impulse_min_n_s: 0.001, impulse_max_n_s: 0.01}\n";
  CHECK(parse(kYaml).pushes.count == 0);
  CHECK(parse(kYaml + pushes).pushes.count == 3);
  CHECK(parse(kYaml + pushes).pushes.impulse_max == 0.01);
  CHECK_FALSE(parse(kYaml).world.objects[0].held);
  CHECK(parse(replaced("0.132}", "0.132, held: true}")).world.objects[0].held);
  const auto wrong = [&](const std::string& from, const std::string& to) {
    std::string text = kYaml + pushes;
    return text.replace(text.find(from), from.size(), to);
  };
  CHECK_THROWS_WITH(parse(wrong("until_s: 50", "until_s: 4")), Catch::Contains("until_s"));
  CHECK_THROWS_WITH(parse(wrong("max_n_s: 0.01", "max_n_s: 0.0001")),
                    Catch::Contains("impulse_max_n_s"));
}

TEST_CASE("a mistake in the plant's section is refused with its line and key") {
  CHECK_THROWS_WITH(parse(kYaml + "gravity: 9.81\n"), Catch::Contains("gravity"));
  CHECK_THROWS_WITH(parse(replaced("object_object: 0.3, ", "")), Catch::Contains("object_object"));
  CHECK_THROWS_WITH(parse(replaced("step_s: 0.0005", "step_s: 0.002")),
                    Catch::Contains("test.yaml:5") && Catch::Contains("step_s"));
  CHECK_THROWS_WITH(parse(replaced("-2.222", "0.5")),
                    Catch::Contains("test.yaml:6") && Catch::Contains("joint 4"));
  CHECK_THROWS_WITH(parse(replaced("radius_m: 0.02, ", "colour: red, radius_m: 0.02, ")),
                    Catch::Contains("colour"));
  CHECK_THROWS_WITH(parse(replaced("step_s: 0.0005", "step_s: 0.0007")),
                    Catch::Contains("divides 0.001"));
  CHECK_THROWS_WITH(parse(replaced("[0.45, 0.1]", "[0.5, 0.1]")),
                    Catch::Contains("objects") && Catch::Contains("overlap"));
  CHECK_THROWS_WITH(parse(replaced("0.132}", "0.132, start_spread_m: 0.06}")),
                    Catch::Contains("objects") && Catch::Contains("overlap"));
}

const std::string kWithout = kYaml.substr(0, kYaml.find("objects:"));

/// The plant with these objects alone.
Parameters with_objects(const std::string& entries) {
  return parse(kWithout + "objects: [" + entries + "]\n");
}

TEST_CASE("objects of any shape stand beside one another, and overlap with nothing") {
  const std::string box =
      "{shape: box, position_m: [0.6, -0.1], half_sizes_m: [0.05, 0.04, 0.03], mass_kg: 0.5, "
      "yaw_rad: 0.3}";
  const Parameters p = with_objects(
      "{shape: sphere, position_m: [0.55, 0.1], radius_m: 0.0315, mass_kg: 0.132}, " + box +
      ", {shape: capsule, position_m: [0.4, 0.1], radius_m: 0.02, half_length_m: 0.03, mass_kg: "
      "0.2, roll_pitch_rad: [1.5708, 0]}, {shape: cylinder, name: can, position_m: [0.4, -0.1], "
      "radius_m: 0.03, half_length_m: 0.04, mass_kg: 0.3, friction_table: 0.2}");
  REQUIRE(p.world.objects.size() == 4);
  const auto name = [&](std::size_t i) { return p.world.objects[i].object.name; };
  CHECK(name(0) == "ball0");
  CHECK(name(1) == "box1");
  CHECK(name(2) == "capsule2");
  CHECK(name(3) == "can");
  CHECK(p.world.objects[1].object.shape().half_sizes == Eigen::Vector3d(0.05, 0.04, 0.03));
  CHECK(p.world.objects[1].yaw == 0.3);
  CHECK(p.world.objects[2].object.shape().kind == scene::ShapeKind::kCapsule);
  CHECK(start_height(p.world.objects[2]) == Approx(0.02));  // it lies
  CHECK(start_height(p.world.objects[3]) == Approx(0.04));  // it stands
  // its own friction, and that of the section where it has none
  CHECK(p.world.objects[3].friction_table == 0.2);
  CHECK(p.world.objects[3].friction_end_effector == 0.8);
  CHECK_THROWS_WITH(parse(kWithout), Catch::Contains("objects"));
  CHECK_THROWS_WITH(with_objects(""), Catch::Contains("a list of 1 to 8"));
  // half a diagonal from the centre a ball may touch a corner
  CHECK_THROWS_WITH(
      with_objects(box + ", {shape: sphere, position_m: [0.54, -0.1], radius_m: 0.03, mass_kg: 1}"),
      Catch::Contains("cannot overlap") && Catch::Contains("box0") && Catch::Contains("ball1"));
  CHECK_THROWS_WITH(with_objects("{shape: box, position_m: [0.6, 0], mass_kg: 0.5}"),
                    Catch::Contains("half_sizes_m"));
  CHECK_THROWS_WITH(with_objects("{shape: cone, position_m: [0.6, 0], mass_kg: 0.5}"),
                    Catch::Contains("capsule") && Catch::Contains("cone"));
  CHECK_THROWS_WITH(with_objects("{shape: sphere, position_m: [0.6, 0], radius_m: 0.03, mass_kg: "
                                 "1, name: table}"),
                    Catch::Contains("name") && Catch::Contains("table"));
}

TEST_CASE("an object of a MuJoCo model is as its file says, unless its entry says otherwise") {
  const std::string t =
      "{mjcf: ../objects/t.xml, position_m: [0.55, 0], start_spread_xy_m: [0.1, "
      "0.05], yaw_spread_rad: 3.1416";
  const ObjectParameters object = with_objects(t + "}").world.objects.at(0);
  CHECK(object.object.name == "t");
  CHECK(object.object.parts->parts.size() == 2);
  CHECK(object.object.mass == Approx(0.56));
  CHECK(object.friction_table == 0.4);
  CHECK(object.friction_end_effector == 0.4);
  CHECK(object.start_spread_xy == Eigen::Vector2d(0.1, 0.05));
  CHECK(object.yaw_spread == 3.1416);
  const ObjectParameters changed =
      with_objects(t + ", mass_scale: 2, size_scale: 1.1, friction_table: 0.8}")
          .world.objects.at(0);
  CHECK(changed.object.mass == Approx(1.12));
  CHECK(changed.object.inertia.isApprox(2.0 * 1.21 * object.object.inertia));
  CHECK(start_height(changed) == Approx(0.022));
  CHECK(changed.friction_table == 0.8);
  CHECK(changed.friction_end_effector == 0.4);
  // two of one file have names of their own
  const World two = with_objects(
                        "{mjcf: ../objects/t.xml, position_m: [0.45, 0.2]}, {mjcf: "
                        "../objects/t.xml, position_m: [0.45, -0.2]}")
                        .world;
  CHECK(two.objects.at(1).object.name == "t1");
  CHECK_THROWS_WITH(with_objects("{mjcf: ../objects/none.xml, position_m: [0.5, 0]}"),
                    Catch::Contains("none.xml"));
  CHECK_THROWS_WITH(with_objects(t + ", shape: box}"), Catch::Contains("shape or mjcf"));
  CHECK_THROWS_WITH(with_objects(t + ", start_spread_m: 0.1}"), Catch::Contains("both"));
}

TEST_CASE(
    "an object that cannot be simulated is refused by the name of what it has, and its file") {
  const std::string folder = std::filesystem::temp_directory_path().string();
  const auto error_of = [&](const std::string& joint, const std::string& rest) {
    const std::string file = folder + "/c3rt_object_" + std::to_string(getpid()) + ".xml";
    std::ofstream(file) << "<mujoco><worldbody><body name=\"lid\">" << joint
                        << "<geom name=\"top\" type=\"box\" size=\"0.1 0.1 0.1\"/></body>"
                           "</worldbody>"
                        << rest << "</mujoco>";
    try {
      with_objects("{mjcf: " + file + ", position_m: [0.5, 0]}");
    } catch (const config::ConfigError& error) {
      std::filesystem::remove(file);
      return std::string(error.what());
    }
    return std::string("no error");
  };
  using Catch::Contains;
  CHECK_THAT(error_of("<freejoint/>", "<equality><weld body1=\"lid\" name=\"glue\"/></equality>"),
             Contains("test.yaml") && Contains("objects.0.mjcf") && Contains("c3rt_object_") &&
                 Contains("glue"));
  CHECK_THAT(error_of("<joint name=\"swing\" type=\"hinge\"/>", ""), Contains("swing"));
  CHECK_THAT(error_of("", ""), Contains("free joint"));
}

}  // namespace
