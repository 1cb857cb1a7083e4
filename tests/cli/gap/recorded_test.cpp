#include "cli/gap/recorded.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "cli/paths.hpp"
#include "controller/horizon/modes.hpp"
#include "controller/horizon/search.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli::gap;
using Eigen::Vector3d;

config::Scenario scenario(const std::string& name) {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml");
}

double cost_of(const Decisions& decisions, const Eigen::MatrixXd& u) {
  const auto plan = decisions.simulated(0, u);
  return plan ? plan->objective : NAN;
}

/// The end effector on the ball, which rests and is wanted 2 cm further along.
Question resting(const config::Scenario& scenario) {
  const planner::Parameters& p = scenario.planner;
  const double radius = p.model.values["ball_radius_m"];
  const double height = p.geometry.table_height + radius;
  const double touching = height + radius + p.geometry.end_effector_radius;
  Question question{};
  question.rolling = true;
  scene::Scene& scene = question.scene;
  scene.body_count = 1;
  scene.body(0).p_WB = {0.55, 0.1, height};
  scene.effector.p_WE = {0.55, 0.1, touching};
  scene::Scene desired = scene;
  desired.body(0).p_WB.x() += 0.02;
  question.desired.assign(static_cast<std::size_t>(p.N) + 1, desired);
  return question;
}

}  // namespace

TEST_CASE("no planner's inputs are better than the optimum, nor far worse") {
  const config::Scenario slow = scenario("circle_slow");
  const std::vector<Question> asked{resting(slow)};
  const Decisions decisions = of_questions(asked, slow);
  const horizon::Problem problem = decisions.problem(0);
  const auto plan = decisions.simulated(0, decisions.all[0].u);
  REQUIRE(plan);
  const horizon::SearchResult best =
      horizon::search(problem, {}, horizon::solve_modes(problem, horizon::modes(problem, *plan)));
  REQUIRE(best.is_proven());
  const double optimum = cost_of(decisions, best.plan->u);
  CHECK(optimum > 0.0);
  // it beats doing nothing by far: the ball is brought along
  const double left_alone = (slow.planner.N + 1) * slow.planner.roll.Q.at("ball_xy")[0] * 4e-4;
  CHECK(optimum < 0.9 * left_alone);
  CHECK(cost_of(decisions, Eigen::MatrixXd::Zero(3, slow.planner.N)) ==
        Approx(left_alone).epsilon(0.2));
  // C3+ copies the gaps, too, which are no inputs
  for (const char* name : {"circle_slow", "circle_slow_convex", "circle_slow_plus"}) {
    CAPTURE(name);
    const std::vector<Answer> answered = answers(asked, slow, scenario(name));
    REQUIRE(answered.size() == 1);
    const double cost = cost_of(decisions, answered[0].u);
    CHECK(cost >= optimum * (1.0 - 2e-4));  // the gap that it is proven to
    CHECK(cost < 10.0 * left_alone);
  }
}

TEST_CASE("an answer is judged by what the system does, whatever the planner that made it") {
  config::Scenario slow = scenario("circle_slow");
  const std::vector<Question> asked(3, resting(slow));
  const std::vector<Answer> answered = answers(asked, slow, slow);
  REQUIRE(answered.size() == 3);
  CHECK(answered[0].u == answered[1].u);
  CHECK(answered[1].u == answered[2].u);
  const double once = cost_of(of_questions(asked, slow), answered[0].u);
  // twice the weights of everything: of the same inputs twice the cost
  for (planner::PhaseWeights* weights : {&slow.planner.roll, &slow.planner.back}) {
    for (auto& [name, of_bodies] : weights->Q)
      for (double& weight : of_bodies) weight *= 2.0;
    weights->R *= 2.0;
  }
  CHECK(cost_of(of_questions(asked, slow), answered[0].u) == Approx(2.0 * once));
}

TEST_CASE("questions are of one ball and the time-based heuristic alone") {
  for (const char* name : {"two_balls", "push_t"}) {
    CAPTURE(name);
    CHECK_THROWS_AS(answers({}, scenario(name), scenario(name)), cli::UsageError);
  }
}

TEST_CASE("a planner that looks ahead farther than the recording's is refused") {
  const config::Scenario slow = scenario("circle_slow");
  config::Scenario longer = slow;
  longer.planner.N = slow.planner.N + 1;
  CHECK_THROWS_WITH(
      answers({resting(slow)}, slow, longer),
      Catch::Contains("expected a horizon of 5") && Catch::Contains("got a horizon of 6"));
}
