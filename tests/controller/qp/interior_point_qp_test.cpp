#include "controller/qp/interior_point_qp.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "tests/controller/qp/qp_problem.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::qp;
using namespace qp_problem;

namespace {

const OsqpSettings kPrecise{50000, 1e-10, 0.1, 50, true};

/// Where inputs drawn at random lead: a point that the constraints are then laid around.
Answer random_point(const Problem& p, unsigned seed) {
  support::Random random(seed);
  Answer a{{}, random.matrix(p.sizes.n_z(), p.sizes.N), p.x0};
  for (int k = 0; k < p.sizes.N; ++k) {
    if (k == 0 && p.fixes_lambda_0) p.sizes.lambda(a.z.col(0)) = p.lambda_0;
    p.sizes.x(a.z.col(k)) = a.x_N;
    a.x_N = p.lcs[k].A * a.x_N + p.lcs[k].B * p.sizes.u(a.z.col(k)) +
            p.lcs[k].D * p.sizes.lambda(a.z.col(k)) + p.lcs[k].d;
  }
  return a;
}

/// Time-varying systems and weights, every kind of constraint, now and then λ_0 fixed.
Problem constrained(unsigned seed) {
  Problem p = random_problem(seed);
  if (seed % 7 == 3) {
    p.fixes_lambda_0 = true;
    p.lambda_0 = VectorXd::Constant(p.sizes.n_lambda, 0.2);
  }
  const Answer point = random_point(p, seed + 1000);
  constrain(p, point.z, point.x_N, seed);
  return p;
}

Problem bounded_ball() {
  Problem p = ball(rolling_ball::Phase::kRoll, 1.0, 0.002);
  const Answer free = solve(*make_direct_qp(p.sizes), p);
  const double limit = 0.3 * free.z.bottomRows(3).cwiseAbs().maxCoeff();
  p.constraints.u_min = VectorXd::Constant(3, -limit);
  p.constraints.u_max = VectorXd::Constant(3, limit);
  p.constraints.lambda_min = VectorXd::Zero(12);
  return p;
}

/// A mass with a reference far beyond a bound of its position: it stays there over most of the
/// horizon, and where the bound begins and ends to be active has to be found.
Problem mass_at_a_wall(int N, double step) {
  const Sizes s{2, 1, 1, N};
  lcs::Lcs system{MatrixXd::Identity(2, 2), MatrixXd::Zero(2, 1), MatrixXd::Zero(2, 1),
                  VectorXd::Zero(2),        MatrixXd::Zero(1, 2), MatrixXd::Identity(1, 1),
                  MatrixXd::Zero(1, 1),     VectorXd::Zero(1)};
  system.A(0, 1) = step;
  system.B(1, 0) = step;
  Problem p{s, std::vector<lcs::Lcs>(N, system), {}, {}, 1.0, VectorXd::Zero(2), {}, {}};
  MatrixXd Q = MatrixXd::Zero(2, 2);
  Q(0, 0) = 10.0;
  p.costs = {Q, Q, MatrixXd::Constant(1, 1, 0.1), MatrixXd(1e-3 * MatrixXd::Identity(4, 4)), {}};
  p.x_desired = MatrixXd::Zero(2, N + 1);
  // rising, then back to zero, as far beyond the wall as it is away
  for (int k = 0; k <= N; ++k) p.x_desired(0, k) = 2.0 * std::sin(M_PI * k / N);
  consensus(p, MatrixXd::Zero(4, N));
  p.constraints.x_max = VectorXd(2);
  p.constraints.x_max[0] << 1.0, kNone;
  return p;
}

}  // namespace

TEST_CASE("interior point: the ends of a long active bound are found in a few corrections") {
  for (const int N : {20, 40, 80}) {
    const Problem p = mass_at_a_wall(N, 4.0 / N);
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Reference expected = reference(p, &answer);
    CAPTURE(N, answer.report.iterations, expected.active);
    CHECK(answer.report.status == QpStatus::kSolved);
    CHECK(error(p, answer, expected) < 1e-9);
    CHECK(expected.active > N / 6);
    CHECK(answer.report.iterations <= 5);
  }
}

