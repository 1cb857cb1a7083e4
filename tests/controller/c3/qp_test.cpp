#include "controller/c3/qp.hpp"

#include <limits>
#include <stdexcept>
#include <vector>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Problem {
  Sizes sizes;
  std::vector<lcs::Lcs> lcs;  // one per stage
  Costs costs;
  double rho;
  VectorXd x0;
  MatrixXd x_desired, r;
};

struct Answer {
  MatrixXd z;
  VectorXd x_N;
};

/// The whole KKT system, dense, in long double.
Answer reference(const Problem& p) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  const int n_x = p.sizes.n_x, n_z = p.sizes.n_z(), N = p.sizes.N;
  const int n = N * n_z + n_x, m = (N + 1) * n_x;
  Matrix kkt = Matrix::Zero(n + m, n + m);
  Vector right = Vector::Zero(n + m);
  for (int k = 0; k < N; ++k) {
    MatrixXd stage = p.rho * p.costs.G[k];
    stage.topLeftCorner(n_x, n_x) += p.costs.Q[k];
    stage.bottomRightCorner(p.sizes.n_u, p.sizes.n_u) += p.costs.R[k];
    kkt.block(k * n_z, k * n_z, n_z, n_z) = stage.cast<long double>();
    right.segment(k * n_z, n_z) = (p.rho * p.costs.G[k] * p.r.col(k)).cast<long double>();
    right.segment(k * n_z, n_x) += (p.costs.Q[k] * p.x_desired.col(k)).cast<long double>();
    MatrixXd step(n_x, n_z);
    step << p.lcs[k].A, p.lcs[k].D, p.lcs[k].B;
    kkt.block(n + (k + 1) * n_x, k * n_z, n_x, n_z) = step.cast<long double>();
    right.segment(n + (k + 1) * n_x, n_x) = -p.lcs[k].d.cast<long double>();
  }
  kkt.block(N * n_z, N * n_z, n_x, n_x) = p.costs.Q_N.cast<long double>();
  right.segment(N * n_z, n_x) = (p.costs.Q_N * p.x_desired.col(N)).cast<long double>();
  for (int k = 0; k <= N; ++k) {  // −x_k of the rows above; row 0: −x_0 = −x0
    kkt.block(n + k * n_x, k * n_z, n_x, n_x) -= Matrix::Identity(n_x, n_x);
  }
  right.segment(n, n_x) = -p.x0.cast<long double>();
  kkt.topRightCorner(n, m) = kkt.bottomLeftCorner(m, n).transpose();
  const VectorXd solution = kkt.partialPivLu().solve(right).cast<double>();
  Answer answer{MatrixXd(n_z, N), solution.segment(N * n_z, n_x)};
  for (int k = 0; k < N; ++k) answer.z.col(k) = solution.segment(k * n_z, n_z);
  return answer;
}

Problem ball(rolling_ball::Phase phase, double rho, double gap) {
  support::Random random(21);
  const VectorXd x = rolling_ball::state(gap);
  const lcs::Lcs lcs = rolling_ball::lcs(x);
  const Sizes sizes = rolling_ball::sizes();
  Problem p{sizes, std::vector<lcs::Lcs>(sizes.N, lcs), rolling_ball::costs(phase), rho, x,
            rolling_ball::x_desired(x), MatrixXd::Zero(sizes.n_z(), sizes.N)};
  p.r = random.matrix(sizes.n_z(), sizes.N);
  p.r.middleRows(sizes.n_x, sizes.n_lambda) *= 1000.0;  // scaled forces are of this size
  return p;
}

Problem random_problem(unsigned seed) {
  support::Random random(seed);
  const Sizes s{1 + random.index(6), 1 + random.index(6), 1 + random.index(3), 1 + random.index(8)};
  Problem p{s, {}, {}, 0.3, random.vector(s.n_x), random.matrix(s.n_x, s.N + 1),
            random.matrix(s.n_z(), s.N)};
  for (int k = 0; k < s.N; ++k) {
    p.lcs.push_back({random.matrix(s.n_x, s.n_x), random.matrix(s.n_x, s.n_u),
                     random.matrix(s.n_x, s.n_lambda), random.vector(s.n_x),
                     random.matrix(s.n_lambda, s.n_x), random.matrix(s.n_lambda, s.n_lambda),
                     random.matrix(s.n_lambda, s.n_u), random.vector(s.n_lambda)});
  }
  const auto definite = [&](int n) {
    const MatrixXd half = random.matrix(n, n);
    return MatrixXd(half * half.transpose() + 0.1 * MatrixXd::Identity(n, n));
  };
  p.costs = {definite(s.n_x), definite(s.n_x), definite(s.n_u), definite(s.n_z()),
             definite(s.n_z())};
  return p;
}

