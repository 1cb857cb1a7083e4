#include "controller/qp/qp.hpp"

#include <limits>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "tests/controller/qp/qp_problem.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::qp;
using namespace qp_problem;

namespace {

const OsqpSettings kPrecise{50000, 1e-9, 0.1, 50, true};

Problem with_fixed_lambda_0(unsigned seed) {
  Problem p = random_problem(seed);
  p.fixes_lambda_0 = true;
  p.lambda_0 = support::Random(seed + 500).vector(p.sizes.n_lambda);
  return p;
}

}  // namespace

TEST_CASE("direct QP: on random time-varying problems it is the KKT system's solution") {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Problem p = random_problem(seed);
    CAPTURE(seed, p.sizes.n_x, p.sizes.n_lambda, p.sizes.n_u, p.sizes.N);
    const Reference expected = reference(p);
    CHECK(error(p, solve(*make_direct_qp(p.sizes), p), expected) < 1e-10);
  }
}

TEST_CASE("OSQP: on random time-varying problems it is the KKT system's solution") {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Problem p = random_problem(seed);
    CAPTURE(seed, p.sizes.n_x, p.sizes.n_lambda, p.sizes.n_u, p.sizes.N);
    const Reference expected = reference(p);
    CHECK(error(p, solve(*make_osqp_qp(p.sizes, kPrecise), p), expected) < 1e-6);
  }
}

TEST_CASE("direct QP, OSQP: a fixed lambda_0 stays where it is and the rest is optimal") {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const Problem p = with_fixed_lambda_0(seed);
    CAPTURE(seed, p.sizes.n_x, p.sizes.n_lambda, p.sizes.n_u, p.sizes.N);
    const Reference expected = reference(p);
    const Answer direct = solve(*make_direct_qp(p.sizes), p);
    CHECK(p.sizes.lambda(direct.z.col(0)) == p.lambda_0);
    CHECK(error(p, direct, expected) < 1e-10);
    CHECK(error(p, solve(*make_osqp_qp(p.sizes, kPrecise), p), expected) < 1e-6);
  }
}

TEST_CASE("OSQP: a fixed lambda_0 is not bounded") {
  Problem p = with_fixed_lambda_0(5);
  p.lambda_0.setConstant(-3.0);
  p.constraints.lambda_min = VectorXd::Zero(p.sizes.n_lambda);
  const Answer answer = solve(*make_osqp_qp(p.sizes, kPrecise), p);
  REQUIRE(answer.report.status == QpStatus::kSolved);
  REQUIRE((p.sizes.lambda(answer.z.col(0)) - p.lambda_0).cwiseAbs().maxCoeff() < 1e-6);
  REQUIRE(answer.z.rightCols(p.sizes.N - 1).middleRows(p.sizes.n_x, p.sizes.n_lambda).minCoeff() >
          -1e-6);
}

TEST_CASE("OSQP: bounds of the last state and rows hold, and those of x alone not at k = 0") {
  Problem p = random_problem(8);
  const Answer free = solve(*make_osqp_qp(p.sizes, kPrecise), p);
  MatrixXd C = MatrixXd::Zero(2, p.sizes.n_z());
  C(0, 0) = 1.0;  // a state alone: x_0 may be beyond it
  C(1, 0) = C(1, p.sizes.n_z() - 1) = 1.0;
  p.constraints.C = C;
  p.constraints.C_min = Eigen::Vector2d(p.x0[0] + 0.5, -kNone);
  p.constraints.C_max = Eigen::Vector2d(kNone, 0.8 * (C.row(1) * free.z).minCoeff() - 0.1);
  p.constraints.x_N_max = free.x_N.array() - 0.1;
  const Answer answer = solve(*make_osqp_qp(p.sizes, kPrecise), p);
  const Reference expected = reference(p, &answer);
  CAPTURE(expected.active);
  REQUIRE(answer.report.status == QpStatus::kSolved);
  REQUIRE((C.row(1) * answer.z).maxCoeff() < p.constraints.C_max[0][1] + 1e-6);
  REQUIRE(expected.active > 2);
  REQUIRE(error(p, answer, expected) < 1e-6);
  REQUIRE(expected.wrong < 1e-6);
}

