// Problems that once got a wrong answer, or none, through `c3rt solve`, with the right one.
#include <string>

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "config/problem_file.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

config::ProblemFile load(const std::string& name) {
  return config::load_problem(C3RT_SOURCE_DIRECTORY "/tests/data/solve/" + name + ".json");
}

config::ProblemResult solve(const config::ProblemFile& problem) {
  c3::Solver solver(problem.sizes, problem.settings);
  solver.set_costs(problem.costs, problem.constraints);
  return config::to_result(problem, solver.solve(problem.lcs, problem.x0, problem.x_desired), 0.0);
}

/// One system for all stages has the same result as a list of N of them, which `solve` gives.
config::ProblemFile per_stage(config::ProblemFile problem) {
  if (problem.lcs.size() == 1) {
    problem.lcs.assign(static_cast<std::size_t>(problem.sizes.N), problem.lcs.front());
  }
  return problem;
}

}  // namespace

TEST_CASE("cases: a state that is fixed where nothing leads is infeasible with every QP step") {
  for (const char* name : {"A1_unreachable_terminal_equality", "A2_cartpole_x1_fixed_elsewhere"}) {
    for (const c3::QpBackend backend : {c3::QpBackend::kInteriorPoint, c3::QpBackend::kOsqp}) {
      config::ProblemFile problem = per_stage(load(name));
      problem.settings.qp = backend;
      const config::ProblemResult result = solve(problem);
      CAPTURE(name, static_cast<int>(backend));
      CHECK(result.status == "fail: the bounds cannot be met");
      REQUIRE(result.qp);
      CHECK(result.qp->status == c3::QpStatus::kInfeasible);
    }
  }
}

TEST_CASE("cases: a state that is fixed where an input leads is there") {
  config::ProblemFile problem = per_stage(load("A1_unreachable_terminal_equality"));
  // x_1 = [1 + 0.005 u, 0.1 u] at u = −2
  problem.constraints.x_N_min = problem.constraints.x_N_max = Eigen::Vector2d(0.99, -0.2);
  for (const c3::QpBackend backend : {c3::QpBackend::kInteriorPoint, c3::QpBackend::kOsqp}) {
    problem.settings.qp = backend;
    const config::ProblemResult result = solve(problem);
    CAPTURE(static_cast<int>(backend), result.status);
    CHECK(result.status == "ok");
    CHECK(result.u(0, 0) == Approx(-2.0).epsilon(1e-7));
    REQUIRE(result.qp);
    CHECK(result.qp->primal_residual < 1e-7);
    CHECK(result.qp->dual_residual < 1e-7);
  }
}

TEST_CASE("cases: unstable systems over a long horizon are solved, with and without bounds") {
  const config::ProblemFile C1 = per_stage(load("C1_unstable_scalar_N20"));
  const config::ProblemResult scalar = solve(C1);
  CHECK(scalar.status == "ok");
  CHECK(scalar.u(0, 0) == Approx(-1.6965546).epsilon(1e-7));
  CHECK(scalar.objective == Approx(0.5994863).epsilon(1e-6));

  const config::ProblemFile C4 = per_stage(load("C4_interior_point_drifts_N400"));
  const config::ProblemResult bounded = solve(C4);
  CHECK(bounded.status == "ok");
  CHECK(bounded.objective == Approx(0.423066).epsilon(2e-6));
}

TEST_CASE("cases: a bound that nothing comes near changes nothing of an unstable cart-pole") {
  config::ProblemFile problem = per_stage(load("C2_cartpole_dt01_N24"));
  const config::ProblemResult free = solve(problem);
  CHECK(free.status == "ok");
  problem.settings.qp = c3::QpBackend::kInteriorPoint;
  problem.constraints.u_max = VectorXd::Constant(1, 1e6);
  const config::ProblemResult bounded = solve(problem);
  CHECK(bounded.status == "ok");
  CHECK((free.u - bounded.u).cwiseAbs().maxCoeff() < 1e-9 * free.u.cwiseAbs().maxCoeff());
  // and the states are the inputs', step by step
  for (int k = 0; k < problem.sizes.N; ++k) {
    const lcs::Lcs& lcs = problem.lcs.front();
    const VectorXd next =
        lcs.A * free.x.col(k) + lcs.B * free.u.col(k) + lcs.D * free.lambda.col(k) + lcs.d;
    CHECK((next - free.x.col(k + 1)).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("cases: what OSQP calls infeasible is not believed but checked") {
  const config::ProblemFile problem = per_stage(load("E1_osqp_false_infeasible"));
  REQUIRE(problem.settings.qp == c3::QpBackend::kOsqp);
  const config::ProblemResult result = solve(problem);
  CHECK(result.status == "ok");
  // the QP's own objective: without x_d's constant term
  const VectorXd x = result.x.col(1), x_d = problem.x_desired.col(1);
  const double objective = x.dot(problem.costs.Q_N * (x - 2.0 * x_d));
  CAPTURE(objective);
  CHECK((x - problem.constraints.x_N_max).maxCoeff() < 1e-6);
  CHECK(objective == Approx(1571.8664).epsilon(1e-6));  // at the corner u = [−1, −1, −1, 1]
}

TEST_CASE("cases: a result file says what the last QP misses") {
  const config::ProblemFile problem = per_stage(load("C1_unstable_scalar_N20"));
  const nlohmann::json json = nlohmann::json::parse(to_json(problem, solve(problem), {}));
  CHECK(json["qp_primal_residual"].get<double>() < 1e-12);
  CHECK(json["qp_dual_residual"].get<double>() < 1e-9);
}
