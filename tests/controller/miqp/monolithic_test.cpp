#include "controller/miqp/monolithic.hpp"

#include <catch2/catch.hpp>

#include "tests/controller/horizon/golden15.hpp"

using namespace c3rt;

TEST_CASE("the optimum of recorded problems is found within the gap, without a leak") {
  // the quickest of each example
  const std::vector<std::string> names = {
      "cartpole authors_traj_k150 N 5", "cartpole near_wall_gap-0.01_side-1 N 5",
      "finger authors_traj_t0.5 N 3", "pivoting authors_traj_t0.49 N 2",
      "pivoting authors_traj_t3.50 N 2"};
  int seen = 0;
  for (const golden15::Case& c : golden15::load()) {
    if (std::find(names.begin(), names.end(), c.name) == names.end()) continue;
    INFO(c.name);
    ++seen;
    miqp::MonolithicSettings settings;
    settings.big_m = c.big_m;
    const miqp::MonolithicResult result = miqp::solve_monolithic(c.problem(), settings);
    REQUIRE(result.status == miqp::Status::kOptimal);
    CHECK(result.is_polished);
    CHECK(result.plan.objective >= c.objective * (1.0 - 1e-9));
    CHECK(result.plan.objective <= c.objective * (1.0 + 1e-4));
    CHECK(result.gap <= 1.1e-4);
    CHECK(result.plan.complementarity_violation < 1e-10);
    CHECK(result.largest < 0.9 * c.big_m);
  }
  CHECK(seen == 5);
}

TEST_CASE("a node limit gives a plan that says how far it may be from the optimum") {
  for (const golden15::Case& c : golden15::load()) {
    if (c.name != "finger authors N 3") continue;
    miqp::MonolithicSettings settings;
    settings.big_m = c.big_m;
    settings.solver.max_nodes = 5;
    const miqp::MonolithicResult result = miqp::solve_monolithic(c.problem(), settings);
    REQUIRE((result.status == miqp::Status::kFeasible || result.status == miqp::Status::kFailed));
    if (result.status == miqp::Status::kFeasible) {
      CHECK(result.plan.objective * (1.0 - result.gap) <= c.objective * (1.0 + 1e-9));
      CHECK(result.plan.objective >= c.objective * (1.0 - 1e-9));
    }
    return;
  }
  FAIL("the recorded problem is missing");
}

TEST_CASE("a big-M that is not positive is refused") {
  const std::vector<golden15::Case> cases = golden15::load();
  miqp::MonolithicSettings settings;
  settings.big_m = 0.0;
  CHECK_THROWS_WITH(miqp::solve_monolithic(cases.front().problem(), settings),
                    Catch::Contains("big_m: expected a positive number, got 0"));
}
