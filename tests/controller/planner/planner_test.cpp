#include "controller/planner/planner.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include <catch2/catch.hpp>

#include "config/scenario.hpp"
#include "controller/model/ball_model.hpp"
#include "controller/task/line.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;

namespace {

const std::string kScenario = C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml";
const std::string kFast = C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_fast.yaml";

Parameters parameters(const std::vector<std::string>& overrides = {},
                      const std::string& scenario = kScenario) {
  return config::load_scenario(scenario, overrides).planner;
}

const Vector3d kBall(0.55, 0.1, -0.0245 + 0.0315);

double radius_of(const Parameters& p) { return p.model.values["ball_radius_m"]; }

Input input_at(double now, const Vector3d& p_WE) {
  Input input{};
  input.now = now;
  input.state_age = 0.0;
  input.effector.p_WE = p_WE;
  input.effector.v_WE.setZero();
  input.bodies[0] = {true, 0.0, {kBall}};
  input.solve_time = 0.002;
  return input;
}

/// Drives a planner whose plans are followed at once, from above the table to the ball.
struct Follower {
  explicit Follower(const Parameters& p) : planner(p), period(1.0 / p.rate) {}
  const Plan& step() {
    Input input = input_at(now, p_WE);
    input.effector.v_WE = v_WE;
    const Plan& plan = planner.step(input);
    now += period;
    p_WE = plan.p_WE;
    v_WE = plan.v_WE;
    return plan;
  }
  bool until(const std::string& phase, int periods) {
    for (int i = 0; i < periods; ++i) {
      if (step().phase == phase) return true;
    }
    return false;
  }
  Planner planner;
  double period, now = 0.0;
  Vector3d p_WE{0.55, -0.1, 0.04}, v_WE{0.0, 0.0, 0.0};
};

bool finite(const Plan& plan) {
  return plan.p_WE.allFinite() && plan.v_WE.allFinite() && plan.q_WE.coeffs().allFinite() &&
         plan.force_E.allFinite() && plan.u_c3.allFinite() && plan.lambda_d.allFinite();
}

}  // namespace

TEST_CASE("planner: without the robot's state it waits, and its plan is marked as no plan") {
  Planner planner(parameters());
  Input input = input_at(0.0, Vector3d::Zero());
  input.state_age = 1.0;
  const Plan& plan = planner.step(input);
  CHECK(plan.mode == Mode::kWait);
  CHECK(plan.status == PlanStatus::kFallback);
  CHECK(finite(plan));
}

TEST_CASE(
    "planner: the approach goes up, across and down, never faster than told and never through the "
    "ball") {
  const Parameters p = parameters();
  Follower follower(p);
  const double touching = radius_of(p) + p.geometry.end_effector_radius;
  Vector3d previous = follower.p_WE;
  double highest = 0.0;
  int periods = 0;
  while (follower.step().phase != std::string("return")) {
    REQUIRE(++periods < 2000);
    CHECK((follower.p_WE - previous).norm() <= p.approach.speed * follower.period + 1e-12);
    CHECK((follower.p_WE - kBall).norm() > touching);
    previous = follower.p_WE;
    highest = std::max(highest, follower.p_WE.z());
  }
  CHECK(highest ==
        Approx(p.geometry.table_height + p.approach.safe_height).margin(p.approach.tolerance));
  CHECK((previous - Vector3d(kBall + Vector3d(0, 0, p.approach.start_height))).norm() <
        p.approach.tolerance);
}

