#include "cli/example/exact.hpp"

#include <catch2/catch.hpp>

#include "cli/example/scenario.hpp"
#include "cli/example/trials.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli;

ExampleScenario cart_pole(const std::vector<std::string>& overrides = {}) {
  return load_example(C3RT_SOURCE_DIRECTORY "/config/scenarios/cart_pole.yaml", overrides);
}

bool never() { return false; }

}  // namespace

TEST_CASE("the exact search never plans a worse cost than C3") {
  const example::Experiment experiment = cart_pole().experiment;
  example::C3Controller c3(experiment);
  ExactController exact(experiment, 60.0, never);
  for (const Eigen::Vector4d& x :
       {Eigen::Vector4d(0.3, 0, 0.3, 0), Eigen::Vector4d(0.45, 0.1, 0.8, -0.5),
        Eigen::Vector4d(-0.4, 0.0, -1.0, 0.5), Eigen::Vector4d(0, 0, 0, 0)}) {
    const lcs::Lcs lcs = example::planning_system(experiment, x);
    const Eigen::MatrixXd* c3_inputs = c3.decide(lcs, x, 0.0);
    REQUIRE(c3_inputs != nullptr);
    const double c3_cost = example::cost_to_go(experiment, lcs, x, *c3_inputs);
    const Eigen::MatrixXd* inputs = exact.decide(lcs, x, 0.0);
    REQUIRE(inputs != nullptr);
    // both within the search's gap of 1e-4
    CHECK(example::cost_to_go(experiment, lcs, x, *inputs) <= c3_cost * (1.0 + 1e-4) + 1e-6);
    CHECK(exact.decisions().back().proven);
    CHECK(exact.decisions().back().gap < 1.001e-4);
  }
}

TEST_CASE("a loop with the exact search tells of every decision what it proved") {
  const ExampleScenario short_one = cart_pole({"control.duration_s=0.1"});
  const TrialsResult result = run_trials(short_one, 1, never, {60.0, false});
  REQUIRE(result.exact.size() == 10);
  const ExampleReport report = report_on(short_one, 1, result);
  CHECK(report.exact == 10);
  CHECK(report.proven == 10);
  CHECK_THAT(summary(report), Catch::Contains("10 of 10 solves"));
  CHECK(run_trials(short_one, 1, never).exact.empty());
}

TEST_CASE("a wish to end within a decision of the exact search interrupts the trial") {
  int asked = 0;
  const TrialsResult result = run_trials(cart_pole({"control.duration_s=0.01"}), 1,
                                         [&] { return ++asked > 1; }, {60.0, false});
  CHECK(result.interrupted);
  CHECK(result.trials.empty());
}
