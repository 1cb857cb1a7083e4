// What a strategy can be: those of the registry, one that compares plans, and one that fails.
#include "controller/planner/strategy/strategy.hpp"

#include <limits>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "config/scenario.hpp"
#include "controller/planner/planner.hpp"
#include "controller/planner/strategy/registry.hpp"
#include "controller/planner/strategy/time_heuristic.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;

namespace {

const Vector3d kBody(0.55, 0.1, -0.0245 + 0.0315);

Parameters parameters(const std::vector<std::string>& overrides = {}) {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml",
                               overrides)
      .planner;
}

Input input_at(double now, const Vector3d& p_WE) {
  Input input{};
  input.now = now;
  input.state_age = 0.0;
  input.effector.p_WE = p_WE;
  input.effector.v_WE.setZero();
  input.bodies[0] = {true, 0.0, {kBody}};
  input.solve_time = 0.002;
  return input;
}

/// Tries places about the body, asks C3 for a plan from each, and plans from the cheapest: what a
/// sampling strategy needs of the interface.
class Sampler final : public Strategy {
 public:
  Sampler(const Parameters& parameters, C3Controller& c3)
      : parameters_(parameters), costs_(c3.add_costs(costs_of(c3.problem(), parameters.roll))) {
    decision_.desired.resize(static_cast<std::size_t>(parameters.N) + 1);
  }
  void reset() override { plans = 0; }
  const Decision& decide(const Situation& now, C3Controller& c3) override {
    scene::Scene wanted = now.scene;
    wanted.body(0).p_WB.x() += 0.02;
    wanted.effector.p_WE = now.scene.body(0).p_WB + Vector3d(0.0, 0.0, 0.06);
    for (int k = 0; k <= parameters_.N; ++k) {
      decision_.desired[static_cast<std::size_t>(k)] = wanted;
      c3.want(k, wanted, now.scene);
    }
    double best = std::numeric_limits<double>::infinity();
    for (const Vector3d& offset : {Vector3d(-0.055, 0.0, 0.0), Vector3d(0.055, 0.0, 0.0)}) {
      scene::Scene candidate = now.scene;
      candidate.effector.p_WE = now.scene.body(0).p_WB + offset;
      if (c3.plan(candidate, costs_, {}) == StepStatus::kFailed) continue;
      ++plans;
      const double cost = c3.result().u_c3.squaredNorm();
      if (cost < best) {
        best = cost;
        place = candidate.effector.p_WE;
      }
    }
    decision_.plans_with_c3 = (now.scene.effector.p_WE - place).norm() < 0.01;
    decision_.mode = decision_.plans_with_c3 ? Mode::kTask : Mode::kApproach;
    decision_.phase = "best of the places";
    decision_.p_WE = place;
    decision_.x_hat = now.scene;
    decision_.costs = costs_;
    return decision_;
  }
  int plans = 0;
  Vector3d place = Vector3d::Zero();

 private:
  Parameters parameters_;
  int costs_;
  Decision decision_;
};

std::unique_ptr<Strategy> make_sampler(const Parameters& parameters, C3Controller& c3) {
  return std::make_unique<Sampler>(parameters, c3);
}

/// Throws in every second period.
class Faulty final : public Strategy {
 public:
  void reset() override {}
  const Decision& decide(const Situation& now, C3Controller&) override {
    if (++periods_ % 2 == 0) throw std::runtime_error("a strategy that is wrong");
    decision_.mode = Mode::kHold;
    decision_.p_WE = now.input->effector.p_WE;
    return decision_;
  }

 private:
  int periods_ = 0;
  Decision decision_;
};

