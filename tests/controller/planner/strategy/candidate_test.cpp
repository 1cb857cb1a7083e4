#include "controller/planner/strategy/candidate.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "config/scenario.hpp"
#include "controller/lcs/step.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Parameters parameters() {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/push_box.yaml", {}).planner;
}

/// The box of the scenario on its table, and the end effector beside it.
scene::Scene scene_of(const model::PlanningModel& model, const Vector3d& beside) {
  scene::Scene scene = model.layout().world;
  scene.body(0).p_WB << 0.5, 0.0, scene.table_height + scene.body(0).shape.half_sizes.z();
  scene.effector.p_WE = scene.body(0).p_WB + beside;
  return scene;
}

scene::Scene wanted_of(const scene::Scene& from) {
  scene::Scene wanted = from;
  wanted.body(0).p_WB.x() += 0.1;
  return wanted;
}

std::vector<scene::Scene> stages(const Parameters& p, const scene::Scene& wanted) {
  return std::vector<scene::Scene>(static_cast<std::size_t>(p.N) + 1, wanted);
}

}  // namespace

TEST_CASE("candidate: its cost is that of the objects as the end effector tries the plan") {
  const Parameters p = parameters();
  Candidate candidate(p, p.sampling.servo);
  const model::PlanningModel& model = candidate.c3().model();
  const c3::Costs costs = costs_of(candidate.c3().problem(), p.sampling.weights);
  const scene::Scene from = scene_of(model, {-0.08, 0.01, 0.0}), wanted = wanted_of(from);
  const Worth worth = candidate.worth(costs, from, stages(p, wanted));
  REQUIRE(worth.known);

  // step by step, the servo's force found by fixed-point iteration on the system as it is
  C3Controller c3(p);
  c3.start_from_free_gaps(0.03);
  const int name = c3.add_costs(costs);
  for (int k = 0; k <= p.N; ++k) c3.want(k, wanted, from);
  REQUIRE(c3.plan(from, name, {}) == StepStatus::kOk);
  const c3::Solution& plan = *c3.result().solution;
  const model::Layout& layout = model.layout();
  lcs::Lemke lemke(c3.n_lambda());
  VectorXd x(c3.n_x()), goal(c3.n_x()), next(c3.n_x()), lambda(c3.n_lambda());
  model.state(from, x);
  model.state_about(wanted, from, goal);
  const auto cost_of = [&](const VectorXd& state) {
    double cost = 0.0;
    for (const model::StateBlock& block : layout.x) {
      if (block.body < 0) continue;
      const double weight = p.sampling.weights.Q.at(block.name).front();
      cost += weight * (state - goal).segment(block.start, block.size).squaredNorm();
    }
    return cost;
  };
  double cost = 0.0, still = 0.0;
  const VectorXd x_0 = x;
  for (int k = 1; k <= p.N; ++k) {
    const VectorXd planned = k < p.N ? VectorXd(plan.z.col(k).head(c3.n_x())) : plan.x_N;
    Vector3d u = Vector3d::Zero();
    for (int i = 0; i < 3000; ++i) {
      REQUIRE(lcs::step(c3.planning_system(), x, u, lemke, next, lambda).ok());
      const Vector3d law = p.sampling.servo.stiffness * (planned - next).segment<3>(layout.p_WE) +
                           p.sampling.servo.damping * (planned - next).segment<3>(layout.v_WE);
      u += 0.05 * (law - u);
    }
    x = next;
    cost += cost_of(x);
    still += cost_of(x_0);
  }
  CHECK(worth.cost == Approx(cost).epsilon(1e-4));
  CHECK(worth.still == Approx(still));
}

TEST_CASE("candidate: behind the object is worth more than beside it, and before it nothing") {
  const Parameters p = parameters();
  Candidate candidate(p, p.sampling.servo);
  const c3::Costs costs = costs_of(candidate.c3().problem(), p.sampling.weights);
  const auto gain = [&](const Vector3d& beside) {
    const scene::Scene from = scene_of(candidate.c3().model(), beside);
    return candidate.worth(costs, from, stages(p, wanted_of(from))).gain();
  };
  const double behind = gain({-0.08, 0.0, 0.0});
  CHECK(behind > 0.0);
  CHECK(behind > 1.6 * gain({0.0, 0.08, 0.0}));
  CHECK(gain({0.08, 0.0, 0.0}) < 0.2 * behind);
  CHECK(gain({0.08, 0.0, 0.0}) == gain({0.08, 0.0, 0.0}));
}

