#include "controller/horizon/modes.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>

#include "tests/controller/horizon/golden15.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;

namespace {

/// A system of which no block is zero, over a few stages, with every kind of constraint.
struct Example {
  explicit Example(unsigned seed) {
    support::Random random(seed);
    system = {random.matrix(3, 3), random.matrix(3, 2), random.matrix(3, 2), random.vector(3),
              random.matrix(2, 3), random.matrix(2, 2), random.matrix(2, 2), random.vector(2)};
    system.F += 3.0 * Eigen::MatrixXd::Identity(2, 2);
    const Eigen::MatrixXd root = random.matrix(3, 3);
    costs.Q = Eigen::MatrixXd(root * root.transpose());
    costs.Q_N = 2.0 * costs.Q[0];
    costs.R = Eigen::MatrixXd(0.3 * Eigen::MatrixXd::Identity(2, 2));
    problem = {{3, 2, 2, 3}, {&system, 0},        &costs,
               &constraints, random.matrix(3, 4), random.vector(3)};
  }

  lcs::Lcs system;
  c3::Costs costs;
  c3::Constraints constraints;
  horizon::Problem problem;
};

std::vector<horizon::Side> enumerate(unsigned mode, int n_pairs) {
  std::vector<horizon::Side> zero;
  for (int i = 0; i < n_pairs; ++i) {
    zero.push_back((mode >> i) & 1u ? horizon::Side::kGap : horizon::Side::kForce);
  }
  return zero;
}

}  // namespace

TEST_CASE("the condensed cost and rows are those of the simulated trajectory") {
  Example example(1);
  const auto [n_x, n_lambda, n_u, N] = example.problem.sizes;
  example.constraints.x_min = Eigen::VectorXd::Constant(n_x, -7.0);
  example.constraints.x_N_max = Eigen::VectorXd::Constant(n_x, 5.0);
  example.constraints.u_max = Eigen::VectorXd::Constant(n_u, 4.0);
  example.constraints.lambda_max = Eigen::VectorXd::Constant(n_lambda, 9.0);
  support::Random random(2);
  example.constraints.C = Eigen::MatrixXd(random.matrix(1, n_x + n_lambda + n_u));
  example.constraints.C_min = Eigen::VectorXd::Constant(1, -2.0);
  example.constraints.C_max = Eigen::VectorXd::Constant(1, 3.0);
  const horizon::Condensed condensed = horizon::condense(example.problem);
  const Eigen::VectorXd v = random.vector(N * (n_u + n_lambda));
  const horizon::Plan plan = horizon::roll_out(example.problem, v);

  const double cost = v.dot(condensed.H * v) + 2.0 * condensed.g.dot(v) + condensed.constant;
  CHECK(cost == Approx(plan.objective).epsilon(1e-12));

  std::vector<double> forces, gaps, rest;
  for (int k = 0; k < N; ++k) {
    const auto x = plan.x.col(k);
    const auto lambda = plan.lambda.col(k), u = plan.u.col(k);
    const lcs::Lcs& lcs = example.system;
    const Eigen::VectorXd gap = lcs.E * x + lcs.F * lambda + lcs.H * u + lcs.c;
    forces.insert(forces.end(), lambda.begin(), lambda.end());
    gaps.insert(gaps.end(), gap.begin(), gap.end());
    for (int i = 0; k > 0 && i < n_x; ++i) rest.push_back(x[i] + 7.0);
    for (int i = 0; i < n_lambda; ++i) rest.push_back(9.0 - lambda[i]);
    for (int i = 0; i < n_u; ++i) rest.push_back(4.0 - u[i]);
    Eigen::VectorXd z(n_x + n_lambda + n_u);
    z << x, lambda, u;
    const double row = example.constraints.C[0].row(0).dot(z);
    rest.push_back(row + 2.0);
    rest.push_back(3.0 - row);
  }
  for (int i = 0; i < n_x; ++i) rest.push_back(5.0 - plan.x(i, N));
  std::vector<double> expected = forces;
  expected.insert(expected.end(), gaps.begin(), gaps.end());
  expected.insert(expected.end(), rest.begin(), rest.end());
  const Eigen::VectorXd s = condensed.J * v + condensed.c;
  REQUIRE(s.size() == static_cast<Eigen::Index>(expected.size()));
  CHECK((s - Eigen::Map<Eigen::VectorXd>(expected.data(), s.size())).cwiseAbs().maxCoeff() < 1e-11);
}

