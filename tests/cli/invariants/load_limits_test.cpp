#include "cli/invariants/load_limits.hpp"

#include <cmath>
#include <string>

#include <catch2/catch.hpp>

using namespace c3rt;

namespace {

config::Scenario scenario(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return config::load_scenario(
      std::string(C3RT_SOURCE_DIRECTORY) + "/config/scenarios/" + name + ".yaml", overrides);
}

}  // namespace

TEST_CASE("limits: the robot's are those of its description, the workspace is the servo's") {
  const cli::invariants::Limits limits =
      cli::invariants::load_limits(scenario("circle_slow"), false);
  CHECK(limits.tau_max[0] == 87.0);
  CHECK(limits.tau_max[6] == 12.0);
  CHECK(limits.tau_rate_max == 1000.0);
  CHECK(limits.cycle == 1e-3);
  CHECK(limits.workspace_min.x() == Approx(0.3));
  CHECK(limits.workspace_max.z() == Approx(0.4));
  CHECK_FALSE(limits.realtime);
}

TEST_CASE("limits: an object's is what a criterion says of every instant, none where none does") {
  CHECK(cli::invariants::load_limits(scenario("circle_slow"), true).object_error == 0.02);
  const auto loose = scenario("circle_slow", {"criteria.2.min=0.9"});
  CHECK(std::isinf(cli::invariants::load_limits(loose, true).object_error));
}
