#include "cli/reproduce/open_loop.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli::reproduce;
using Eigen::Vector3d;

config::Scenario slow() {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml");
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

bool never() { return false; }

}  // namespace

TEST_CASE("no inputs are better than those of the monolithic problem, where it is proven") {
  const cli::Folder folder;
  const Context context({"comparison", folder.path().string()}, never);
  const config::Scenario scenario = slow();
  const std::vector<Question> asked{resting(scenario)};
  const Answers c3 = answer_with_c3(asked, scenario, scenario);
  const MonolithicAnswers best = answer_monolithic(asked, scenario, 20.0, context);
  REQUIRE(std::isfinite(c3.costs[0]));
  REQUIRE(best.proven == 1);
  CHECK(best.costs[0] <= c3.costs[0] * (1.0 + 2e-4));  // the gap that it is proven to
  CHECK(best.costs[0] > 0.0);
  // it beats doing nothing by far: the ball is brought along
  const double left_alone =
      (scenario.planner.N + 1) * scenario.planner.roll.Q.at("ball_xy")[0] * 4e-4;
  CHECK(best.costs[0] < 0.9 * left_alone);
}

TEST_CASE("an answer is judged by what the system does, whatever the projection that made it") {
  config::Scenario scenario = slow();
  const std::vector<Question> asked(3, resting(scenario));
  const Answers first = answer_with_c3(asked, scenario, scenario);
  CHECK(first.costs[0] == first.costs[1]);
  CHECK(first.costs[1] == first.costs[2]);
  CHECK(first.times.size() == 3);
  // twice the weights of everything: the same inputs, twice the cost
  config::Scenario judge = scenario;
  for (planner::PhaseWeights* weights : {&judge.planner.roll, &judge.planner.back}) {
    for (auto& [name, of_bodies] : weights->Q)
      for (double& weight : of_bodies) weight *= 2.0;
    weights->R *= 2.0;
  }
  CHECK(answer_with_c3(asked, scenario, judge).costs[0] == Approx(2.0 * first.costs[0]));
}