TEST_CASE(
    "interior point: its answer to any constraints solves the KKT system of its own active rows") {
  int active = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const Problem p = constrained(seed);
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Reference expected = reference(p, &answer);
    CAPTURE(seed, answer.report.iterations, answer.report.dual_residual, expected.active);
    CHECK(answer.report.status == QpStatus::kSolved);
    CHECK(error(p, answer, expected) < 1e-9);
    CHECK(expected.wrong < 1e-8);
    active += expected.active;
  }
  REQUIRE(active > 1000);
}

TEST_CASE("interior point: OSQP, however precise, finds the same") {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Problem p = constrained(seed);
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Answer osqp = solve(*make_osqp_qp(p.sizes, kPrecise), p);
    CAPTURE(seed, answer.report.iterations, answer.report.dual_residual, osqp.report.iterations);
    CHECK(answer.report.status == QpStatus::kSolved);
    CHECK(osqp.report.status == QpStatus::kSolved);
    CHECK(error(p, answer, osqp) < 1e-6);
  }
}

TEST_CASE("interior point: weights that differ by up to 1e8 between coordinates are no obstacle") {
  for (unsigned seed = 0; seed < 100; ++seed) {
    Problem p = constrained(seed);
    support::Random random(seed + 9);
    const auto scale = [&](MatrixXd& weight) {
      for (Eigen::Index i = 0; i < weight.rows(); ++i) {
        const double factor = std::pow(10.0, 2.0 * random.uniform());
        weight.row(i) *= factor;
        weight.col(i) *= factor;
      }
    };
    for (int k = 0; k < p.sizes.N; ++k) {
      scale(p.costs.Q[k]);
      scale(p.costs.R[k]);
      scale(p.W[k]);
    }
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Reference expected = reference(p, &answer);
    CAPTURE(seed, answer.report.iterations, answer.report.dual_residual, expected.active);
    CHECK(answer.report.status == QpStatus::kSolved);
    CHECK(error(p, answer, expected) < 1e-8);
    CHECK(expected.wrong < 1e-7);
  }
}

TEST_CASE("interior point: equal bounds are met, alone and beside others") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    Problem p = constrained(seed);
    const Answer point = random_point(p, seed + 1000);
    // the last state where the point's is, as far as the inputs are enough to lead there
    p.constraints.x_N_min = VectorXd::Constant(p.sizes.n_x, -kNone);
    p.constraints.x_N_max = VectorXd::Constant(p.sizes.n_x, kNone);
    const int fixed = std::min(p.sizes.n_x, p.sizes.n_u);
    p.constraints.x_N_min.head(fixed) = p.constraints.x_N_max.head(fixed) = point.x_N.head(fixed);
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Reference expected = reference(p, &answer);
    CAPTURE(seed, answer.report.iterations, answer.report.dual_residual, expected.active);
    CHECK(answer.report.status == QpStatus::kSolved);
    CHECK((answer.x_N - point.x_N).head(fixed).cwiseAbs().maxCoeff() < 1e-9);
    CHECK(error(p, answer, expected) < 1e-9);
    CHECK(expected.wrong < 1e-8);
  }
}

TEST_CASE("interior point: without constraints it gives the direct method's bits") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Problem p = random_problem(seed);
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Answer direct = solve(*make_direct_qp(p.sizes), p);
    CHECK(answer.z == direct.z);
    CHECK(answer.x_N == direct.x_N);
  }
}

TEST_CASE("interior point: weights from 1e-7 to 1e4 and forces of a thousand are no obstacle") {
  const Problem p = bounded_ball();
  const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
  const Reference expected = reference(p, &answer);
  CAPTURE(answer.report.iterations, answer.report.dual_residual, expected.active);
  REQUIRE(answer.report.status == QpStatus::kSolved);
  REQUIRE(expected.active > 10);
  REQUIRE(error(p, answer, expected) < 1e-6);
  REQUIRE(expected.wrong < 1e-6);
}