TEST_CASE(
    "planner: where the ball runs away Phase II begins at once, but not before it was touched") {
  Parameters p = parameters();
  p.heuristic.return_gap = 0.005;
  Planner planner(p);
  double now = 0.0;
  const double touching = radius_of(p) + p.geometry.end_effector_radius;
  // the end effector straight above the ball with a gap between them
  const auto phase_with_gap = [&](double gap) {
    const Vector3d p_WE = kBall + Vector3d(0.0, 0.0, touching + gap);
    now += 1.0 / p.rate;
    return std::string(planner.step(input_at(now, p_WE)).phase);
  };
  const double start_gap = p.approach.start_height - touching;
  while (phase_with_gap(start_gap) != "roll") REQUIRE(now < 10.0);
  for (int i = 0; i < 10; ++i) CHECK(phase_with_gap(0.010) == "roll");
  CHECK(phase_with_gap(0.001) == "roll");
  CHECK(phase_with_gap(0.004) == "roll");
  CHECK(phase_with_gap(0.006) == "return");
  // and takes its full time
  const double since = now;
  while (phase_with_gap(0.010) == "return") REQUIRE(now < since + 1.0);
  CHECK(now - since == Approx(p.heuristic.return_duration).margin(1.5 / p.rate));
}

TEST_CASE(
    "planner: a lost ball makes it hold out of the way, and a ball that is back is approached "
    "again") {
  const Parameters p = parameters();
  Follower follower(p);
  REQUIRE(follower.until("roll", 2000));
  Vector3d where = follower.p_WE;
  // it stands on the ball, which first comes to rest
  bool held = false;
  for (int i = 0; i < 600; ++i) {
    Input input = input_at(follower.now, where);
    follower.now += follower.period;
    input.bodies[0].seen = false;
    const Plan& plan = follower.planner.step(input);
    held = held || plan.mode == Mode::kHold;
    REQUIRE(plan.mode == (held ? Mode::kHold : Mode::kRest));
    if (held) {
      CHECK(plan.v_WE.isZero());
      CHECK(plan.force_E.isZero());
    }
    CHECK((plan.p_WE - where).norm() <= p.approach.speed * follower.period + 1e-12);
    where = plan.p_WE;
  }
  CHECK(where.z() == Approx(p.geometry.table_height + p.approach.safe_height));
  CHECK(follower.planner.counters().body_lost == 1);
  CHECK(follower.planner.step(input_at(follower.now, where)).mode == Mode::kApproach);
}

TEST_CASE("planner: a ball out of reach is waited for, not followed") {
  Planner planner(parameters());
  Input input = input_at(0.0, Vector3d(0.55, 0.0, 0.1));
  input.bodies[0].body.p_WB.x() = 0.9;
  CHECK(planner.step(input).mode == Mode::kHold);
  CHECK(planner.step(input_at(0.1, Vector3d(0.55, 0.0, 0.1))).mode == Mode::kApproach);
}

TEST_CASE("planner: numbers that are not finite count as not there") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Planner planner(parameters());
  Input input = input_at(0.0, Vector3d(0.55, 0.0, 0.1));
  input.bodies[0].body.v_WB.x() = nan;
  CHECK(planner.step(input).mode == Mode::kHold);
  input = input_at(0.1, Vector3d(0.55, 0.0, nan));
  const Plan& plan = planner.step(input);
  CHECK(plan.mode == Mode::kWait);
  CHECK(plan.status == PlanStatus::kFallback);
}

TEST_CASE(
    "planner: every plan of the heuristic's cycle is finite, solved, and keeps the speed limit") {
  const Parameters p = parameters();
  Follower follower(p);
  REQUIRE(follower.until("return", 2000));
  bool rolled = false;
  for (int i = 0; i < 300; ++i) {
    const Plan& plan = follower.step();
    REQUIRE(finite(plan));
    CHECK(plan.status == PlanStatus::kOk);
    CHECK(plan.v_WE.norm() <= p.speed_limit + 1e-12);
    CHECK(plan.admm_iterations == p.c3.admm_iterations);
    rolled = rolled || plan.phase == std::string("roll");
  }
  CHECK(rolled);
  CHECK(follower.planner.counters().fallbacks == 0);
}

