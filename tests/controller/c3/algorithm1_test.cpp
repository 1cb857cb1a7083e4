// What Algorithm 1 promises beside its answer: starts, traces, threads, stages that differ, C3+.
#include <algorithm>
#include <vector>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "controller/c3/solver.hpp"
#include "controller/rt/worker_pool.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
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
  VectorXd x0;
  MatrixXd x_desired;
};

MatrixXd positive_definite(support::Random& random, int size) {
  const MatrixXd m = random.matrix(size, size);
  return m * m.transpose() + 0.1 * MatrixXd::Identity(size, size);
}

/// Every stage its own system and weights; F positive definite, so that every LCP has one solution.
Problem random_problem(unsigned seed) {
  support::Random random(seed);
  const int n_x = 4, n_lambda = 3, n_u = 2, N = 4;
  Problem p{{n_x, n_lambda, n_u, N}, {}, {}, random.vector(n_x), random.matrix(n_x, N + 1)};
  const int n_z = p.sizes.n_z();
  std::vector<MatrixXd> Q, R, G;
  for (int k = 0; k < N; ++k) {
    p.lcs.push_back({0.7 * random.matrix(n_x, n_x), random.matrix(n_x, n_u),
                     random.matrix(n_x, n_lambda), 0.3 * random.vector(n_x),
                     random.matrix(n_lambda, n_x), positive_definite(random, n_lambda),
                     random.matrix(n_lambda, n_u), 0.3 * random.vector(n_lambda)});
    Q.push_back(positive_definite(random, n_x));
    R.push_back(positive_definite(random, n_u));
    G.push_back(positive_definite(random, n_z));
  }
  p.costs.Q = Q;
  p.costs.R = R;
  p.costs.G = G;
  p.costs.Q_N = positive_definite(random, n_x);
  p.costs.U = positive_definite(random, n_z);
  p.costs.convex = {positive_definite(random, n_x), positive_definite(random, n_u), 0.3, 1e-6};
  p.costs.plus = {VectorXd::Constant(n_lambda, 0.7), VectorXd::Constant(n_lambda, 0.4),
                  VectorXd::Constant(n_lambda, 1.5), VectorXd::Constant(n_lambda, 0.8)};
  return p;
}

Settings settings(ProjectionKind kind, int iterations, QpBackend qp = QpBackend::kDirect) {
  Settings made{};
  made.admm_iterations = iterations;
  made.rho = 0.5;
  made.rho_scale = 1.7;
  made.qp = qp;
  made.osqp = {20000, 1e-9, 0.1, 50, false};
  made.projection = kind;
  made.max_nodes = 10000;
  made.project_last = true;
  return made;
}

constexpr ProjectionKind kAllKinds[] = {ProjectionKind::kMiqp, ProjectionKind::kLcp,
                                        ProjectionKind::kAdmm, ProjectionKind::kConvex,
                                        ProjectionKind::kPlus};

/// g_λ and g_η of each stage (n_lambda × N).
struct PlusReferenceWeights {
  MatrixXd lambda, eta;
};
PlusReferenceWeights same_weights(const Problem& p) {
  return {p.costs.plus.g_lambda.replicate(1, p.sizes.N),
          p.costs.plus.g_eta.replicate(1, p.sizes.N)};
}