/// A model in which no force moves anything: D = 0.
class Immovable final : public model::PlanningModel {
 public:
  explicit Immovable(std::unique_ptr<model::PlanningModel> of)
      : PlanningModel(of->layout()), of_(std::move(of)) {}
  void state(const scene::Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const override {
    of_->state(scene, x);
  }
  void evaluate(const scene::Scene& scene, const std::vector<int>& contacts,
                model::ContactSystem& system) const override {
    of_->evaluate(scene, contacts, system);
    system.M_inverse.setZero();
  }

 private:
  std::unique_ptr<model::PlanningModel> of_;
};

}  // namespace

TEST_CASE("strategy: the scenario names it, and one that there is not is refused with the names") {
  CHECK(parameters().strategy == "time_heuristic");
  for (const StrategyKind& kind : strategy_kinds()) {
    Parameters p = parameters();
    p.strategy = kind.name;
    p.sampling.weights = p.roll;  // as a scenario with it has
    CHECK_NOTHROW(Planner(p));
  }
  CHECK_THROWS_WITH(strategy_kind("chess"),
                    "strategy: expected one of time_heuristic, sampling, hold, got \"chess\"");
}

TEST_CASE("strategy: hold stays where the arm is, out of the way, and answers a lost state") {
  Parameters p = parameters();
  p.strategy = "hold";
  Planner planner(p);
  Vector3d p_WE(0.5, -0.1, 0.12);
  double now = 0.0;
  for (int i = 0; i < 300; ++i, now += 1.0 / p.rate) {
    const Plan& plan = planner.step(input_at(now, p_WE));
    REQUIRE(plan.mode == Mode::kHold);
    REQUIRE(plan.status == PlanStatus::kOk);
    CHECK(plan.p_WE.head<2>() == Vector3d(0.5, -0.1, 0.0).head<2>());
    p_WE = plan.p_WE;
  }
  CHECK(planner.activity().cause == Cause::kAsked);
  Input lost = input_at(now, p_WE);
  lost.state_age = 1.0;
  CHECK(planner.step(lost).mode == Mode::kWait);
}

TEST_CASE("strategy: one that compares several plans and moves to the best place fits") {
  const Parameters p = parameters();
  Planner planner(p, make_sampler);
  const Plan& away = planner.step(input_at(0.0, {0.4, 0.0, 0.1}));
  CHECK(away.mode == Mode::kApproach);
  const Vector3d place = away.p_WE;
  CHECK((place - kBody).norm() == Approx(0.055));
  const Plan& there = planner.step(input_at(0.005, place));
  CHECK(there.mode == Mode::kTask);
  CHECK(there.phase == std::string("best of the places"));
  CHECK(there.status == PlanStatus::kOk);
  CHECK(there.admm_iterations == p.c3.admm_iterations);
}

TEST_CASE("strategy: one that throws gives a fallback plan at the arm, is counted and named") {
  Planner planner(parameters(), [](const Parameters&, C3Controller&) -> std::unique_ptr<Strategy> {
    return std::make_unique<Faulty>();
  });
  const Vector3d p_WE(0.5, 0.0, 0.1);
  CHECK(planner.step(input_at(0.0, p_WE)).status == PlanStatus::kOk);
  const Plan& plan = planner.step(input_at(0.005, p_WE));
  CHECK(plan.status == PlanStatus::kFallback);
  CHECK(plan.mode == Mode::kHold);
  CHECK(plan.p_WE == p_WE);
  CHECK(plan.v_WE.isZero());
  CHECK(planner.counters().failures == 1);
  CHECK(std::string(planner.failure()) == "a strategy that is wrong");
  CHECK(planner.step(input_at(0.010, p_WE)).status == PlanStatus::kOk);
}

TEST_CASE("c3 controller: forces that move nothing (D = 0) are no plan, and nothing throws") {
  const Parameters p = parameters();
  C3Controller c3(p, std::make_unique<Immovable>(make_model(p.model)));
  const int costs = c3.add_costs(costs_of(c3.problem(), p.roll));
  scene::Scene scene;
  scene.body_count = 1;
  scene.body(0).p_WB = kBody;
  scene.effector.p_WE = kBody + Vector3d(0.0, 0.0, 0.06);
  for (int k = 0; k <= p.N; ++k) c3.want(k, scene, scene);
  CHECK(c3.step(scene, costs, 0.005, {}) == StepStatus::kFailed);
  CHECK(c3.result().solution == nullptr);
}

