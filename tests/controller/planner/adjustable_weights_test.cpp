#include "controller/planner/adjustable_weights.hpp"

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "config/scenario.hpp"
#include "controller/planner/planner.hpp"
#include "controller/planner/strategy/surface_samples.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Catch::Contains;
using Eigen::Vector3d;

namespace {

Parameters parameters(const std::string& scenario, std::vector<std::string> overrides) {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/" + scenario + ".yaml",
                               overrides)
      .planner;
}

Parameters adjustable(const std::string& scenario = "circle_slow") {
  return parameters(scenario, {"planner.weights.adjustable_by=10"});
}

std::string refused(const NamedWeights& wanted) {
  return refusal(wanted, adjustable_weights(adjustable()));
}

/// A body that stays where it is, and an arm that is where the plan has it.
struct Table {
  explicit Table(const Parameters& p) : planner(p), rate(p.rate) {
    input.state_age = 0.0;
    input.target = ScenarioTarget{};
    input.effector.p_WE << 0.55, -0.1, 0.12;
    input.solve_time = 0.002;
    input.bodies[0].seen = true;
    input.bodies[0].age = 0.0;
    scene::Body& body = input.bodies[0].body;
    body.shape = make_model(p.model)->layout().world.body(0).shape;
    body.p_WB << 0.55, 0.1, p.geometry.table_height + extent(body, -Vector3d::UnitZ());
  }
  const Plan& step() {
    const Plan& plan = planner.step(input);
    input.now += 1.0 / rate;
    input.effector.v_WE = plan.v_WE;
    input.effector.p_WE = plan.p_WE;
    return plan;
  }
  /// Until C3 plans.
  void begin() {
    for (int i = 0; i < 3000; ++i) {
      if (step().mode == Mode::kTask && planner.step(input).u_c3.norm() > 0.0) return;
    }
    FAIL("C3 never planned: ");
  }
  Planner planner;
  double rate;
  planner::Input input{};
};

}  // namespace

TEST_CASE("adjustable weights: all of every phase, each within the scenario's factor of its own") {
  std::set<std::string> names;
  for (const AdjustableWeight& weight : adjustable_weights(adjustable())) {
    CAPTURE(weight.name);
    CHECK(names.insert(weight.name).second);
    CHECK(weight.value > 0.0);
    CHECK(weight.min == Approx(weight.value / 10.0));
    CHECK(weight.max == Approx(std::min(weight.value * 10.0, 1e12)));
  }
  // circle_slow: Q of four blocks that weigh something in Phase I and of five in Phase II, R, G of
  // seven, U of three
  CHECK(names.size() == (4 + 1 + 7 + 3) + (5 + 1 + 7 + 3));
  CHECK(names.count("roll.Q.ball_xy") == 1);
  CHECK(names.count("roll.Q.ball_z") == 0);  // it is 0
  CHECK(names.count("return.Q.ball_z") == 1);
  CHECK(names.count("return.G.table_tangential") == 1);
}

TEST_CASE("adjustable weights: a strategy that pushes has those of pushing") {
  const std::vector<AdjustableWeight> all = adjustable_weights(adjustable("push_box"));
  REQUIRE_FALSE(all.empty());
  for (const AdjustableWeight& weight : all) CHECK_THAT(weight.name, Catch::StartsWith("push."));
}

TEST_CASE("adjustable weights: a scenario that does not say so allows none") {
  const auto none = adjustable_weights(parameters("circle_slow", {}));
  CHECK(none.empty());
  CHECK_THAT(refusal({{"roll.R", 0.02}}, none),
             Contains("expected a scenario with planner.weights.adjustable_by"));
  CHECK_FALSE(refusal({}, none).empty());
}

TEST_CASE("adjustable weights: what cannot be taken is named with what was expected") {
  CHECK(refused({}).empty());
  CHECK(refused({{"roll.R", 0.02}, {"return.Q.ball_z", 3.0}}).empty());
  CHECK(refused({{"roll.R", 0.2}}) == "roll.R: expected a number in [0.001, 0.1], got 0.2");
  CHECK(refused({{"roll.R", std::nan("")}}) ==
        "roll.R: expected a number in [0.001, 0.1], got nan");
  CHECK(refused({{"roll.R", -0.01}}) == "roll.R: expected a number in [0.001, 0.1], got -0.01");
  CHECK_THAT(refused({{"roll.Q.ball", 1.0}}),
             Contains("expected a weight such as roll.Q.ball_velocity, roll.Q.ball_xy, ") &&
                 Contains("got \"roll.Q.ball\""));
  CHECK_THAT(refused({{"", 1.0}}), Contains("expected a weight such as "));
}

TEST_CASE("adjustable weights: of a list each has its number") {
  const Parameters p = parameters(
      "two_balls", {"planner.weights.adjustable_by=2", "planner.weights.roll.Q.ball_xy=[3, 5]"});
  std::set<std::string> names;
  for (const AdjustableWeight& weight : adjustable_weights(p)) names.insert(weight.name);
  CHECK(names.count("roll.Q.ball_xy.0") == 1);
  CHECK(names.count("roll.Q.ball_xy.1") == 1);
  CHECK(with_weights(p, {{"roll.Q.ball_xy.1", 7.0}}).roll.Q.at("ball_xy") ==
        std::vector<double>{3.0, 7.0});
}

TEST_CASE("adjustable weights: with other weights a planner plans as one that was made with them") {
  for (const std::string scenario : {"circle_slow", "push_box"}) {
    CAPTURE(scenario);
    const Parameters own = adjustable(scenario);
    NamedWeights weights;
    for (const AdjustableWeight& weight : adjustable_weights(own)) {
      if (weight.name.find(".Q.") != std::string::npos) weights[weight.name] = 3.0 * weight.value;
      if (weight.name.find(".R") != std::string::npos) weights[weight.name] = 0.5 * weight.value;
    }
    const Parameters others = with_weights(own, weights);
    Table changed(own), kept(own);
    changed.begin();
    kept.begin();
    const Vector3d before = changed.planner.step(changed.input).u_c3;
    REQUIRE(kept.planner.step(kept.input).u_c3 == before);
    changed.planner.set_weights(others);
    const Vector3d after = changed.planner.step(changed.input).u_c3;
    CHECK(after != kept.planner.step(kept.input).u_c3);
    // a planner that had them all the while, at the same place of its task
    Table made(others);
    made.planner.set_weights(own);
    made.begin();
    made.planner.step(made.input);
    made.planner.set_weights(others);
    CHECK(made.planner.step(made.input).u_c3 == after);
    changed.planner.set_weights(own);
    CHECK(changed.planner.step(changed.input).u_c3 == kept.planner.step(kept.input).u_c3);
  }
}
