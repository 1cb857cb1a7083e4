#include "controller/impedance/load_parameters.hpp"

#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::impedance;

namespace {

constexpr char kScenario[] = C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml";

Parameters load_with(const std::vector<std::string>& overrides) {
  config::Section scenario = config::Document::load(kScenario, overrides);
  return load_from_scenario(scenario);
}

TEST_CASE(
    "impedance parameters: the shipped scenario holds the robot's limits and what the law's names "
    "say") {
  const Parameters p = load_with({"impedance.gains.stiffness_translation_per_s2=400",
                                  "impedance.gains.stiffness_rotation_per_s2=800",
                                  "impedance.gains.damping_translation_per_s=40",
                                  "impedance.gains.damping_rotation_per_s=30"});
  CHECK(p.gains.stiffness == (Vector6d() << 400, 400, 400, 800, 800, 800).finished());
  CHECK(p.gains.damping == (Vector6d() << 40, 40, 40, 30, 30, 30).finished());
  CHECK(p.period == 1e-3);
  // what libfranka and the URDF allow
  const Vector7d tau_max = (Vector7d() << 87, 87, 87, 87, 12, 12, 12).finished();
  CHECK((p.limits.tau_max.array() <= tau_max.array()).all());
  CHECK(p.limits.tau_rate_max <= 1000);
  CHECK((p.gains.null_space_q.array() > p.limits.q_min.array()).all());
  CHECK((p.gains.null_space_q.array() < p.limits.q_max.array()).all());
}

TEST_CASE(
    "impedance parameters: the reference is one of two, the feed-forward on or off, the model "
    "one's own") {
  CHECK(load_with({"impedance.reference=hold"}).reference == Reference::kHold);
  CHECK(load_with({"impedance.reference=interpolate"}).reference == Reference::kInterpolate);
  CHECK(load_with({"impedance.feed_forward=true"}).feed_forward);
  CHECK_FALSE(load_with({"impedance.feed_forward=false"}).feed_forward);
  CHECK(load_with({}).arm.urdf_path == model::urdf_path("panda_description/urdf/panda.urdf"));
  CHECK_THROWS_WITH(load_with({"impedance.reference=extrapolate"}),
                    Catch::Contains("impedance.reference") && Catch::Contains("hold, interpolate"));
}

TEST_CASE("impedance parameters: a value out of range or a box inside out is refused by its key") {
  CHECK_THROWS_WITH(
      load_with({"impedance.limits.tau_rate_max_nm_per_s=2000"}),
      Catch::Contains("impedance.limits.tau_rate_max_nm_per_s") && Catch::Contains("1000"));
  CHECK_THROWS_WITH(
      load_with({"impedance.limits.workspace_max_m=[0.8, -0.4, 0.4]"}),
      Catch::Contains("impedance.limits.workspace_max_m") && Catch::Contains("workspace_min_m"));
  CHECK_THROWS_WITH(load_with({"impedance.gains.q_null_space_rad=[0, 0]"}),
                    Catch::Contains("impedance.gains.q_null_space_rad"));
}

TEST_CASE("impedance parameters: a key that nobody knows is refused") {
  config::Section section = config::Document::parse("rate_hz: 1000\nstifness: 3\n", "typo.yaml");
  CHECK_THROWS_AS(load_parameters(section, config::load_robot("panda")), config::ConfigError);
}

}  // namespace