TEST_CASE("c3 controller: costs that cannot be used are refused, and the old ones stay") {
  const Parameters p = parameters();
  C3Controller c3(p);
  const int name = c3.add_costs(costs_of(c3.problem(), p.roll));
  scene::Scene scene;
  scene.body_count = 1;
  scene.body(0).p_WB = kBody;
  scene.effector.p_WE = kBody + Vector3d(0.0, 0.0, 0.055);
  scene::Scene wanted = scene;
  wanted.body(0).p_WB.x() += 0.03;
  for (int k = 0; k <= p.N; ++k) c3.want(k, wanted, scene);
  REQUIRE(c3.step(scene, name, 0.005, {}) == StepStatus::kOk);
  const Vector3d u = c3.result().u_c3;
  c3::Costs wrong = costs_of(c3.problem(), p.roll);
  wrong.R = c3::Costs{}.R;
  CHECK_THROWS_AS(c3.replace_costs(name, wrong), std::invalid_argument);
  REQUIRE(c3.step(scene, name, 0.005, {}) == StepStatus::kOk);
  CHECK(c3.result().u_c3 == u);
  c3.replace_costs(name, costs_of(c3.problem(), p.back));
  REQUIRE(c3.step(scene, name, 0.005, {}) == StepStatus::kOk);
  CHECK(c3.result().u_c3 != u);
}

TEST_CASE("time heuristic: after a reset it is as new") {
  const Parameters p = parameters();
  C3Controller c3(p);
  TimeHeuristic used(p, c3), fresh(p, c3);
  const auto modes = [&](TimeHeuristic& strategy) {
    std::vector<Mode> all;
    Vector3d p_WE(0.55, 0.05, 0.13);
    for (int i = 0; i < 900; ++i) {
      const Input input = input_at(i / p.rate, p_WE);
      Situation now{};
      now.input = &input;
      now.period = 1.0 / p.rate;
      now.available = available(p, input);
      now.scene = c3.model().layout().world;
      now.scene.effector.p_WE = p_WE;
      now.scene.body(0).p_WB = kBody;
      const Decision& decision = strategy.decide(now, c3);
      all.push_back(decision.mode);
      if (!decision.plans_with_c3) p_WE = decision.p_WE;
    }
    return all;
  };
  const std::vector<Mode> first = modes(used);
  CHECK(first.back() != first.front());
  CHECK(modes(used) != first);  // it goes on from where it was
  used.reset();
  CHECK(modes(used) == first);
  CHECK(modes(fresh) == first);
}

TEST_CASE("scenario: a strategy that is not chosen needs no sections, and no other name is taken") {
  const auto text = [&](const std::string& strategy) {
    return "name: held\ndescription: held\nextends: circle_slow\nplanner:\n  strategy: " +
           strategy + "\n  weights: ~\n  heuristic: ~\n";
  };
  CHECK(config::read_scenario(config::Document::parse(text("hold"), C3RT_SOURCE_DIRECTORY
                                                      "/config/scenarios/held.yaml"))
            .planner.strategy == "hold");
  CHECK_THROWS_WITH(
      config::read_scenario(config::Document::parse(
          text("time_heuristic"), C3RT_SOURCE_DIRECTORY "/config/scenarios/held.yaml")),
      Catch::Contains("planner.weights: missing, strategy time_heuristic needs it"));
  CHECK_THROWS_WITH(
      config::read_scenario(config::Document::parse(
          text("chess"), C3RT_SOURCE_DIRECTORY "/config/scenarios/held.yaml")),
      Catch::Contains(
          "planner.strategy: expected one of time_heuristic, sampling, hold, got \"chess\""));
}
