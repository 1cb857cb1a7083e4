#include "controller/planner/strategy/sampling.hpp"

#include <cstring>
#include <vector>

#include <catch2/catch.hpp>

#include "config/scenario.hpp"
#include "controller/planner/planner.hpp"
#include "controller/planner/strategy/surface_samples.hpp"
#include "controller/rt/worker_pool.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;

namespace {

Parameters parameters(const std::string& scenario, const std::vector<std::string>& overrides = {}) {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/" + scenario + ".yaml",
                               overrides)
      .planner;
}

/// Bodies that stay where they are put, and an arm that is where the plan has it.
struct Table {
  explicit Table(const Parameters& p, const c3::Parallel& parallel = {})
      : parameters(p), model(make_model(p.model)), planner(p, parallel) {
    const scene::Scene& world = model->layout().world;
    input.state_age = 0.0;
    input.effector.p_WE << 0.55, 0.0, 0.12;
    input.target = ScenarioTarget{};
    for (int i = 0; i < p.model.bodies; ++i) {
      scene::Body& body = put(i);
      body.shape = world.body(i).shape;
      body.p_WB.z() = p.geometry.table_height + extent(body, -Vector3d::UnitZ());
    }
  }
  scene::Body& put(int body) {
    BodyInput& of = input.bodies[static_cast<std::size_t>(body)];
    of.seen = true;
    of.age = 0.0;
    return of.body;
  }
  void put(int body, const Eigen::Vector2d& at, double yaw) {
    put(body).p_WB.head<2>() = at;
    put(body).q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  }
  const Plan& step() {
    const Plan& plan = planner.step(input);
    input.now += 1.0 / parameters.rate;
    input.effector.v_WE = (plan.p_WE - input.effector.p_WE) * parameters.rate;
    input.effector.p_WE = plan.p_WE;
    return plan;
  }
  /// Until it pushes. @return whether it does within the time
  bool pushes(double time) {
    for (int i = 0; i < time * parameters.rate; ++i) {
      if (step().phase == std::string("push")) return true;
    }
    return false;
  }

  Parameters parameters;
  std::unique_ptr<model::PlanningModel> model;  // whose shapes the bodies have
  Planner planner;
  planner::Input input{};
};

constexpr double kYaws[] = {0.0, 0.8};
const Eigen::Vector2d kGoals[] = {{0.6, 0.12}, {0.5, -0.14}};

}  // namespace

TEST_CASE("sampling: of several bodies it works at the one that is not at its goal") {
  for (const int away : {0, 1}) {
    CAPTURE(away);
    Table table(parameters("two_objects"));
    table.put(away, kGoals[away] - Eigen::Vector2d(0.08, 0.0), kYaws[away]);
    table.put(1 - away, kGoals[1 - away], kYaws[1 - away]);
    REQUIRE(table.pushes(10.0));
    const Plan& plan = table.planner.step(table.input);
    CHECK(plan.body == away);
    CHECK((plan.body_target.head<2>() - kGoals[away]).norm() < 1e-12);
    // from behind, as it has to go along x
    scene::Scene alone;
    alone.effector.radius = table.parameters.geometry.end_effector_radius;
    alone.body_count = 1;
    alone.body(0) = table.put(away);
    const scene::Gap gap = nearest_gap(alone, table.input.effector.p_WE);
    CHECK(gap.distance < 0.03);
    CHECK(gap.normal.x() < 0.0);
  }
}

TEST_CASE("sampling: one body settles and the next one's turn comes, then all are at rest") {
  Table table(parameters("two_objects"));
  table.put(0, kGoals[0] - Eigen::Vector2d(0.05, 0.0), kYaws[0]);
  table.put(1, kGoals[1] + Eigen::Vector2d(0.05, 0.0), kYaws[1]);
  REQUIRE(table.pushes(10.0));
  const int first = table.planner.step(table.input).body, other = 1 - first;
  table.put(first, kGoals[first] + Eigen::Vector2d(0.001, 0.0), kYaws[first]);
  CHECK(table.step().phase == std::string("choose"));
  REQUIRE(table.pushes(10.0));
  CHECK(table.planner.step(table.input).body == other);
  // what it has brought there stays settled while it is within the tolerances
  table.put(first, kGoals[first] + Eigen::Vector2d(0.004, 0.0), kYaws[first]);
  CHECK(table.step().body == other);
  table.put(other, kGoals[other], kYaws[other]);
  CHECK(table.step().phase == std::string("stand"));
  for (int i = 0; i < 1.1 * table.parameters.rate; ++i) table.step();
  const Plan& done = table.step();
  CHECK(done.mode == Mode::kHold);
  CHECK(table.planner.activity().cause == Cause::kAtTarget);
}

TEST_CASE("sampling: one that was brought away from its goal is worked at again") {
  Table table(parameters("two_objects"));
  table.put(0, kGoals[0], kYaws[0]);
  table.put(1, kGoals[1] + Eigen::Vector2d(0.05, 0.0), kYaws[1]);
  REQUIRE(table.pushes(10.0));
  table.put(1, kGoals[1], kYaws[1]);
  table.put(0, kGoals[0] + Eigen::Vector2d(0.0, 0.02), kYaws[0]);
  REQUIRE(table.pushes(10.0));
  CHECK(table.planner.step(table.input).body == 0);
}

