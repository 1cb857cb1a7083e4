#include "controller/example/load_experiment.hpp"

#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace c3rt;
using Catch::Matchers::Contains;

namespace {

example::Experiment load(const std::string& name, const std::vector<std::string>& overrides) {
  return example::load_experiment(config::Document::load(
      C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml", overrides));
}

}  // namespace

TEST_CASE("example scenario: weights without a Riccati solution are refused by their key") {
  CHECK_THROWS_AS(load("cart_pole", {"weights.R=[0]"}), config::ConfigError);
  CHECK_THROWS_WITH(load("cart_pole", {"weights.R=[0]"}),
                    Contains("weights.Q_N: expected weights with a stabilising solution, or Q, got "
                             "riccati: R: expected a positive definite matrix"));
}

TEST_CASE("example scenario: a QP step that cannot hold the constraints is refused by its key") {
  CHECK_THROWS_AS(load("finger_gaiting", {"c3.qp=direct"}), config::ConfigError);
  CHECK_THROWS_WITH(load("finger_gaiting", {"c3.qp=direct"}),
                    Contains("c3.qp: expected interior_point or osqp"));
  CHECK_NOTHROW(load("pivoting", {"c3.qp=direct"}));
}
