#include "controller/horizon/search.hpp"

#include <limits>

#include <catch2/catch.hpp>

#include "controller/horizon/modes.hpp"
#include "tests/controller/horizon/golden15.hpp"

using namespace c3rt;

TEST_CASE("the search proves the recorded optima of all examples") {
  int seen = 0;
  for (const golden15::Case& c : golden15::load()) {
    INFO(c.name);
    ++seen;
    horizon::SearchSettings settings;
    settings.relative_gap = 1e-6;
    const horizon::SearchResult result = horizon::search(c.problem(), settings);
    REQUIRE(result.plan);
    CHECK(result.is_proven());
    CHECK(result.gap <= 1.01e-6);
    CHECK(result.plan->objective == Approx(c.objective).epsilon(2e-6));
    CHECK(result.plan->complementarity_violation < 1e-10);
  }
  CHECK(seen == 30);
}

TEST_CASE("the optimum is the best of all modes") {
  for (const golden15::Case& recorded : golden15::load()) {
    if (recorded.name.rfind("cartpole", 0) != 0) continue;
    golden15::Case c = recorded;
    c.N = 4;
    INFO(c.name);
    const horizon::Problem problem = c.problem();
    const horizon::Condensed condensed = horizon::condense(problem);
    double best = std::numeric_limits<double>::infinity();
    for (unsigned mode = 0; mode < (1u << condensed.n_pairs); ++mode) {
      std::vector<horizon::Side> zero;
      for (int i = 0; i < condensed.n_pairs; ++i) {
        zero.push_back((mode >> i) & 1u ? horizon::Side::kGap : horizon::Side::kForce);
      }
      const auto plan = horizon::solve_modes(problem, zero);
      if (plan) best = std::min(best, plan->objective);
    }
    const horizon::SearchResult result = horizon::search(problem, {});
    REQUIRE(result.plan);
    CHECK(result.plan->objective >= best * (1.0 - 1e-9));
    CHECK(result.plan->objective <= best * (1.0 + 1e-4));
  }
}

TEST_CASE("a search that is cut short bounds its distance from the optimum") {
  int cut = 0;
  for (const golden15::Case& c : golden15::load()) {
    if (c.name.rfind("finger", 0) != 0) continue;
    INFO(c.name);
    for (const long nodes : {10L, 20L, 30L}) {
      horizon::SearchSettings settings;
      settings.max_nodes = nodes;
      const horizon::SearchResult result = horizon::search(c.problem(), settings);
      CHECK(result.nodes <= nodes);
      if (result.is_proven() || !result.plan) continue;
      ++cut;
      CHECK(result.plan->objective * (1.0 - result.gap) <= c.objective * (1.0 + 1e-6));
      CHECK(result.plan->objective >= c.objective * (1.0 - 1e-9));
    }
  }
  CHECK(cut > 5);
}

TEST_CASE("a known plan is kept unless a better one is found, and saves nodes") {
  for (const golden15::Case& c : golden15::load()) {
    if (c.name != "finger authors_traj_t2.7 N 3") continue;
    const horizon::Problem problem = c.problem();
    const horizon::SearchResult first = horizon::search(problem, {});
    REQUIRE(first.plan);
    const horizon::SearchResult again = horizon::search(problem, {}, first.plan);
    REQUIRE(again.plan);
    CHECK(again.plan->objective <= first.plan->objective);
    CHECK(again.nodes < first.nodes);
    horizon::SearchSettings none;
    none.max_nodes = 0;
    const horizon::SearchResult kept = horizon::search(problem, none, first.plan);
    REQUIRE(kept.plan);
    CHECK(kept.plan->objective == first.plan->objective);
    CHECK(kept.status == horizon::SearchStatus::kNodeLimit);
    return;
  }
  FAIL("the recorded problem is missing");
}

TEST_CASE("how a search ended is told apart") {
  for (const golden15::Case& recorded : golden15::load()) {
    if (recorded.name != "finger authors_traj_t2.7 N 3") continue;
    golden15::Case c = recorded;
    horizon::SearchSettings one;
    one.max_nodes = 1;
    const horizon::SearchResult cut = horizon::search(c.problem(), one);
    CHECK(cut.status == horizon::SearchStatus::kNodeLimit);
    CHECK_FALSE(cut.plan);
    CHECK(cut.lower_bound > 0.0);
    CHECK(cut.lower_bound <= c.objective);
    CHECK(describe(cut) == "stopped at max_nodes = 1 (1 QPs solved): no plan was found");
    one.max_nodes = 30;
    const horizon::SearchResult better = horizon::search(c.problem(), one);
    CHECK(better.status == horizon::SearchStatus::kNodeLimit);
    REQUIRE(better.plan);
    CHECK_THAT(describe(better), Catch::StartsWith("stopped at max_nodes = 30 (30 QPs solved): the "
                                                   "best plan found is within a gap of "));
    c.constraints.x_N_min = c.constraints.x_N_max = c.x_desired.array() + 1e3;
    const horizon::SearchResult none = horizon::search(c.problem(), {});
    CHECK(none.status == horizon::SearchStatus::kInfeasible);
    CHECK_FALSE(none.plan);
    CHECK(describe(none) == "infeasible: no trajectory meets the constraints");
    return;
  }
  FAIL("the recorded problem is missing");
}