TEST_CASE("candidate: a body that moves goes on alone where it is not touched") {
  const Parameters p = parameters();
  Candidate candidate(p, p.sampling.servo);
  const c3::Costs costs = costs_of(candidate.c3().problem(), p.sampling.weights);
  scene::Scene from = scene_of(candidate.c3().model(), {-0.3, 0.0, 0.0});
  from.body(0).v_WB.x() = 0.04;
  const scene::Scene wanted = wanted_of(from);
  double still = 0.0;
  for (int k = 1; k <= p.N; ++k) {
    const double left = 0.1 - 0.04 * k * p.dt;
    still += p.sampling.weights.Q.at("box_xy").front() * left * left;
  }
  CHECK(candidate.worth(costs, from, stages(p, wanted)).still == Approx(still));
}

TEST_CASE("candidate: a body that lies near another one is pushed off it, not drawn to it") {
  // a bar 17 mm from a cube that is at its goal, whose place counts as much as it can
  const Parameters p =
      config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/three_objects.yaml", {})
          .planner;
  Candidate candidate(p, p.sampling.servo);
  candidate.c3().start_from_free_gaps(0.03);
  scene::Scene from = candidate.c3().model().layout().world;
  const auto put = [&](int body, double x, double y, double yaw) {
    from.body(body).p_WB << x, y, from.table_height + 0.02;
    from.body(body).q_WB = Eigen::AngleAxisd(yaw, Vector3d::UnitZ());
  };
  put(0, 0.6, 0.152, 0.0);
  put(1, 0.602, -0.159, 0.82);
  put(2, 0.53, -0.082, -0.06);
  from.effector.p_WE << 0.527, -0.125, from.table_height + p.sampling.height;
  scene::Scene wanted = from;
  wanted.body(2).p_WB += Vector3d(-0.07, 0.07, 0.0);
  PhaseWeights weights = p.sampling.weights;
  for (const char* block : {"object_xy", "object_rotation"}) {
    const double weight = weights.Q.at(block).front();
    weights.Q.at(block) = {30.0 * weight, weight};  // the two nearest are in the model
  }
  const c3::Costs costs = costs_of(candidate.c3().problem(), weights);
  const Worth worth = candidate.worth(costs, from, stages(p, wanted));
  CHECK(worth.gain() > 0.05 * worth.still);
  const VectorXd planned = candidate.c3().result().solution->x_N - candidate.c3().x_hat();
  const model::Layout& layout = candidate.c3().model().layout();
  for (const model::StateBlock& block : layout.x) {
    if (block.body == 1 && block.name == "object_xy") {
      CHECK(planned[block.start] < 0.0);
      CHECK(planned[block.start + 1] > 0.0);
    }
  }
}

TEST_CASE("candidate: a place from which a body is pushed out of reach is worth nothing") {
  Parameters p = parameters();
  const auto worth_at = [&](double x) {
    Candidate candidate(p, p.sampling.servo);
    const c3::Costs costs = costs_of(candidate.c3().problem(), p.sampling.weights);
    scene::Scene from = scene_of(candidate.c3().model(), {-0.08, 0.0, 0.0});
    from.body(0).p_WB.x() += x - 0.5;
    from.effector.p_WE.x() += x - 0.5;
    return candidate.worth(costs, from, stages(p, wanted_of(from)));
  };
  const double end = p.approach.reach_max.x();
  CHECK(worth_at(end - 0.15).known);
  CHECK(worth_at(end - 0.15).gain() > 0.0);
  CHECK_FALSE(worth_at(end - 0.005).known);
  CHECK_FALSE(worth_at(end + 0.005).known);  // and not farther, where it lies outside
  p.approach.reach_max.x() += 0.2;
  CHECK(worth_at(end - 0.005).known);
}
