// The closed loops reproduce what independent re-implementations of the published examples gave.
#include <catch2/catch.hpp>

#include "controller/example/closed_loop.hpp"
#include "controller/example/load_experiment.hpp"

using namespace c3rt;
using example::Experiment;
using example::Trajectory;

namespace {

Experiment scenario(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return example::load_experiment(config::Document::load(
      C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml", overrides));
}

Trajectory run(const Experiment& experiment, int trial = 0) {
  example::C3Controller controller(experiment);
  example::LcsPlant plant(experiment);
  return example::run(experiment, 1, trial, controller, plant);
}

}  // namespace

TEST_CASE("cart-pole: the mean cost-to-go of Table III with the LCP projection") {
  const Trajectory run_lcp = run(scenario("cart_pole"));
  REQUIRE(run_lcp.controller_failures == 0);
  // an exact KKT solution with the published data gives 22.0857; the paper says 22.09
  CHECK(run_lcp.cost_to_go.mean() == Approx(22.0857).epsilon(1e-4));
  const Eigen::Vector4d after_one(0.303, 0, 0.31297, 0.03040);
  const Eigen::Vector4d after_hundred(0.11240, -0.03194, -0.39124, -0.06204);
  CHECK((run_lcp.x.col(1) - after_one).cwiseAbs().maxCoeff() < 6e-6);
  CHECK((run_lcp.x.col(100) - after_hundred).cwiseAbs().maxCoeff() < 6e-6);
  CHECK(run_lcp.succeeded);
}

TEST_CASE("cart-pole: the mean cost-to-go of Table III with the exact MIQP projection") {
  const Trajectory run_miqp = run(scenario("cart_pole", {"c3.projection=miqp"}));
  REQUIRE(run_miqp.controller_failures == 0);
  CHECK(run_miqp.cost_to_go.mean() == Approx(24.921).epsilon(1e-4));  // the paper: 24.98
  CHECK(run_miqp.succeeded);
}

TEST_CASE("pivoting: the accumulated cost of the published equations") {
  const Trajectory published =
      run(scenario("pivoting", {"model.equations=as_published", "control.duration_s=1.5",
                                "c3.start=carried_forces"}));
  REQUIRE(published.controller_failures == 0);
  CHECK(published.cost.tail(1)[0] == Approx(1.2332e5).epsilon(1e-4));  // the paper: 1.217e5
  const Trajectory corrected =
      run(scenario("pivoting", {"control.duration_s=1.5", "c3.start=carried_forces"}));
  CHECK(corrected.cost.tail(1)[0] == Approx(1.175e5).epsilon(1e-3));
}

TEST_CASE("finger gaiting: the accumulated cost with the settings of Table I") {
  const Trajectory table1 = run(scenario(
      "finger_gaiting", {"control.duration_s=2", "c3.admm_iterations=5", "c3.rho_scale=1.01",
                         "start.x0=[-8, 0, 3, 0, 4, 0]", "start.spread_max=[0, 0, 0, 0, 0, 0]"}));
  REQUIRE(table1.controller_failures == 0);
  CHECK(table1.cost.tail(1)[0] == Approx(5.476e7).epsilon(1e-2));
}