/// The QP of C3+ with η as variables of their own, as one dense KKT system:
/// v = [z_0 … z_{N−1}; x_N; η_0 … η_{N−1}].
MatrixXd plus_reference(const Problem& p, double rho, const PlusReferenceWeights& g,
                        const MatrixXd& target_of_all) {
  const auto [n_x, n_lambda, n_u, N] = p.sizes;
  const int n_z = p.sizes.n_z(), x_N = N * n_z, eta = x_N + n_x;
  const int n = eta + N * n_lambda, m = (N + 1) * n_x + N * n_lambda;
  MatrixXd kkt = MatrixXd::Zero(n + m, n + m);
  VectorXd right = VectorXd::Zero(n + m);
  for (int k = 0; k < N; ++k) {
    const int z = k * n_z, lambda = z + n_x, u = lambda + n_lambda, e = eta + k * n_lambda;
    kkt.block(z, z, n_x, n_x) = p.costs.Q[k];
    right.segment(z, n_x) = p.costs.Q[k] * p.x_desired.col(k);
    kkt.block(lambda, lambda, n_lambda, n_lambda) = rho * g.lambda.col(k).asDiagonal();
    kkt.block(u, u, n_u, n_u) = p.costs.R[k];
    kkt.block(e, e, n_lambda, n_lambda) = rho * g.eta.col(k).asDiagonal();
    const auto target = target_of_all.col(k);
    right.segment(lambda, n_lambda) = rho * g.lambda.col(k).cwiseProduct(p.sizes.lambda(target));
    right.segment(e, n_lambda) = rho * g.eta.col(k).cwiseProduct(p.sizes.eta(target));
    const int step = n + (k + 1) * n_x, gap = n + (N + 1) * n_x + k * n_lambda;
    kkt.block(step, z, n_x, n_x) = p.lcs[k].A;
    kkt.block(step, lambda, n_x, n_lambda) = p.lcs[k].D;
    kkt.block(step, u, n_x, n_u) = p.lcs[k].B;
    kkt.block(step, k + 1 < N ? z + n_z : x_N, n_x, n_x) = -MatrixXd::Identity(n_x, n_x);
    right.segment(step, n_x) = -p.lcs[k].d;
    kkt.block(gap, z, n_lambda, n_x) = p.lcs[k].E;
    kkt.block(gap, lambda, n_lambda, n_lambda) = p.lcs[k].F;
    kkt.block(gap, u, n_lambda, n_u) = p.lcs[k].H;
    kkt.block(gap, e, n_lambda, n_lambda) = -MatrixXd::Identity(n_lambda, n_lambda);
    right.segment(gap, n_lambda) = -p.lcs[k].c;
  }
  kkt.block(x_N, x_N, n_x, n_x) = p.costs.Q_N;
  right.segment(x_N, n_x) = p.costs.Q_N * p.x_desired.col(N);
  kkt.block(n, 0, n_x, n_x).setIdentity();
  right.segment(n, n_x) = p.x0;
  kkt.topRightCorner(n, m) = kkt.bottomLeftCorner(m, n).transpose();
  const VectorXd v = support::solve(kkt, right).value();
  MatrixXd out(n_z + n_lambda, N);
  for (int k = 0; k < N; ++k) {
    out.col(k) << v.segment(k * n_z, n_z), v.segment(eta + k * n_lambda, n_lambda);
  }
  return out;
}

}  // namespace

TEST_CASE("C3+: the QP with substituted gaps is the QP with gap variables, iterate by iterate") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Problem p = random_problem(seed);
    for (const QpBackend qp : {QpBackend::kDirect, QpBackend::kInteriorPoint, QpBackend::kOsqp}) {
      Settings with = settings(ProjectionKind::kPlus, 4, qp);
      with.trace = true;
      Solver solver(p.sizes, with);
      solver.set_costs(p.costs);
      const Solution& solution = solver.solve(p.lcs, p.x0, p.x_desired);
      REQUIRE(solution.status == SolveStatus::kOk);
      MatrixXd delta = MatrixXd::Zero(p.sizes.n_z() + p.sizes.n_lambda, p.sizes.N), w = delta;
      for (int i = 0; i < 4; ++i) {
        const Iterate& iterate = solution.trace[i];
        const MatrixXd reference = plus_reference(p, iterate.rho, same_weights(p), delta - w);
        CAPTURE(seed, static_cast<int>(qp), i);
        CHECK((iterate.z - reference).cwiseAbs().maxCoeff() <
              (qp == QpBackend::kOsqp ? 1e-5 : 1e-8));
        delta = iterate.delta;
        w = iterate.w;
        for (int k = 0; k < p.sizes.N; ++k) {  // on the product of the L shapes
          const VectorXd lambda = p.sizes.lambda(delta.col(k)), eta = p.sizes.eta(delta.col(k));
          CHECK(lambda.minCoeff() >= 0.0);
          CHECK(eta.minCoeff() >= 0.0);
          CHECK(lambda.cwiseProduct(eta).isZero(0.0));
        }
      }
    }
  }
}

