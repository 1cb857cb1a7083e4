#include "controller/planner/c3_controller.hpp"

#include <optional>
#include <string>

#include <catch2/catch.hpp>

#include "config/scenario.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;

namespace {

/// Of circle_slow with polish: rolls the ball to a place 3 cm beside where it is.
struct Rolling {
  explicit Rolling(int polish, const std::string& scenario = "circle_slow",
                   double planner_rate = 200.0) {
    parameters =
        config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/" + scenario + ".yaml", {})
            .planner;
    parameters.c3.polish = polish;
    parameters.rate = planner_rate;
    c3.emplace(parameters);
    costs = c3->add_costs(costs_of(c3->problem(), parameters.roll));
    x_hat = c3->model().layout().world;
    x_hat.body_count = parameters.model.bodies;
    x_hat.body(0).p_WB = Vector3d(0.55, 0.1, -0.0245 + 0.0315);
    x_hat.effector.p_WE = x_hat.body(0).p_WB + Vector3d(-0.01, 0.0, 0.0495);
    desired = x_hat;
    desired.body(0).p_WB.x() += 0.03;
    desired.effector.p_WE.x() += 0.03;
    for (int k = 0; k <= parameters.N; ++k) c3->want(k, desired, x_hat);
  }
  /// Cost of the polished plan of a step.
  double step() {
    REQUIRE(c3->step(x_hat, costs, 0.01, {}) == StepStatus::kOk);
    return c3->result().solution->polish.cost;
  }
  /// The same of a plan that is only compared with others.
  double plan() {
    REQUIRE(c3->plan(x_hat, costs, {}) == StepStatus::kOk);
    return c3->result().solution->polish.cost;
  }

  Parameters parameters;
  std::optional<C3Controller> c3;
  int costs = 0;
  scene::Scene x_hat, desired;
};

}  // namespace

TEST_CASE("c3 controller: polish goes on with the last step's plan") {
  Rolling rolling(8);
  const double first = rolling.step();
  REQUIRE(first < rolling.c3->result().solution->polish.cost_before);
  double cost = first;
  for (int i = 0; i < 10; ++i) {
    CAPTURE(i);
    const double next = rolling.step();
    CHECK(next <= cost * (1.0 + 1e-9));
    cost = next;
  }
  // more than the first one's QPs can do
  CHECK(cost < 0.999 * first);
}

TEST_CASE("c3 controller: a plan that is only compared, or follows no step, knows no other") {
  Rolling rolling(8);
  const double first = rolling.step();
  for (int i = 0; i < 5; ++i) (void)rolling.step();
  const double known = rolling.step();
  REQUIRE(known < first);
  CHECK(rolling.plan() == first);
  // and takes nothing from the steps
  CHECK(rolling.step() <= known * (1.0 + 1e-9));
  rolling.c3->forget_plan();
  CHECK(rolling.step() == first);
}

TEST_CASE("c3 controller: a plan of which less than half is left at the next period is forgotten") {
  // a stage is 0.1 s and there are five: two later more than half is left, three later less
  for (const double period : {0.2, 0.3}) {
    CAPTURE(period);
    Rolling rolling(8, "circle_slow", 1.0 / period);
    const double first = rolling.step();
    double cost = first;
    for (int i = 0; i < 5; ++i) cost = rolling.step();
    CHECK((cost == first) == (period > 0.25));
  }
}

TEST_CASE("c3 controller: without polish equal states give equal plans, whatever was before") {
  Rolling rolling(0);
  (void)rolling.step();
  const Eigen::MatrixXd z = rolling.c3->result().solution->z;
  for (int i = 0; i < 3; ++i) (void)rolling.step();
  CHECK(rolling.c3->result().solution->z == z);
}

TEST_CASE("c3 controller: of C3+ with contacts that begin free polish knows the last plan, too") {
  Rolling rolling(8, "circle_slow_plus");
  rolling.x_hat.effector.p_WE.z() += 0.03;
  rolling.c3->start_from_free_gaps(0.01);
  double cost = rolling.step();
  const double first = cost;
  for (int i = 0; i < 5; ++i) {
    const double next = rolling.step();
    CHECK(next <= cost * (1.0 + 1e-9));
    cost = next;
  }
  rolling.c3->forget_plan();
  CHECK(rolling.step() == first);
}