Answer solve(QpStep& qp, const Problem& p, const Constraints& bounds = {}) {
  qp.set_costs(p.costs, bounds);
  qp.start({p.lcs.data(), 1}, {p.costs.G.data(), 0}, nullptr);
  Answer answer{MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
  const QpReport report = qp.solve(p.rho, p.x0, p.x_desired, p.costs.G[0] * p.r, answer.z, answer.x_N);
  CAPTURE(report.iterations, report.residual);
  CHECK(report.status == QpStatus::kSolved);
  return answer;
}

/// Largest error beside the largest entry of each kind: states, forces and inputs differ in size.
double error(const Problem& p, const Answer& got, const Answer& expected) {
  const auto relative = [](const MatrixXd& a, const MatrixXd& b) {
    return (a - b).cwiseAbs().maxCoeff() / std::max(1e-3, b.cwiseAbs().maxCoeff());
  };
  const int n_x = p.sizes.n_x, n_lambda = p.sizes.n_lambda, n_u = p.sizes.n_u;
  return std::max({relative(got.z.topRows(n_x), expected.z.topRows(n_x)),
                   relative(got.z.middleRows(n_x, n_lambda), expected.z.middleRows(n_x, n_lambda)),
                   relative(got.z.bottomRows(n_u), expected.z.bottomRows(n_u)),
                   relative(got.x_N, expected.x_N)});
}

const OsqpSettings kPrecise{50000, 1e-9, 0.1, 50, true};

}  // namespace

TEST_CASE("direct QP: on random time-varying problems it is the dense KKT system's solution") {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Problem p = random_problem(seed);
    CAPTURE(seed, p.sizes.n_x, p.sizes.n_lambda, p.sizes.n_u, p.sizes.N);
    const Answer expected = reference(p);
    CHECK(error(p, solve(*make_direct_qp(p.sizes), p), expected) < 1e-10);
  }
}

TEST_CASE("OSQP: on random time-varying problems it is the dense KKT system's solution") {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Problem p = random_problem(seed);
    CAPTURE(seed, p.sizes.n_x, p.sizes.n_lambda, p.sizes.n_u, p.sizes.N);
    const Answer expected = reference(p);
    CHECK(error(p, solve(*make_osqp_qp(p.sizes, kPrecise), p), expected) < 1e-6);
  }
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
    qp->start({problem.lcs.data(), 1}, {problem.costs.G.data(), 0}, nullptr);
    answers[i] = {MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
    for (const double rho : {0.3, 0.9}) {
      (void)qp->solve(rho, problem.x0, problem.x_desired, problem.costs.G[0] * problem.r, answers[i].z, answers[i].x_N);
    }
  }
  REQUIRE(answers[0].z == answers[2].z);
  REQUIRE(answers[0].x_N == answers[2].x_N);
  REQUIRE(answers[0].z != answers[1].z);
}

TEST_CASE("OSQP: an active bound holds and every free direction is optimal") {
  Problem p = random_problem(8);
  const Answer free = solve(*make_osqp_qp(p.sizes, kPrecise), p);
  Constraints bounds;
  const double limit = 0.5 * free.z.bottomRows(p.sizes.n_u).cwiseAbs().maxCoeff();
  bounds.u_min = VectorXd::Constant(p.sizes.n_u, -limit);
  bounds.u_max = VectorXd::Constant(p.sizes.n_u, limit);
  const Answer bounded = solve(*make_osqp_qp(p.sizes, kPrecise), p, bounds);
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
      const VectorXd e = x - p.x_desired.col(k), g = z - p.r.col(k), u_k = p.sizes.u(z);
      sum += e.dot(p.costs.Q[k] * e) + u_k.dot(p.costs.R[k] * u_k) + p.rho * g.dot(p.costs.G[k] * g);
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
  const Problem p = random_problem(3);
  REQUIRE(p.sizes.N > 1);
  Constraints bounds;
  bounds.x_min = VectorXd::Constant(p.sizes.n_x, 1e4);
  bounds.x_max = VectorXd::Constant(p.sizes.n_x, 2e4);
  bounds.u_min = VectorXd::Constant(p.sizes.n_u, -1.0);
  bounds.u_max = -bounds.u_min[0];
  bounds.lambda_min = VectorXd::Constant(p.sizes.n_lambda, -1.0);
  bounds.lambda_max = -bounds.lambda_min[0];
  const auto qp = make_osqp_qp(p.sizes, {20000, 1e-6, 0.1, 50, false});
  qp->set_costs(p.costs, bounds);
  qp->start({p.lcs.data(), 1}, {p.costs.G.data(), 0}, nullptr);
  MatrixXd z(p.sizes.n_z(), p.sizes.N);
  VectorXd x_N(p.sizes.n_x);
  REQUIRE(qp->solve(p.rho, p.x0, p.x_desired, p.r, z, x_N).status == QpStatus::kInfeasible);
}