TEST_CASE(
    "C3+: with a final scale the last QP goes towards δ itself, and harder where a side is zero") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    Problem p = random_problem(seed);
    p.costs.plus.final_scale = VectorXd::LinSpaced(p.sizes.n_lambda, 1.0, 1000.0);
    for (const bool one_system : {false, true}) {
      if (one_system) {
        for (lcs::Lcs& lcs : p.lcs) lcs = p.lcs[0];
      }
      for (const QpBackend qp : {QpBackend::kDirect, QpBackend::kInteriorPoint}) {
        Settings with = settings(ProjectionKind::kPlus, 3, qp);
        with.trace = true;
        with.project_last = false;
        Solver solver(p.sizes, with);
        solver.set_costs(p.costs);
        // a solve before must leave nothing behind
        const auto solve = [&]() -> const Solution& {
          return one_system ? solver.solve(p.lcs[0], p.x0, p.x_desired)
                            : solver.solve(p.lcs, p.x0, p.x_desired);
        };
        solve();
        const Solution& solution = solve();
        REQUIRE(solution.status == SolveStatus::kOk);
        CAPTURE(seed, one_system, static_cast<int>(qp));
        const Iterate &before = solution.trace[1], &last = solution.trace[2];
        const MatrixXd earlier = plus_reference(p, before.rho, same_weights(p),
                                                solution.trace[0].delta - solution.trace[0].w);
        CHECK((before.z - earlier).cwiseAbs().maxCoeff() < 1e-8);
        PlusReferenceWeights g = same_weights(p);
        for (int k = 0; k < p.sizes.N; ++k) {
          const VectorXd lambda = p.sizes.lambda(before.delta.col(k));
          for (int i = 0; i < p.sizes.n_lambda; ++i)
            (lambda[i] == 0.0 ? g.lambda : g.eta)(i, k) *= p.costs.plus.final_scale[i];
        }
        const MatrixXd reference = plus_reference(p, last.rho, g, before.delta);
        CHECK((last.z - reference).cwiseAbs().maxCoeff() < 1e-7);
      }
    }
  }
}

TEST_CASE(
    "C3+: a large final scale draws each pair's zero side to zero, as far as the other goes") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    Problem p = random_problem(seed);
    Settings with = settings(ProjectionKind::kPlus, 5);
    with.project_last = false;
    Solver solver(p.sizes, with);
    // of all pairs the largest distance from both axes; a force or a gap may still be negative
    const auto farthest = [&] {
      solver.set_costs(p.costs);
      const Solution& solution = solver.solve(p.lcs, p.x0, p.x_desired);
      double largest = 0.0;
      for (int k = 0; k < p.sizes.N; ++k) {
        const VectorXd lambda = p.sizes.lambda(solution.z.col(k)),
                       eta = p.sizes.eta(solution.z.col(k));
        largest = std::max(largest, lambda.cwiseAbs().cwiseMin(eta.cwiseAbs()).maxCoeff());
      }
      return largest;
    };
    const double without = farthest();
    p.costs.plus.final_scale = VectorXd::Constant(p.sizes.n_lambda, 1e6);
    const double scaled = farthest();
    CAPTURE(seed, without, scaled);
    CHECK(without > 1e-2);
    CHECK(scaled < 1e-3);
  }
}

TEST_CASE("C3+: a final scale below 1 is refused by its name") {
  Problem p = random_problem(0);
  Solver solver(p.sizes, settings(ProjectionKind::kPlus, 2));
  p.costs.plus.final_scale = VectorXd::Constant(p.sizes.n_lambda, 0.5);
  CHECK_THROWS_WITH(solver.set_costs(p.costs), Catch::Contains("plus.final_scale[0]") &&
                                                   Catch::Contains("1 or more") &&
                                                   Catch::Contains("0.5"));
}