TEST_CASE("planner: an end effector that slips off the ball returns at once, and rolls again") {
  Parameters p = parameters();
  p.heuristic.roll_reach = 0.03;
  p.heuristic.return_gap = std::numeric_limits<double>::infinity();
  Follower follower(p);
  REQUIRE(follower.until("roll", 2000));
  const Vector3d above = kBall + Vector3d(0.0, 0.0, 0.055);
  Input input = input_at(follower.now, above + Vector3d(0.9 * p.heuristic.roll_reach, 0.0, 0.0));
  CHECK(follower.planner.step(input).phase == std::string("roll"));
  input.now += follower.period;
  input.effector.p_WE = above + Vector3d(1.1 * p.heuristic.roll_reach, 0.0, -0.02);
  CHECK(follower.planner.step(input).phase == std::string("return"));
  // a whole Phase II, then the next Phase I
  input.effector.p_WE = above;
  const double slipped = input.now;
  while (input.now < slipped + p.heuristic.return_duration - 2.0 * follower.period) {
    input.now += follower.period;
    REQUIRE(follower.planner.step(input).phase == std::string("return"));
  }
  input.now += 3.0 * follower.period;
  CHECK(follower.planner.step(input).phase == std::string("roll"));
}

TEST_CASE(
    "planner: a planner that was away, or whose robot does not follow, begins anew at the arm") {
  for (const bool away : {false, true}) {
    CAPTURE(away);
    Follower follower(parameters());
    REQUIRE(follower.until("roll", 2000));
    const Vector3d here = kBall + Vector3d(0.01, 0.0, 0.052);
    Input input = input_at(follower.now, here);
    input.robot_follows = away;
    const int periods = away ? 1 : static_cast<int>(1.0 / follower.period);
    for (int k = 0; k < periods; ++k) {
      input.now += away ? 2.0 : follower.period;
      follower.planner.step(input);
    }
    const Plan& plan = follower.planner.step(input);
    CHECK(plan.mode == Mode::kApproach);
    CHECK((plan.p_WE - here).norm() < 1e-3);
    CHECK(plan.v_WE.norm() < 0.02);
  }
}

TEST_CASE("planner: the arm presses on the ball throughout Phase I, and only there") {
  Parameters p = parameters();
  Planner without(p);
  p.heuristic.roll_press = 3.0;
  Follower follower(p);
  int rolled = 0, returned = 0;
  for (int i = 0; i < 3000 && (rolled < 50 || returned < 50); ++i) {
    Input input = input_at(follower.now, follower.p_WE);
    input.effector.v_WE = follower.v_WE;
    const Plan plain = without.step(input);
    const Plan& plan = follower.step();
    REQUIRE(plan.mode == plain.mode);
    const Vector3d press(0.0, 0.0, plan.phase == std::string("roll") ? 3.0 : 0.0);
    REQUIRE((plan.force_E - plain.force_E - press).norm() < 1e-12);
    REQUIRE(plan.p_WE == plain.p_WE);
    rolled += plan.phase == std::string("roll") ? 1 : 0;
    returned += plan.phase == std::string("return") ? 1 : 0;
  }
  CHECK(rolled >= 50);
  CHECK(returned >= 50);
}

TEST_CASE("planner: the plan for the next instant respects the contact") {
  const Parameters p = parameters();
  Follower follower(p);
  REQUIRE(follower.until("roll", 2000));
  for (int i = 0; i < 50; ++i) {
    const Plan& plan = follower.step();
    using L = model::BallLayout;
    // Algorithm 3 gives a force only where the end effector touches the ball, and never one that
    // pulls
    CHECK(plan.lambda_d[L::normal_end_effector] >= 0.0);
    CHECK(plan.lambda_d[L::normal_table] >= 0.0);
    const double gap = (plan.p_WE - kBall).norm() - radius_of(p) - p.geometry.end_effector_radius;
    if (gap > 2e-3) CHECK(plan.lambda_d[L::normal_end_effector] == Approx(0.0).margin(1e-9));
  }
}

