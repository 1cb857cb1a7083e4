#include "plant_emulator/load_parameters.hpp"

#include <string>

#include <catch2/catch.hpp>

namespace c3rt::plant {
namespace {

const std::string kYaml = R"(table_height_m: -0.0245
table_tilt_rad: [0.01, -0.02]
friction: {ball_table: 0.9, ball_end_effector: 0.8, ball_ball: 0.3, end_effector_table: 0.5}
rolling_friction_m: 0.0001
step_s: 0.0005
initial_q_rad: [0, 0.275, 0, -2.222, 0, 2.497, 0]
balls:
  - {position_m: [0.55, 0.1], radius_m: 0.0315, mass_kg: 0.132}
  - {position_m: [0.45, 0.1], radius_m: 0.02, mass_kg: 0.05}
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
  CHECK(p.world.friction.ball_table == 0.9);
  CHECK(p.world.friction.ball_end_effector == 0.8);
  CHECK(p.world.friction.ball_ball == 0.3);
  CHECK(p.world.friction.end_effector_table == 0.5);
  CHECK(p.world.rolling_friction == 0.0001);
  CHECK(p.world.step == 0.0005);
  CHECK(p.initial_q[5] == 2.497);
  REQUIRE(p.world.balls.size() == 2);
  CHECK(p.world.balls[1].position == Eigen::Vector2d(0.45, 0.1));
  CHECK(p.world.balls[1].radius == 0.02);
  CHECK(p.world.balls[1].mass == 0.05);
  CHECK(p.world.balls[0].start_spread == 0.0);
  CHECK(parse(replaced("0.132}", "0.132, start_spread_m: 0.01}")).world.balls[0].start_spread ==
        0.01);
}

TEST_CASE("the table's tilt and the ball's friction may be left to the seed") {
  CHECK_FALSE(parse(kYaml).world.tilt_drawn);
  CHECK_FALSE(parse(kYaml).world.friction_drawn);
  CHECK(parse(kYaml + "table_tilt_drawn: true\n").world.tilt_drawn);
  const auto friction = [](const std::string& bounds) {
    return replaced("end_effector_table: 0.5}",
                    "end_effector_table: 0.5, ball_drawn: " + bounds + "}");
  };
  CHECK(parse(friction("[0.3, 1.2]")).world.friction_drawn == Eigen::Vector2d(0.3, 1.2));
  CHECK_THROWS_WITH(parse(friction("[1.2, 0.3]")), Catch::Contains("ball_drawn"));
}

TEST_CASE("pushes and a hand that holds the ball may be asked for") {
  const std::string pushes =
      "pushes: {count: 3, from_s: 5, until_s: 50, impulse_min_n_s: 0.001, impulse_max_n_s: 0.01}\n";
  CHECK(parse(kYaml).pushes.count == 0);
  CHECK(parse(kYaml + pushes).pushes.count == 3);
  CHECK(parse(kYaml + pushes).pushes.impulse_max == 0.01);
  CHECK_FALSE(parse(kYaml).world.balls[0].held);
  CHECK(parse(replaced("0.132}", "0.132, held: true}")).world.balls[0].held);
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
  CHECK_THROWS_WITH(parse(replaced("ball_ball: 0.3, ", "")), Catch::Contains("ball_ball"));
  CHECK_THROWS_WITH(parse(replaced("step_s: 0.0005", "step_s: 0.002")),
                    Catch::Contains("test.yaml:5") && Catch::Contains("step_s"));
  CHECK_THROWS_WITH(parse(replaced("-2.222", "0.5")),
                    Catch::Contains("test.yaml:6") && Catch::Contains("joint 4"));
  CHECK_THROWS_WITH(parse(replaced("radius_m: 0.02, ", "colour: red, radius_m: 0.02, ")),
                    Catch::Contains("colour"));
  CHECK_THROWS_WITH(parse(replaced("step_s: 0.0005", "step_s: 0.0007")),
                    Catch::Contains("divides 0.001"));
  CHECK_THROWS_WITH(parse(replaced("[0.45, 0.1]", "[0.5, 0.1]")),
                    Catch::Contains("balls") && Catch::Contains("overlap"));
  CHECK_THROWS_WITH(parse(replaced("0.132}", "0.132, start_spread_m: 0.06}")),
                    Catch::Contains("balls") && Catch::Contains("overlap"));
}

TEST_CASE("boxes stand beside balls or in their place, and overlap with nothing") {
  const std::string boxes =
      "boxes: [{position_m: [0.6, -0.1], half_sizes_m: [0.05, 0.04, 0.03], mass_kg: 0.5, yaw_rad: "
      "0.3}]\n";
  const Parameters both = parse(kYaml + boxes);
  REQUIRE(both.world.balls.size() == 3);
  CHECK(object_name(both.world, 1) == "ball1");
  CHECK(object_name(both.world, 2) == "box2");
  CHECK(*both.world.balls[2].half_sizes == Eigen::Vector3d(0.05, 0.04, 0.03));
  CHECK(both.world.balls[2].yaw == 0.3);
  CHECK_FALSE(both.world.balls[0].half_sizes);
  const std::string without = kYaml.substr(0, kYaml.find("balls:"));
  CHECK(parse(without + boxes).world.balls.size() == 1);
  CHECK_THROWS_WITH(parse(without), Catch::Contains("1 to 4 objects"));
  // half a diagonal from the centre a ball may touch a corner
  const std::string near =
      "boxes: [{position_m: [0.55, 0.03], half_sizes_m: [0.05, 0.04, 0.03], mass_kg: 0.5}]\n";
  CHECK_THROWS_WITH(parse(kYaml + near), Catch::Contains("cannot overlap"));
  CHECK_THROWS_WITH(parse(without + "boxes: [{position_m: [0.6, 0], mass_kg: 0.5}]\n"),
                    Catch::Contains("half_sizes_m"));
}

}  // namespace
}  // namespace c3rt::plant