TEST_CASE("solver: the trace holds Algorithm 1's recursion, its residuals and violations") {
  const Problem p = random_problem(7);
  for (const ProjectionKind kind : kAllKinds) {
    Settings with = settings(kind, 5);
    with.trace = true;
    Solver solver(p.sizes, with);
    solver.set_costs(p.costs);
    const Solution& solution = solver.solve(p.lcs, p.x0, p.x_desired);
    CAPTURE(static_cast<int>(kind));
    REQUIRE(solution.status == SolveStatus::kOk);
    REQUIRE(solution.trace.size() == 5);
    MatrixXd delta = MatrixXd::Zero(solver.n_copy(), p.sizes.N), w = delta;
    double rho = with.rho;
    for (const Iterate& iterate : solution.trace) {
      CHECK(iterate.rho == Approx(rho));
      CHECK(iterate.projections == p.sizes.N);
      const MatrixXd w_expected = (w + iterate.z - iterate.delta) / with.rho_scale;
      CHECK((iterate.w - w_expected).isZero(1e-12));
      CHECK(iterate.primal_residual == Approx((iterate.z - iterate.delta).norm()));
      CHECK(iterate.dual_residual == Approx(rho * (iterate.delta - delta).norm()));
      delta = iterate.delta;
      w = iterate.w;
      rho *= with.rho_scale;
    }
    const Iterate& last = solution.trace.back();
    CHECK(last.z == solution.z);
    CHECK(last.x_N == solution.x_N);
    CHECK(last.complementarity_violation == solution.complementarity_violation);
    double worst = 0.0;
    for (int k = 0; k < p.sizes.N; ++k) {
      const auto z = solution.z.col(k);
      const VectorXd y = p.lcs[k].E * p.sizes.x(z) + p.lcs[k].F * p.sizes.lambda(z) +
                         p.lcs[k].H * p.sizes.u(z) + p.lcs[k].c;
      worst = std::max(worst, y.cwiseMin(VectorXd(p.sizes.lambda(z))).cwiseAbs().maxCoeff());
    }
    CHECK(last.complementarity_violation == Approx(worst));
  }
}

TEST_CASE("solver: a solve that starts where another ended goes on as one") {
  const Problem p = random_problem(3);
  for (const ProjectionKind kind : kAllKinds) {
    Solver whole(p.sizes, settings(kind, 5)), first(p.sizes, settings(kind, 2));
    whole.set_costs(p.costs);
    first.set_costs(p.costs);
    const Solution& one = whole.solve(p.lcs, p.x0, p.x_desired);
    const Solution& begun = first.solve(p.lcs, p.x0, p.x_desired);
    Settings rest = settings(kind, 3);
    rest.rho = begun.rho;
    Solver second(p.sizes, rest);
    second.set_costs(p.costs);
    const Start start{begun.delta, begun.w};
    const Solution& continued = second.solve(p.lcs, p.x0, p.x_desired, {}, &start);
    CAPTURE(static_cast<int>(kind));
    CHECK((continued.z - one.z).isZero(1e-10));
    CHECK((continued.delta - one.delta).isZero(1e-10));
    CHECK((continued.w - one.w).isZero(1e-10));
  }
}

TEST_CASE("solver: a shifted start has the next stage's copies, and duals of the same size") {
  const Problem p = random_problem(4);
  Solver solver(p.sizes, settings(ProjectionKind::kMiqp, 3));
  solver.set_costs(p.costs);
  const Solution& solution = solver.solve(p.lcs, p.x0, p.x_desired);
  Start start;
  shift(solution, 0.5, start);
  const int N = p.sizes.N;
  CHECK(start.delta.leftCols(N - 1) == solution.delta.rightCols(N - 1));
  CHECK(start.delta.col(N - 1) == solution.delta.col(N - 1));
  CHECK((0.5 * start.w.leftCols(N - 1)).isApprox(solution.rho * solution.w.rightCols(N - 1)));
}

TEST_CASE("solver: any number of threads gives the same bits") {
  const Problem p = random_problem(5);
  const VectorXd x = rolling_ball::state(0.001);
  const lcs::Lcs ball = rolling_ball::lcs(x);
  for (const ProjectionKind kind : kAllKinds) {
    Settings with = settings(kind, 4);
    with.max_nodes = 100000;
    MatrixXd z, z_ball;
    for (const int workers : {1, 2, 4}) {
      rt::WorkerPool pool(workers);
      const Parallel parallel{&rt::WorkerPool::run_on, &pool, workers};
      Solver solver(p.sizes, with, parallel);
      solver.set_costs(p.costs);
      const Solution& solution = solver.solve(p.lcs, p.x0, p.x_desired);
      CAPTURE(static_cast<int>(kind), workers);
      REQUIRE(solution.status == SolveStatus::kOk);
      if (workers == 1) z = solution.z;
      CHECK(solution.z == z);
      // the ball's F is not semidefinite, and its LCP without solution where the QP pulls at
      // contacts
      if (kind == ProjectionKind::kConvex || kind == ProjectionKind::kLcp) continue;
      Solver ball_solver(rolling_ball::sizes(), with, parallel);
      Costs costs = rolling_ball::costs(rolling_ball::Phase::kRoll);
      costs.plus = {VectorXd::Constant(12, 0.01), VectorXd::Constant(12, 0.1), VectorXd::Ones(12),
                    VectorXd::Ones(12)};
      ball_solver.set_costs(costs);
      const Solution& rolled = ball_solver.solve(ball, x, rolling_ball::x_desired(x));
      REQUIRE(rolled.status == SolveStatus::kOk);
      if (workers == 1) z_ball = rolled.z;
      CHECK(rolled.z == z_ball);
    }
  }
}