TEST_CASE(
    "planner: every projection, contact model and choice of contacts plans towards the ball") {
  struct Choice {
    std::vector<std::string> overrides;
    int n_lambda;
  };
  for (const Choice& choice :
       {Choice{{"planner.c3.projection=lcp"}, 12}, Choice{{"planner.c3.projection=admm"}, 12},
        Choice{{"planner.c3.projection=plus"}, 12},
        Choice{{"planner.c3.projection=convex", "planner.model.contact_model=anitescu"}, 8},
        Choice{{"planner.model.contact_model=anitescu"}, 8},
        Choice{{"planner.model.contacts.ball_table=false"}, 6}}) {
    Follower follower(parameters(choice.overrides));
    CAPTURE(choice.overrides.front());
    REQUIRE(follower.until("return", 2000));
    // where the QP pulls at the contacts the LCP has no solution: then the end effector stays
    const bool may_have_none = choice.overrides.front() == "planner.c3.projection=lcp";
    int ok = 0;
    for (int i = 0; i < 20; ++i) {
      const Plan& plan = follower.step();
      REQUIRE(finite(plan));
      ok += plan.status == PlanStatus::kOk;
      CHECK((plan.status == PlanStatus::kOk || may_have_none));
      CHECK(plan.lambda.rows() == choice.n_lambda);
      CHECK(plan.lambda_d.size() == model::BallLayout::n_lambda);
    }
    CHECK(ok > 0);
  }
}

TEST_CASE("planner: a deadline that strikes gives a truncated plan, not none") {
  Follower follower(parameters());
  REQUIRE(follower.until("roll", 2000));
  struct Count {
    int asked = 0;
    static bool reached(void* context) noexcept {
      return ++static_cast<Count*>(context)->asked > 1;
    }
  } count;
  const Plan& plan =
      follower.planner.step(input_at(follower.now, follower.p_WE), {&Count::reached, &count});
  CHECK(count.asked > 1);
  CHECK(plan.status == PlanStatus::kTruncated);
  CHECK(finite(plan));
  CHECK(follower.planner.counters().truncated == 1);
}

TEST_CASE(
    "planner: delta t_c is the mean of the last ten periods, or the time of the solve, as the "
    "scenario says") {
  for (const bool period : {true, false}) {
    Follower follower(
        parameters({period ? "planner.delta_t_c=period" : "planner.delta_t_c=solve_time"}));
    REQUIRE(follower.until("return", 2000));
    // nine regular periods and one of 30 ms
    follower.now += 0.030 - follower.period;
    const Plan& plan = follower.step();
    CHECK(plan.delta_t_c == Approx(period ? (9.0 * follower.period + 0.030) / 10.0 : 0.002));
  }
  // or what it was told
  Parameters p = parameters();
  p.delta_t_c = 0.02;
  Follower told(p);
  REQUIRE(told.until("return", 2000));
  CHECK(told.step().delta_t_c == 0.02);
}

TEST_CASE("planner: both back ends of the QP step give the same plan") {
  Follower direct(parameters({"planner.c3.qp=direct"})),
      osqp(parameters({"planner.c3.qp=osqp", "planner.c3.osqp.eps=1e-10",
                       "planner.c3.osqp.max_iterations=20000"}));
  REQUIRE(direct.until("roll", 2000));
  REQUIRE(osqp.until("roll", 2000));
  const Input input = input_at(direct.now, kBall + Vector3d(-0.02, 0.005, 0.05));
  const Plan a = direct.planner.step(input);
  Input same = input;
  same.now = osqp.now;
  const Plan& b = osqp.planner.step(same);
  REQUIRE(a.phase == std::string("roll"));
  REQUIRE(b.phase == std::string("roll"));
  CHECK((a.u_c3 - b.u_c3).norm() < 1e-5);
  CHECK((a.p_WE - b.p_WE).norm() < 1e-6);
}