TEST_CASE("a known plan that does not meet the problem is left alone") {
  const golden15::Case c = golden15::load().front();
  const horizon::Problem problem = c.problem();
  const horizon::SearchResult first = horizon::search(problem, {});
  REQUIRE(first.plan);
  horizon::Plan wrong = *first.plan;
  wrong.x *= 0.5;  // cheaper, but no trajectory
  const horizon::SearchResult again = horizon::search(problem, {}, wrong);
  REQUIRE(again.plan);
  CHECK(again.plan->objective == Approx(first.plan->objective).epsilon(1e-4));
}

TEST_CASE("a deadline ends the search") {
  const c3::Deadline now{[](void*) noexcept { return true; }, nullptr};
  const std::vector<golden15::Case> cases = golden15::load();
  const horizon::SearchResult result = horizon::search(cases[0].problem(), {}, {}, now);
  CHECK(result.nodes == 0);
  CHECK(result.status == horizon::SearchStatus::kDeadline);
}

namespace {

/// x⁺ = x + u + 0.5, x⊤Q x + u² with and without a contact that never acts; x0 = 1, N = 2.
struct Integrator {
  explicit Integrator(int n_lambda) {
    lcs.A = lcs.B = Eigen::MatrixXd::Identity(1, 1);
    lcs.D = lcs.E = Eigen::MatrixXd::Zero(1, n_lambda);
    lcs.E.resize(n_lambda, 1);
    lcs.E.setZero();
    lcs.d = Eigen::VectorXd::Constant(1, 0.5);
    lcs.F = Eigen::MatrixXd::Identity(n_lambda, n_lambda);
    lcs.H = Eigen::MatrixXd::Zero(n_lambda, 1);
    lcs.c = Eigen::VectorXd::Ones(n_lambda);
    costs.Q = Eigen::MatrixXd(Eigen::MatrixXd::Identity(1, 1));
    costs.Q_N = Eigen::MatrixXd::Identity(1, 1);
    costs.R = Eigen::MatrixXd(Eigen::MatrixXd::Identity(1, 1));
    problem = {
        {1, n_lambda, 1, 2},     {&lcs, 0}, &costs, &constraints, Eigen::MatrixXd::Zero(1, 3),
        Eigen::VectorXd::Ones(1)};
  }
  lcs::Lcs lcs;
  c3::Costs costs;
  c3::Constraints constraints;
  horizon::Problem problem;
};

}  // namespace

TEST_CASE("without a contact the optimum is that of the QP") {
  Integrator without(0);
  const horizon::SearchResult result = horizon::search(without.problem, {});
  REQUIRE(result.plan);
  CHECK(result.is_proven());
  // u_1 = −(x_1 + ½)/2, then x_1 = 3/2 + u_0: u_0² + x_1² + (x_1 + ½)²/2 is least at
  // u_0 + 3/2 + u_0 + (2 + u_0)/2 = 0
  CHECK(result.plan->u(0, 0) == Approx(-1.0));
  CHECK(result.plan->u(0, 1) == Approx(-0.5));
  CHECK(result.plan->objective == Approx(1.0 + 1.0 + 0.25 + 0.25 + 0.25));
  CHECK(result.plan->complementarity_violation == 0.0);
}

TEST_CASE("rows C with one side alone bound that side") {
  for (const int n_lambda : {0, 1}) {
    CAPTURE(n_lambda);
    Integrator bounded(n_lambda);
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(1, 2 + n_lambda);
    C(0, 1 + n_lambda) = 1.0;  // u
    bounded.constraints.C = C;
    bounded.constraints.C_min = Eigen::VectorXd::Constant(1, -0.25);
    const horizon::SearchResult above = horizon::search(bounded.problem, {});
    REQUIRE(above.plan);
    CHECK(above.plan->u(0, 0) == Approx(-0.25));
    CHECK(above.plan->u(0, 1) == Approx(-0.25));
    CHECK(horizon::residual(bounded.problem, *above.plan) <= horizon::kMet);

    bounded.constraints.C_min = Eigen::VectorXd();
    bounded.constraints.C_max = Eigen::VectorXd::Constant(1, -2.0);
    CHECK(horizon::residual(bounded.problem, *above.plan) > horizon::kMet);
    const horizon::SearchResult below = horizon::search(bounded.problem, {});
    REQUIRE(below.plan);
    CHECK(below.plan->u(0, 0) == Approx(-2.0));
    CHECK(below.plan->u(0, 1) == Approx(-2.0));
  }
}
