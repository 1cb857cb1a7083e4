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

/// Pair i by bit i; those beyond the bits have no force.
std::vector<horizon::Side> enumerate(unsigned mode, int n_pairs) {
  std::vector<horizon::Side> zero;
  for (int i = 0; i < n_pairs; ++i) {
    const bool gap = i < 32 && ((mode >> i) & 1u) != 0;
    zero.push_back(gap ? horizon::Side::kGap : horizon::Side::kForce);
  }
  return zero;
}

}  // namespace

TEST_CASE("the condensed cost and rows are those of the simulated trajectory") {
  const double growth = GENERATE(0.0, 10.0);  // with it, there is feedback in v
  Example example(1);
  example.system.A += growth * Eigen::MatrixXd::Identity(3, 3);
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
  const Eigen::MatrixXd forces = random.matrix(n_lambda, N), inputs = random.matrix(n_u, N);
  const horizon::Plan plan = horizon::roll_out(example.problem, forces, inputs);
  const Eigen::VectorXd v = horizon::inputs_of(example.problem, condensed, plan);
  CHECK(condensed.K[0].isZero(0.0) == (growth == 0.0));

  const double cost = v.dot(condensed.H * v) + 2.0 * condensed.g.dot(v) + condensed.constant;
  CHECK(cost == Approx(plan.objective).epsilon(1e-11));

  std::vector<double> lambdas, gaps, rest;
  for (int k = 0; k < N; ++k) {
    const auto x = plan.x.col(k);
    const auto lambda = plan.lambda.col(k), u = plan.u.col(k);
    const lcs::Lcs& lcs = example.system;
    const Eigen::VectorXd gap = lcs.E * x + lcs.F * lambda + lcs.H * u + lcs.c;
    lambdas.insert(lambdas.end(), lambda.begin(), lambda.end());
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
  std::vector<double> expected = lambdas;
  expected.insert(expected.end(), gaps.begin(), gaps.end());
  expected.insert(expected.end(), rest.begin(), rest.end());
  const Eigen::VectorXd s = condensed.J * v + condensed.c;
  REQUIRE(s.size() == static_cast<Eigen::Index>(expected.size()));
  const Eigen::VectorXd of_plan = Eigen::Map<Eigen::VectorXd>(expected.data(), s.size());
  CHECK((s - of_plan).lpNorm<Eigen::Infinity>() <
        1e-11 * (1.0 + of_plan.lpNorm<Eigen::Infinity>()));
}

TEST_CASE("feedback keeps an unstable system's condensed problem from growing with the horizon") {
  for (const double growth : {0.0, 2.0}) {
    Example example(5);
    example.system.A += growth * Eigen::MatrixXd::Identity(3, 3);
    example.problem.sizes.N = 40;
    example.problem.x_desired = Eigen::MatrixXd::Zero(3, 41);
    const horizon::Condensed condensed = horizon::condense(example.problem);
    CHECK(condensed.J.cwiseAbs().maxCoeff() < 1e3);
    CHECK(condensed.H.cwiseAbs().maxCoeff() < 1e6);
  }
}

TEST_CASE("the plan of given modes of an unstable system meets them over a long horizon") {
  // x⁺ = 2 x + ½ u, a contact that is never touched: u by the Riccati recursion, in closed form
  lcs::Lcs system{Eigen::MatrixXd::Constant(1, 1, 2.0), Eigen::MatrixXd::Constant(1, 1, 0.5),
                  Eigen::MatrixXd::Constant(1, 1, 0.1), Eigen::VectorXd::Zero(1),
                  Eigen::MatrixXd::Constant(1, 1, 1.0), Eigen::MatrixXd::Constant(1, 1, 1.0),
                  Eigen::MatrixXd::Zero(1, 1),          Eigen::VectorXd::Constant(1, 5.0)};
  c3::Costs costs;
  costs.Q = Eigen::MatrixXd(Eigen::MatrixXd::Identity(1, 1));
  costs.R = Eigen::MatrixXd(Eigen::MatrixXd::Constant(1, 1, 0.1));
  costs.Q_N = 2.0 * costs.Q[0];
  const c3::Constraints none;
  for (const int N : {5, 60, 200}) {
    double P = 2.0, gain = 0.0;
    for (int k = 0; k < N; ++k) {
      gain = 0.5 * P * 2.0 / (0.1 + 0.25 * P);
      P = 1.0 + 4.0 * P - gain * gain * (0.1 + 0.25 * P);
    }
    const horizon::Problem problem{{1, 1, 1, N},
                                   {&system, 0},
                                   &costs,
                                   &none,
                                   Eigen::MatrixXd::Zero(1, N + 1),
                                   Eigen::VectorXd::Ones(1)};
    const auto plan = horizon::solve_modes(problem, enumerate(0, N));
    REQUIRE(plan);
    CHECK(plan->objective == Approx(P).epsilon(1e-10));
    CHECK(plan->u(0, 0) == Approx(-gain).epsilon(1e-8));
    CHECK(horizon::residual(problem, *plan) < 1e-12);
  }
}

TEST_CASE("a plan's residual sees whatever it does not meet") {
  Example example(7);
  example.constraints.u_min = Eigen::VectorXd::Constant(2, -1.0);
  const auto met = horizon::solve_modes(example.problem, enumerate(0, 6));
  REQUIRE(met);
  CHECK(horizon::residual(example.problem, *met) <= horizon::kMet);
  for (const auto& spoil : std::vector<void (*)(horizon::Plan&)>{
           [](horizon::Plan& plan) { plan.x(1, 2) += 1e-6; },
           [](horizon::Plan& plan) { plan.u(0, 1) = -1.001; },
           [](horizon::Plan& plan) { plan.lambda(0, 0) = -1e-6; },
           [](horizon::Plan& plan) { plan.lambda(1, 2) = NAN; }}) {
    horizon::Plan spoilt = *met;
    spoil(spoilt);
    CHECK(horizon::residual(example.problem, spoilt) > horizon::kMet);
  }
}

TEST_CASE("the plan of given modes meets them, and no small step that keeps them is cheaper") {
  int met = 0, compared = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Example example(seed);
    example.constraints.u_min = Eigen::VectorXd::Constant(2, -1.0);
    const horizon::Condensed condensed = horizon::condense(example.problem);
    support::Random random(seed + 100);
    const auto zero = enumerate(static_cast<unsigned>(random.index(64)), condensed.n_pairs);
    const auto plan = horizon::solve_modes(example.problem, zero);
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
  CHECK_FALSE(horizon::solve_modes(example.problem, enumerate(0, condensed.n_pairs)));
}

TEST_CASE("an equality among the constraints is met") {
  Example example(4);
  example.constraints.x_N_min = Eigen::Vector3d(0.1, -std::numeric_limits<double>::infinity(), -50);
  example.constraints.x_N_max = Eigen::Vector3d(0.1, std::numeric_limits<double>::infinity(), 50);
  const horizon::Condensed condensed = horizon::condense(example.problem);
  REQUIRE(condensed.equalities.size() == 1);
  int met = 0;
  for (unsigned mode = 0; mode < 64; ++mode) {
    const auto plan = horizon::solve_modes(example.problem, enumerate(mode, condensed.n_pairs));
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
    const auto plan = horizon::solve_modes(problem, open);
    if (!plan) continue;
    const auto again = horizon::solve_modes(problem, horizon::modes(problem, *plan));
    REQUIRE(again);
    CHECK(again->objective == Approx(plan->objective).epsilon(1e-9));
  }
}