TEST_CASE("planner: the same inputs give the same bits") {
  Follower a(parameters()), b(parameters());
  for (int i = 0; i < 500; ++i) {
    const Plan& plan_a = a.step();
    const Plan& plan_b = b.step();
    REQUIRE(plan_a.p_WE == plan_b.p_WE);
    REQUIRE(plan_a.u_c3 == plan_b.u_c3);
  }
}

TEST_CASE("planner: weights that cannot be used are refused at the start, by name") {
  Parameters p = parameters();
  p.roll.R = -1.0;
  CHECK_THROWS_WITH(Planner(p), Catch::Contains("Costs.R"));
}

TEST_CASE("planner: C3+ without a weight of its own for forces weighs them as G does") {
  Parameters p = parameters({"planner.c3.projection=plus"});
  const auto u_with = [&p](std::optional<double> g_lambda, double G_all, double g_eta_slip) {
    for (PhaseWeights* weights : {&p.roll, &p.back}) {
      auto& plus = weights->of_projections.at("plus");
      plus.erase("g_lambda");
      if (g_lambda) plus["g_lambda"] = {*g_lambda, *g_lambda, *g_lambda};
      plus.at("g_eta").slip = g_eta_slip;
      for (auto& [name, weight] : weights->G_lambda) weight = G_all;
    }
    Follower follower(p);
    REQUIRE(follower.until("roll", 2000));
    return Vector3d(follower.step().u_c3);
  };
  const Vector3d u = u_with(0.02, 0.005, 0.1);
  CHECK(u_with(std::nullopt, 0.02, 0.1) == u);
  CHECK(u_with(std::nullopt, 0.005, 0.1) != u);
  CHECK(u_with(0.02, 0.005, 0.2) != u);
}

TEST_CASE("planner: C3+'s final scale counts for all pairs of the contacts that are named") {
  const Parameters p = parameters({"planner.c3.projection=plus"});
  C3Controller c3(p);
  PhaseWeights weights = p.roll;
  weights.of_contacts["plus"] = {};
  CHECK(costs_of(c3.problem(), weights).plus.final_scale.size() == 0);
  weights.of_contacts["plus"]["final_scale"] = {{"end_effector", 50.0}};
  const c3::Costs costs = costs_of(c3.problem(), weights);
  // γ, normal force and the four edges of the first of two contacts
  Eigen::VectorXd expected = Eigen::VectorXd::Ones(12);
  for (const int pair : {0, 2, 4, 5, 6, 7}) expected[pair] = 50.0;
  CHECK(costs.plus.final_scale == expected);
}

TEST_CASE("planner: a ball far from its path is brought back by targets near by") {
  Parameters p = parameters();
  p.heuristic.target_reach = 0.045;
  Planner planner(p);
  Input input = input_at(0.0, Vector3d(0.55, 0.0, 0.1));
  const Eigen::Vector2d far(0.55, 0.2);
  input.bodies[0].body.p_WB.head<2>() = far;
  const Plan& plan = planner.step(input);
  REQUIRE(plan.mode == Mode::kApproach);
  CHECK((plan.body_target.head<2>() - far).norm() == Approx(0.045));
  // on the path nothing changes
  CHECK((planner.step(input_at(0.01, Vector3d(0.55, 0.0, 0.1))).body_target -
         Planner(parameters()).step(input_at(0.01, Vector3d(0.55, 0.0, 0.1))).body_target)
            .norm() < 1e-12);
}

TEST_CASE("planner: where the table is lower below the ball, the whole plan is lower") {
  const Vector3d lower(0.0, 0.0, -0.002);
  const auto plan_at = [&](const Vector3d& offset) {
    Parameters p = parameters();
    p.table_below_object = true;
    Follower follower(p);
    REQUIRE(follower.until("roll", 2000));
    Input input = input_at(follower.now, follower.p_WE + offset);
    input.effector.v_WE = follower.v_WE;
    input.bodies[0].body.p_WB += offset;
    return follower.planner.step(input);
  };
  const Plan level = plan_at(Vector3d::Zero()), low = plan_at(lower);
  REQUIRE(level.status == PlanStatus::kOk);
  CHECK((low.p_WE - level.p_WE - lower).norm() < 1e-9);
  CHECK((low.v_WE - level.v_WE).norm() < 1e-7);
}