TEST_CASE("the plan of given modes meets them, and no small step that keeps them is cheaper") {
  int met = 0, compared = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Example example(seed);
    example.constraints.u_min = Eigen::VectorXd::Constant(2, -1.0);
    const horizon::Condensed condensed = horizon::condense(example.problem);
    support::Random random(seed + 100);
    const auto zero = enumerate(static_cast<unsigned>(random.index(64)), condensed.n_pairs);
    const auto plan = horizon::solve_modes(example.problem, condensed, zero);
    if (!plan) continue;
    ++met;
    CHECK(plan->complementarity_violation < 1e-11);
    CHECK(plan->u.minCoeff() > -1.0 - 1e-9);

    // convexity: any other plan of these modes costs more on the way there already
    Eigen::VectorXd v(condensed.g.size());
    Eigen::Map<Eigen::MatrixXd> stages(v.data(), 4, 3);
    stages << plan->u, plan->lambda;
    const Eigen::VectorXd slope = condensed.H * v + condensed.g;
    const Eigen::VectorXd s = condensed.J * v + condensed.c;
    for (int i = 0; i < 200; ++i) {
      Eigen::VectorXd other = Eigen::VectorXd::Zero(v.size());
      // a direction that keeps the zero sides: project a random one on their null space
      Eigen::MatrixXd kept(condensed.n_pairs, v.size());
      for (int pair = 0; pair < condensed.n_pairs; ++pair) {
        kept.row(pair) =
            condensed.J.row(zero[pair] == horizon::Side::kForce ? pair : condensed.n_pairs + pair);
      }
      other = random.vector(v.size());
      other -= kept.transpose() * (kept * kept.transpose()).ldlt().solve(kept * other);
      const Eigen::VectorXd s_other = s + 1e-3 * condensed.J * other;
      if (s_other.minCoeff() < -1e-9) continue;
      ++compared;
      CHECK(slope.dot(other) > -1e-7 * std::max(1.0, slope.norm()));
    }
  }
  CHECK(met >= 5);
  CHECK(compared > 200);
}

TEST_CASE("modes that contradict the constraints have no plan") {
  Example example(3);
  example.constraints.lambda_max = Eigen::VectorXd::Constant(2, -1.0);
  const horizon::Condensed condensed = horizon::condense(example.problem);
  CHECK_FALSE(horizon::solve_modes(example.problem, condensed, enumerate(0, condensed.n_pairs)));
}

TEST_CASE("an equality among the constraints is met") {
  Example example(4);
  example.constraints.x_N_min = Eigen::Vector3d(0.1, -std::numeric_limits<double>::infinity(), -50);
  example.constraints.x_N_max = Eigen::Vector3d(0.1, std::numeric_limits<double>::infinity(), 50);
  const horizon::Condensed condensed = horizon::condense(example.problem);
  REQUIRE(condensed.equalities.size() == 1);
  int met = 0;
  for (unsigned mode = 0; mode < 64; ++mode) {
    const auto plan =
        horizon::solve_modes(example.problem, condensed, enumerate(mode, condensed.n_pairs));
    if (!plan) continue;
    ++met;
    CHECK(plan->x(0, 3) == Approx(0.1).margin(1e-9));
  }
  CHECK(met > 0);
}

TEST_CASE("the modes of a solved plan give that plan again") {
  for (const golden15::Case& c : golden15::load()) {
    if (c.name.rfind("cartpole", 0) != 0) continue;
    INFO(c.name);
    const horizon::Problem problem = c.problem();
    const horizon::Condensed condensed = horizon::condense(problem);
    const std::vector<horizon::Side> open(condensed.n_pairs, horizon::Side::kForce);
    const auto plan = horizon::solve_modes(problem, condensed, open);
    if (!plan) continue;
    const auto again = horizon::solve_modes(problem, condensed, horizon::modes(problem, *plan));
    REQUIRE(again);
    CHECK(again->objective == Approx(plan->objective).epsilon(1e-9));
  }
}