TEST_CASE("direct QP: the ball's problem, weights from 1e-7 to 1e9, is solved to 1e-6") {
  for (const auto phase : {rolling_ball::Phase::kRoll, rolling_ball::Phase::kReturn}) {
    for (const double rho : {1.0, 4.84}) {
      for (const double gap : {-0.0005, 0.01}) {
        const Problem p = ball(phase, rho, gap);
        CAPTURE(static_cast<int>(phase), rho, gap);
        CHECK(error(p, solve(*make_direct_qp(p.sizes), p), reference(p)) < 1e-6);
      }
    }
  }
}

TEST_CASE("OSQP: the ball's problem with the rolling weights is solved to 1e-6") {
  const Problem p = ball(rolling_ball::Phase::kRoll, 1.0, 0.002);
  REQUIRE(error(p, solve(*make_osqp_qp(p.sizes, kPrecise), p), reference(p)) < 1e-6);
}

TEST_CASE("direct QP: another penalty, another problem, then the first again gives the same bits") {
  const Problem p = ball(rolling_ball::Phase::kReturn, 1.0, 0.002);
  const auto qp = make_direct_qp(p.sizes);
  const Answer first = solve(*qp, p);
  (void)solve(*qp, ball(rolling_ball::Phase::kRoll, 3.0, 0.01));
  const Answer again = solve(*qp, p);
  REQUIRE(first.z == again.z);
  REQUIRE(first.x_N == again.x_N);
}