TEST_CASE(
    "planner: a ball seen a little too high is pressed on, and does not hold the end effector up") {
  const auto planned_height = [&](double too_high) {
    Parameters p = parameters();
    p.table_below_object = true;
    Follower follower(p);
    REQUIRE(follower.until("roll", 2000));
    const double touching = radius_of(p) + p.geometry.end_effector_radius;
    Input input = input_at(follower.now, kBall + touching * Vector3d::UnitZ());
    input.bodies[0].body.p_WB.z() += too_high;
    return follower.planner.step(input).p_WE.z();
  };
  CHECK(planned_height(1e-4) < planned_height(0.0) - 3e-5);
  CHECK(planned_height(3e-4) < planned_height(0.0) - 3e-5);
}

namespace {

Parameters several(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml",
                               overrides)
      .planner;
}

/// Balls at rest 0.12 m apart on the line, so that none is in another's way.
Input balls_input(const Parameters& p, double now, const Vector3d& p_WE, const Vector3d& v_WE) {
  Input input = input_at(now, p_WE);
  input.effector.v_WE = v_WE;
  for (int i = 0; i < p.model.bodies; ++i) {
    const Vector3d at(0.55, 0.1 - 0.12 * i, p.geometry.table_height + radius_of(p));
    input.bodies[static_cast<std::size_t>(i)] = {true, 0.0, {at}};
  }
  return input;
}

}  // namespace

TEST_CASE("planner: of several balls each has its states, each pair its forces") {
  struct Sizes {
    std::string scenario;
    std::vector<std::string> overrides;
    int n_x, n_lambda, n_lambda_d;
  };
  // [C3, VII-B]: 14 and 18 of two balls, 18 and 24 of three; 22 and 60 of four
  for (const Sizes& sizes :
       {Sizes{"two_balls", {}, 14, 18, 18},
        Sizes{"three_balls", {"planner.model.contact_model=stewart_trinkle"}, 18, 36, 36},
        Sizes{"three_balls", {"planner.model.contact_model=anitescu"}, 18, 24, 36},
        Sizes{"three_balls_plus", {}, 18, 36, 36}, Sizes{"four_balls", {}, 22, 60, 60},
        Sizes{"two_balls", {"planner.model.contacts.ball_ball=false"}, 14, 12, 18}}) {
    CAPTURE(sizes.scenario, sizes.n_lambda);
    const Parameters p = several(sizes.scenario, sizes.overrides);
    Planner planner(p);
    const Plan& plan = planner.step(balls_input(p, 0.0, {0.55, 0.1, 0.1}, Vector3d::Zero()));
    CHECK(plan.x.rows() == sizes.n_x);
    CHECK(plan.lambda.rows() == sizes.n_lambda);
    CHECK(plan.lambda_d.size() == sizes.n_lambda_d);
  }
}

TEST_CASE("planner: several balls are planned for, the one behind is approached and worked on") {
  const Parameters p = several("two_balls");
  const double step = p.task.as<c3rt::task::Line>()->step;
  Planner planner(p);
  Vector3d p_WE(0.55, 0.0, 0.08), v_WE = Vector3d::Zero();
  double now = 0.0;
  int planned = 0;
  for (int i = 0; i < 600 && planned < 100; ++i, now += 1.0 / p.rate) {
    const Plan& plan = planner.step(balls_input(p, now, p_WE, v_WE));
    REQUIRE(finite(plan));
    CHECK(plan.body == 0);
    if (plan.phase == std::string("return") || plan.phase == std::string("roll")) {
      ++planned;
      CHECK(plan.status == PlanStatus::kOk);
      CHECK((plan.body_target.head<2>() - Eigen::Vector2d(0.55, 0.1 + step)).norm() < 1e-12);
    }
    p_WE = plan.p_WE;
    v_WE = plan.v_WE;
  }
  CHECK(planned == 100);
}