TEST_CASE("interior point: bounds that contradict the dynamics are recognised in every size") {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    Problem p = random_problem(seed);
    const double limit = seed % 3 == 0 ? 1.0 : seed % 3 == 1 ? 0.01 : 100.0;
    const Sizes& s = p.sizes;
    p.constraints.u_max = VectorXd::Constant(s.n_u, limit);
    p.constraints.u_min = -p.constraints.u_max[0];
    p.constraints.lambda_max = VectorXd::Constant(s.n_lambda, limit);
    p.constraints.lambda_min = -p.constraints.lambda_max[0];
    p.constraints.x_N_min = VectorXd::Constant(s.n_x, 300.0 * limit);
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Answer osqp = solve(*make_osqp_qp(p.sizes, {20000, 1e-8, 0.1, 50, false}), p);
    CAPTURE(seed, answer.report.iterations, osqp.report.iterations);
    CHECK(answer.report.status == osqp.report.status);
    infeasible += answer.report.status == QpStatus::kInfeasible;
  }
  REQUIRE(infeasible > 90);
}

TEST_CASE(
    "interior point: contradictory rows without inputs are infeasible, met ones no obstacle") {
  Problem p = random_problem(3);
  REQUIRE(p.sizes.N > 1);
  p.fixes_lambda_0 = true;
  p.lambda_0 = VectorXd::Constant(p.sizes.n_lambda, 0.5);
  MatrixXd C = MatrixXd::Zero(1, p.sizes.n_z());
  C(0, p.sizes.n_x) = 2.0;  // of λ_0 alone at k = 0
  p.constraints.C = C;
  for (const double limit : {0.9, 1.0, 1.1}) {
    p.constraints.C_max = VectorXd::Constant(1, limit);
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    const Answer osqp = solve(*make_osqp_qp(p.sizes, kPrecise), p);
    CAPTURE(limit, answer.report.iterations, answer.report.dual_residual);
    CHECK(answer.report.status == (limit < 1.0 ? QpStatus::kInfeasible : QpStatus::kSolved));
    CHECK(osqp.report.status == answer.report.status);
    if (limit >= 1.0) CHECK(error(p, answer, osqp) < 1e-6);
  }
}

TEST_CASE("interior point: the same problem gives the same bits, whatever came between") {
  const Problem p = constrained(28), other = bounded_ball();
  const auto qp = make_interior_point_qp(p.sizes);
  const auto sequence = [&](const Problem& problem) {
    qp->start({problem.lcs.data(), 1}, {problem.W.data(), 1}, nullptr);
    Answer answer{{}, MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
    for (const double rho : {0.3, 0.9, 0.9}) {
      answer.report =
          qp->solve(rho, problem.x0, problem.x_desired, problem.g, answer.z, answer.x_N);
    }
    return answer;
  };
  qp->set_costs(p.costs, p.constraints);
  const Answer first = sequence(p);
  Problem between = p;
  between.x0 *= 3.0;
  for (lcs::Lcs& lcs : between.lcs) lcs.A *= 0.3;
  const Answer second = sequence(between);
  const Answer again = sequence(p);
  REQUIRE(first.report.status == QpStatus::kSolved);
  REQUIRE(first.z == again.z);
  REQUIRE(first.x_N == again.x_N);
  REQUIRE(first.z != second.z);
}

TEST_CASE(
    "interior point: start and solve do not allocate, with active sets that are found and some "
    "that are not") {
  if (!support::AllocationCounter::counts()) return;  // a sanitizer owns malloc
  for (const unsigned seed : {4u, 7u, 28u, 10u}) {
    const Problem p = constrained(seed);
    const auto qp = make_interior_point_qp(p.sizes);
    qp->set_costs(p.costs, p.constraints);
    Answer answer{{}, MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
    const support::AllocationCounter counter;
    qp->start({p.lcs.data(), 1}, {p.W.data(), 1}, p.fixes_lambda_0 ? &p.lambda_0 : nullptr);
    for (const double rho : {0.3, 0.6}) {
      answer.report = qp->solve(rho, p.x0, p.x_desired, p.g, answer.z, answer.x_N);
    }
    const auto calls = counter.count();
    CHECK(answer.report.status == QpStatus::kSolved);
    CHECK(calls == 0);
  }
}

TEST_CASE(
    "interior point: what is beyond double precision has a status, never a NaN that looks solved") {
  for (const double scale : {1e160, 1e300}) {
    Problem p = constrained(28);
    for (lcs::Lcs& lcs : p.lcs) lcs.A *= scale, lcs.D *= scale;
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    CAPTURE(scale, static_cast<int>(answer.report.status));
    CHECK(answer.report.status != QpStatus::kSolved);
  }
}