TEST_CASE("solver: no kind of projection and no back end allocates in a solve") {
  Problem p = random_problem(6);
  const Problem other = random_problem(60);
  p.costs.plus.final_scale = VectorXd::Constant(p.sizes.n_lambda, 10.0);
  Constraints constraints;
  constraints.u_min = VectorXd::Constant(p.sizes.n_u, -0.2);
  constraints.x_max = VectorXd::Constant(p.sizes.n_x, 5.0);
  for (const ProjectionKind kind : kAllKinds) {
    for (const QpBackend qp : {QpBackend::kDirect, QpBackend::kInteriorPoint, QpBackend::kOsqp}) {
      Settings with = settings(kind, 3, qp);
      with.trace = true;
      Solver solver(p.sizes, with);
      solver.set_costs(p.costs, qp == QpBackend::kDirect ? Constraints{} : constraints);
      Start start;
      shift(solver.solve(p.lcs, p.x0, p.x_desired), with.rho, start);
      std::int64_t heap_calls = -1;
      int ok = 0;
      {
        const support::AllocationCounter heap;
        ok += solver.solve(other.lcs, other.x0, other.x_desired).status == SolveStatus::kOk;
        ok += solver.solve(p.lcs, p.x0, p.x_desired, {}, &start).status == SolveStatus::kOk;
        shift(solver.solve(p.lcs[0], p.x0, p.x_desired), with.rho, start);
        heap_calls = heap.count();
      }
      CAPTURE(static_cast<int>(kind), static_cast<int>(qp));
      CHECK(ok == 2);
      CHECK(heap_calls == 0);
    }
  }
}

TEST_CASE("solver: lambda_0 is fixed to the LCP's at x_0, and only where H is zero") {
  Problem p = random_problem(8);
  Settings with = settings(ProjectionKind::kMiqp, 3);
  with.fix_lambda_0 = true;
  for (const QpBackend qp : {QpBackend::kDirect, QpBackend::kInteriorPoint, QpBackend::kOsqp}) {
    with.qp = qp;
    Solver solver(p.sizes, with);
    solver.set_costs(p.costs);
    CHECK(solver.solve(p.lcs, p.x0, p.x_desired).failure == Failure::kLambda0);
    std::vector<lcs::Lcs> without_H = p.lcs;
    without_H[0].H.setZero();
    const Solution& solution = solver.solve(without_H, p.x0, p.x_desired);
    CAPTURE(static_cast<int>(qp));
    REQUIRE(solution.status == SolveStatus::kOk);
    const VectorXd lambda = p.sizes.lambda(solution.z.col(0));
    const VectorXd y = without_H[0].E * p.x0 + without_H[0].F * lambda + without_H[0].c;
    CHECK(y.cwiseMin(lambda).cwiseAbs().maxCoeff() < 1e-6);
  }
}

TEST_CASE("solver: a start of the wrong size or with NaN is refused") {
  const Problem p = random_problem(9);
  Solver solver(p.sizes, settings(ProjectionKind::kMiqp, 2));
  solver.set_costs(p.costs);
  Start start{MatrixXd::Zero(p.sizes.n_z(), p.sizes.N + 1),
              MatrixXd::Zero(p.sizes.n_z(), p.sizes.N)};
  CHECK(solver.solve(p.lcs, p.x0, p.x_desired, {}, &start).failure == Failure::kWrongSize);
  start.delta = start.w;
  start.w(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(solver.solve(p.lcs, p.x0, p.x_desired, {}, &start).failure == Failure::kNotFinite);
}