TEST_CASE("planner: one lost ball of several makes it hold, whichever it is") {
  const Parameters p = several("three_balls");
  for (const std::size_t lost : {0, 1, 2}) {
    CAPTURE(lost);
    Planner planner(p);
    Input input = balls_input(p, 0.0, {0.55, 0.1, 0.1}, Vector3d::Zero());
    CHECK(planner.step(input).mode == Mode::kApproach);
    input.now = 0.02;
    input.bodies[lost].seen = false;
    CHECK(planner.step(input).mode == Mode::kHold);
    input.now = 0.04;
    input.bodies[lost].seen = true;
    input.bodies[lost].body.p_WB.x() = 0.9;  // out of reach
    CHECK(planner.step(input).mode == Mode::kHold);
    input.now = 0.06;
    input.bodies[lost].body.p_WB.x() = 0.55;
    CHECK(planner.step(input).mode == Mode::kApproach);
  }
}

TEST_CASE("planner: twice the mass is moved the same way, bit for bit, by twice the forces") {
  // every force in the equations of motion is proportional to the mass
  const Parameters one = parameters();
  const Parameters two = parameters({"planner.model.ball_mass_kg=0.264"});
  Follower light(one), heavy(two);
  double largest = 0.0;
  for (int i = 0; i < 900; ++i) {
    const Plan& a = light.step();
    const Plan& b = heavy.step();
    REQUIRE(a.mode == b.mode);
    REQUIRE(a.p_WE == b.p_WE);
    REQUIRE(a.v_WE == b.v_WE);
    REQUIRE(a.x == b.x);
    REQUIRE((2.0 * a.force_E).eval() == b.force_E);
    REQUIRE((2.0 * a.u_c3).eval() == b.u_c3);
    REQUIRE((2.0 * a.lambda_d).eval() == b.lambda_d);
    REQUIRE((2.0 * a.lambda).eval() == b.lambda);
    REQUIRE((2.0 * a.u).eval() == b.u);
    largest = std::max(largest, a.force_E.norm());
  }
  CHECK(largest > 0.1);  // it came to touch the ball
}

TEST_CASE("planner: heights are those above the ball's top, ways over it end at the same angle") {
  for (const double radius : {0.02, 0.025, 0.04, 0.05}) {
    CAPTURE(radius);
    const Parameters tuned = parameters({}, kFast),
                     other = parameters({"planner.model.ball_radius_m=" + std::to_string(radius)},
                                        kFast);
    const double top = 2.0 * (radius - 0.0315);
    for (int i = 0; i < 3; ++i)
      CHECK(other.heuristic.return_heights[i] == Approx(tuned.heuristic.return_heights[i] + top));
    CHECK(other.approach.safe_height == Approx(tuned.approach.safe_height + top));
    CHECK(other.approach.start_height == Approx(tuned.approach.start_height + 0.5 * top));
    // the end effector's centre goes round the ball's on a circle of both radii
    const double effector = tuned.geometry.end_effector_radius;
    const auto angle = [&](double beside, double of) {
      return std::asin(beside / (of + effector));
    };
    if (radius < 0.0315) {
      CHECK(angle(other.heuristic.return_back, radius) ==
            Approx(angle(tuned.heuristic.return_back, 0.0315)));
    } else {  // room for more
      CHECK(other.heuristic.return_back == Approx(radius / 0.0315 * tuned.heuristic.return_back));
    }
    CHECK(angle(other.heuristic.roll_reach, radius) ==
          Approx(angle(tuned.heuristic.roll_reach, 0.0315)));
    CHECK(other.model.force_unit == 1.0);  // of the same mass
  }
}