TEST_CASE("sampling: whatever the number of threads, the plans are the same to the last bit") {
  // what is seen of the bodies wanders, so that every stage comes: choosing, moving and pushing
  const auto hash_with = [](const std::string& scenario, int threads) {
    rt::WorkerPool pool(threads);
    Table table(parameters(scenario), {&rt::WorkerPool::run_on, &pool, threads});
    table.put(0, {0.5, 0.1}, 1.0);
    if (table.parameters.model.bodies > 1) table.put(1, {0.52, -0.12}, 0.2);
    std::uint64_t hash = 14695981039346656037ull;
    const auto add = [&](const void* of, std::size_t size) {
      const auto* bytes = static_cast<const unsigned char*>(of);
      for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
    };
    int pushes = 0;
    for (int i = 0; i < 250; ++i) {
      const Plan& plan = table.step();
      pushes += plan.phase == std::string("push") ? 1 : 0;
      add(plan.p_WE.data(), sizeof(double) * 3);
      add(plan.x.data(), sizeof(double) * static_cast<std::size_t>(plan.x.size()));
      add(plan.lambda.data(), sizeof(double) * static_cast<std::size_t>(plan.lambda.size()));
    }
    CHECK(pushes > 20);
    return hash;
  };
  for (const char* scenario : {"push_t", "two_objects"}) {
    CAPTURE(scenario);
    const std::uint64_t alone = hash_with(scenario, 1);
    for (const int threads : {2, 4}) CHECK(hash_with(scenario, threads) == alone);
  }
}

TEST_CASE("sampling: the run's seed decides the places, and another one draws others") {
  const auto first_place = [](std::uint64_t seed) {
    Table table(seeded(parameters("push_t"), seed));
    table.put(0, {0.5, 0.1}, 1.0);
    REQUIRE(table.pushes(10.0));
    return table.input.effector.p_WE;
  };
  CHECK(first_place(3) == first_place(3));
  CHECK(first_place(3) != first_place(4));
}

TEST_CASE("sampling: a place that is left before the body has come nearer is not tried again") {
  Table table(parameters("push_t"));
  table.put(0, {0.5, 0.1}, 1.0);  // and there it stays, whatever is done
  std::vector<Vector3d> places;
  bool pushed = false;
  for (int i = 0; i < 30.0 * table.parameters.rate && places.size() < 8; ++i) {
    const Vector3d before = table.input.effector.p_WE;
    const bool pushes = table.step().phase == std::string("push");
    if (pushes && !pushed) {
      for (const Vector3d& other : places) {
        CAPTURE(places.size(), before.transpose(), other.transpose());
        CHECK((before - other).norm() > 0.01);
      }
      places.push_back(before);
    }
    pushed = pushes;
  }
  CHECK(places.size() >= 4);
}

TEST_CASE("sampling: a body that is tilted is let go") {
  Table table(parameters("push_t"));
  table.put(0, {0.5, 0.1}, 1.0);
  REQUIRE(table.pushes(10.0));
  const Eigen::Quaterniond flat = table.put(0).q_WB;
  const auto tilt = [&](double angle) {
    table.put(0).q_WB = Eigen::AngleAxisd(angle, Vector3d::UnitX()) * flat;
  };
  tilt(0.07);
  CHECK(table.step().phase == std::string("push"));
  tilt(0.15);
  CHECK(table.step().phase != std::string("push"));
}

TEST_CASE("sampling: what promises nothing from where the end effector is, is left soon") {
  Table table(parameters("push_t"));
  table.put(0, {0.4, 0.0}, 0.0);
  REQUIRE(table.pushes(10.0));
  // as far from its goal as before, so that it could still come nearer in time
  table.put(0, {0.7, 0.0}, 0.0);
  int pushed = 0;
  while (pushed < 100 && table.step().phase == std::string("push")) ++pushed;
  const double patience = 0.1;  // [s]
  CHECK(pushed >= 2);
  CHECK(pushed <= patience * table.parameters.rate + 1);
  CHECK(pushed < 0.5 * table.parameters.sampling.least_time * table.parameters.rate);
}

TEST_CASE("sampling: a body is let go before it is pushed out of reach") {
  Table table(parameters("push_t", {"task.goals_m=[[0.7, 0.0]]"}));
  table.put(0, {0.55, 0.0}, 0.0);
  REQUIRE(table.pushes(10.0));
  // the same, where the reach ends
  Parameters near = table.parameters;
  near.approach.reach_max.x() = 0.5505;
  Table edge(near);
  edge.put(0, {0.55, 0.0}, 0.0);
  edge.input.effector = table.input.effector;
  int pushed = 0;
  for (int i = 0; i < 3.0 * near.rate; ++i)
    pushed += edge.step().phase == std::string("push") ? 1 : 0;
  CHECK(pushed < 0.4 * near.rate);  // of 3 s, where it only turns
  CHECK(edge.planner.activity().cause == Cause::kNone);
}
