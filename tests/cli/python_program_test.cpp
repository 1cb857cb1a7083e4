#include "cli/python_program.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace c3rt;
using namespace c3rt::cli;

namespace {

nlohmann::ordered_json scene_of(const std::string& scenario) {
  return shown_scene({}, {C3RT_SOURCE_DIRECTORY "/config/scenarios/" + scenario + ".yaml", {}});
}

TEST_CASE("shown_scene: a program is told each object's shape, the tip, the table and the arm") {
  const auto ball = scene_of("circle_slow");
  CHECK(ball["scenario"] == "circle_slow");
  REQUIRE(ball["objects"].size() == 1);
  CHECK(ball["objects"][0]["shape"]["kind"] == "sphere");
  CHECK(ball["objects"][0]["shape"]["radius"] == 0.0315);
  CHECK(ball["tip_radius_m"] == 0.0195);
  CHECK(ball["table_height_m"].get<double>() == Approx(-0.0245).margin(0.01));
  CHECK(ball["urdf"].get<std::string>().find("panda.urdf") != std::string::npos);
}

TEST_CASE("shown_scene: a body of several parts has each of them where it is") {
  const auto t = scene_of("push_t")["objects"][0]["shape"];
  REQUIRE(t["kind"] == "union");
  REQUIRE(t["parts"].size() == 2);
  CHECK(t["parts"][0]["shape"]["half_sizes"][0] == 0.08);
  // 0.32 kg of top and 0.24 kg of stem, 80 mm apart: the middle of mass is 3/7 of the way
  const double top = t["parts"][0]["p_BP"][1], stem = t["parts"][1]["p_BP"][1];
  CHECK(top - stem == Approx(0.08));
  CHECK(top == Approx(0.08 * 3.0 / 7.0));
  const auto cone = scene_of("cone_and_ball")["objects"][0]["shape"];
  CHECK(cone.dump().find("\"vertices\"") != std::string::npos);
}

}  // namespace