TEST_CASE("planner: what is over sooner on a smaller ball has less time, a larger one the same") {
  const Parameters tuned = parameters(), small = parameters({"planner.model.ball_radius_m=0.02"}),
                   large = parameters({"planner.model.ball_radius_m=0.05"});
  const double way = (0.02 + 0.0195) / (0.0315 + 0.0195);
  CHECK(small.heuristic.roll_duration == Approx(way * tuned.heuristic.roll_duration));
  CHECK(small.dt == Approx(std::sqrt(way) * tuned.dt));
  CHECK(small.heuristic.roll_press > 0.5);
  for (const Parameters& same : {small, large})
    CHECK(same.heuristic.return_duration == tuned.heuristic.return_duration);
  CHECK(large.heuristic.roll_duration == tuned.heuristic.roll_duration);
  CHECK(large.dt == tuned.dt);
  CHECK(large.heuristic.roll_press == 0.0);
}

TEST_CASE("planner: a force is weighed alike on balls of every size and step") {
  const auto force_scale = [](const std::string& radius) {
    const Parameters of = parameters({"planner.model.ball_radius_m=" + radius});
    C3Controller c3(of);
    const int costs = c3.add_costs(costs_of(c3.problem(), of.roll, 0));
    scene::Scene scene = c3.model().layout().world;
    scene::Body& ball = scene.body(0);
    ball.p_WB << 0.55, 0.1, of.geometry.table_height + ball.shape.radius;
    scene.effector.p_WE =
        ball.p_WB + (ball.shape.radius + scene.effector.radius) * Vector3d::UnitZ();
    for (int k = 0; k <= of.N; ++k) c3.want(k, scene, scene);
    REQUIRE(c3.plan(scene, costs, {}) != StepStatus::kFailed);
    return c3.result().force_scale;
  };
  const double tuned = force_scale("0.0315");
  for (const char* radius : {"0.02", "0.025", "0.04", "0.05"}) {
    CAPTURE(radius);
    CHECK(force_scale(radius) == Approx(tuned).epsilon(0.05));  // else 0.4 to 2.5 times
  }
}

TEST_CASE("planner: a ball that the settings do not hold is refused, with the range that they do") {
  using Catch::Contains;
  for (const char* held : {"0.02", "0.025", "0.05"})
    CHECK_NOTHROW(parameters({std::string("planner.model.ball_radius_m=") + held}));
  for (const char* held : {"0.05", "0.528", "0.033785"})
    CHECK_NOTHROW(parameters({std::string("planner.model.ball_mass_kg=") + held}));
  CHECK_THROWS_WITH(parameters({"planner.model.ball_radius_m=0.015"}),
                    Contains("planner.tuned_for.radius_m") &&
                        Contains("model.ball_radius_m is 0.63 to 1.7 times") &&
                        Contains("0.476 times"));
  CHECK_THROWS_WITH(parameters({"planner.model.ball_mass_kg=0.02"}),
                    Contains("model.ball_mass_kg is 0.25 to 4.5 times"));
  // with settings of its own it is its own business
  CHECK_NOTHROW(
      parameters({"planner.model.ball_radius_m=0.015", "planner.tuned_for.radius_m=0.015"}));
}

TEST_CASE("planner: for the ball that it was tuned for everything is taken as it stands") {
  const Parameters same =
      parameters({"planner.tuned_for.radius_m=0.05", "planner.tuned_for.mass_kg=0.2",
                  "planner.model.ball_radius_m=0.05", "planner.model.ball_mass_kg=0.2"});
  CHECK(same.model.force_scale_ratio == 1.0);
  CHECK(same.dt == parameters().dt);
  CHECK(same.model.force_unit == 1.0);
  CHECK(same.model.values["ball_mass_kg"] == 0.2);
  CHECK(same.heuristic.return_back == parameters().heuristic.return_back);
  CHECK(same.heuristic.return_heights == parameters().heuristic.return_heights);
}