TEST_CASE("OSQP: another problem in between leaves no trace in the bits") {
  const Problem p = random_problem(5);
  Problem other = p;
  other.x0 *= 30.0;
  for (lcs::Lcs& lcs : other.lcs) lcs.A *= 0.3, lcs.D *= 40.0;
  const auto qp = make_osqp_qp(p.sizes, kPrecise);
  qp->set_costs(p.costs, {});
  Answer answers[3];
  for (int i = 0; i < 3; ++i) {
    const Problem& problem = i == 1 ? other : p;
    qp->start({problem.lcs.data(), 1}, {problem.W.data(), 1}, nullptr);
    answers[i] = {{}, MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
    for (const double rho : {0.3, 0.9}) {
      (void)qp->solve(rho, problem.x0, problem.x_desired, problem.g, answers[i].z, answers[i].x_N);
    }
  }
  REQUIRE(answers[0].z == answers[2].z);
  REQUIRE(answers[0].x_N == answers[2].x_N);
  REQUIRE(answers[0].z != answers[1].z);
}

TEST_CASE("OSQP: an active bound holds and every free direction is optimal") {
  Problem p = random_problem(8);
  const Answer free = solve(*make_osqp_qp(p.sizes, kPrecise), p);
  const double limit = 0.5 * free.z.bottomRows(p.sizes.n_u).cwiseAbs().maxCoeff();
  p.constraints.u_min = VectorXd::Constant(p.sizes.n_u, -limit);
  p.constraints.u_max = VectorXd::Constant(p.sizes.n_u, limit);
  const Answer bounded = solve(*make_osqp_qp(p.sizes, kPrecise), p);
  REQUIRE(bounded.report.status == QpStatus::kSolved);
  const MatrixXd u = bounded.z.bottomRows(p.sizes.n_u);
  REQUIRE(u.cwiseAbs().maxCoeff() <= limit * (1.0 + 1e-6));
  REQUIRE(u.cwiseAbs().maxCoeff() >= limit * (1.0 - 1e-6));

  // no feasible change of u lowers the cost: roll out random ones, with λ kept
  const auto cost = [&](const MatrixXd& z_of_inputs) {
    double sum = 0.0;
    VectorXd x = p.x0, z(p.sizes.n_z());
    for (int k = 0; k < p.sizes.N; ++k) {
      z = z_of_inputs.col(k);
      p.sizes.x(z) = x;
      const VectorXd e = x - p.x_desired.col(k), u_k = p.sizes.u(z);
      sum += e.dot(p.costs.Q[k] * e) + u_k.dot(p.costs.R[k] * u_k);
      sum += p.rho * (z.dot(p.W[k] * z) - 2.0 * p.g.col(k).dot(z));
      x = p.lcs[k].A * x + p.lcs[k].B * u_k + p.lcs[k].D * p.sizes.lambda(z) + p.lcs[k].d;
    }
    const VectorXd e = x - p.x_desired.col(p.sizes.N);
    return sum + e.dot(p.costs.Q_N * e);
  };
  const double least = cost(bounded.z);
  support::Random random(9);
  for (int trial = 0; trial < 200; ++trial) {
    MatrixXd z = bounded.z;
    z.bottomRows(p.sizes.n_u) += 0.1 * limit * random.matrix(p.sizes.n_u, p.sizes.N);
    z.bottomRows(p.sizes.n_u) = z.bottomRows(p.sizes.n_u).cwiseMin(limit).cwiseMax(-limit);
    CHECK(cost(z) >= least - 1e-6 * std::abs(least));
  }
}

TEST_CASE("direct QP: start and solve do not allocate") {
  if (!support::AllocationCounter::counts()) return;  // a sanitizer owns malloc
  for (const unsigned seed : {5u, 11u}) {
    for (const bool fixed : {false, true}) {
      const Problem p = fixed ? with_fixed_lambda_0(seed) : random_problem(seed);
      const auto qp = make_direct_qp(p.sizes);
      qp->set_costs(p.costs, {});
      Answer answer{{}, MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
      const support::AllocationCounter counter;
      qp->start({p.lcs.data(), 1}, {p.W.data(), 1}, fixed ? &p.lambda_0 : nullptr);
      for (const double rho : {0.3, 0.9}) {
        answer.report = qp->solve(rho, p.x0, p.x_desired, p.g, answer.z, answer.x_N);
      }
      const auto calls = counter.count();
      CHECK(answer.report.status == QpStatus::kSolved);
      CHECK(calls == 0);
    }
  }
}

TEST_CASE("direct QP: bounds are refused, infinite ones are none") {
  const Problem p = random_problem(1);
  const auto qp = make_direct_qp(p.sizes);
  Constraints bounds;
  bounds.u_max = VectorXd::Constant(p.sizes.n_u, std::numeric_limits<double>::infinity());
  REQUIRE_NOTHROW(qp->set_costs(p.costs, bounds));
  bounds.u_max[0][0] = 1.0;
  REQUIRE_THROWS_AS(qp->set_costs(p.costs, bounds), std::invalid_argument);
}

TEST_CASE("OSQP: bounds that contradict the dynamics are infeasible, not an answer") {
  Problem p = random_problem(3);
  REQUIRE(p.sizes.N > 1);
  Constraints& bounds = p.constraints;
  bounds.x_min = VectorXd::Constant(p.sizes.n_x, 1e4);
  bounds.x_max = VectorXd::Constant(p.sizes.n_x, 2e4);
  bounds.u_min = VectorXd::Constant(p.sizes.n_u, -1.0);
  bounds.u_max = -bounds.u_min[0];
  bounds.lambda_min = VectorXd::Constant(p.sizes.n_lambda, -1.0);
  bounds.lambda_max = -bounds.lambda_min[0];
  const auto qp = make_osqp_qp(p.sizes, {20000, 1e-6, 0.1, 50, false});
  REQUIRE(solve(*qp, p).report.status == QpStatus::kInfeasible);
}
