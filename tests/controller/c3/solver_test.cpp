#include "controller/c3/solver.hpp"

#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Settings settings(QpBackend qp = QpBackend::kDirect) {
  return {3, 1.0, 2.2, qp, {2000, 1e-6, 0.1, 50, false}, ProjectionKind::kMiqp, 10000, true};
}

struct Problem {
  VectorXd x0;
  lcs::Lcs lcs;
  MatrixXd x_desired;
};

Problem problem(double gap = 0.002, double slip = 0.03) {
  const VectorXd x = rolling_ball::state(gap, slip);
  return {x, rolling_ball::lcs(x), rolling_ball::x_desired(x)};
}

Solver solver(const Settings& with) {
  Solver made(rolling_ball::sizes(), with);
  made.set_costs(rolling_ball::costs(rolling_ball::Phase::kRoll));
  return made;
}

/// Strikes at the given question and at every one after it.
struct Countdown {
  int left;
  static bool reached(void* context) noexcept {
    return --static_cast<Countdown*>(context)->left < 0;
  }
};

void check_failed(const Solution& solution, Failure failure) {
  CHECK(solution.status == SolveStatus::kFailed);
  CHECK(solution.failure == failure);
  // what was solved before the failure stays: nothing, or a complete QP
  CHECK(solution.z.isZero(0.0) == (solution.iterations == 0));
  CHECK(solution.z.allFinite());
  CHECK(solution.x_N.allFinite());
}

}  // namespace

TEST_CASE("solver: it runs s QPs and s - 1 projections, and its answer follows the dynamics") {
  const Problem p = problem();
  Solver c3 = solver(settings());
  const Solution& solution = c3.solve(p.lcs, p.x0, p.x_desired);
  REQUIRE(solution.status == SolveStatus::kOk);
  REQUIRE(solution.failure == Failure::kNone);
  REQUIRE(solution.iterations == 3);
  REQUIRE(solution.projections == 2);
  REQUIRE(solution.branch_nodes >= 10);
  REQUIRE(solution.primal_residual[0] > 0.0);
  REQUIRE(solution.primal_residual[2] == 0.0);
  const Sizes sizes = rolling_ball::sizes();
  REQUIRE(solution.u_0() == sizes.u(solution.z.col(0)));
  REQUIRE(sizes.x(solution.z.col(0)) == p.x0);
  for (int k = 0; k < sizes.N; ++k) {
    const VectorXd z = solution.z.col(k);
    const VectorXd next = k + 1 < sizes.N ? VectorXd(sizes.x(solution.z.col(k + 1))) : solution.x_N;
    CHECK((p.lcs.A * sizes.x(z) + p.lcs.B * sizes.u(z) + p.lcs.D * sizes.lambda(z) + p.lcs.d - next)
              .norm() < 1e-10);
    // every copy is a point of the LCP's set
    const VectorXd delta = solution.delta.col(k);
    const VectorXd y = p.lcs.E * sizes.x(delta) + p.lcs.F * sizes.lambda(delta) +
                       p.lcs.H * sizes.u(delta) + p.lcs.c;
    CHECK(y.cwiseMin(sizes.lambda(delta)).cwiseAbs().maxCoeff() < 1e-7);
  }
}

TEST_CASE("solver: a projection after the last QP changes delta and w, never z") {
  const Problem p = problem();
  Settings with_last = settings();
  with_last.project_last = true;
  Solver a = solver(settings()), b = solver(with_last);
  const Solution& plain = a.solve(p.lcs, p.x0, p.x_desired);
  const Solution& projected = b.solve(p.lcs, p.x0, p.x_desired);
  REQUIRE(projected.projections == 3);
  REQUIRE(projected.primal_residual[2] > 0.0);
  REQUIRE(projected.z == plain.z);
  REQUIRE(projected.delta != plain.delta);
}

TEST_CASE("solver: one system for all stages is the same as that system N times") {
  const Problem p = problem();
  Solver c3 = solver(settings());
  const MatrixXd z = c3.solve(p.lcs, p.x0, p.x_desired).z;
  const std::vector<lcs::Lcs> varying(rolling_ball::kN, p.lcs);
  const Solution& solution = c3.solve(varying, p.x0, p.x_desired);
  REQUIRE(solution.status == SolveStatus::kOk);
  REQUIRE(solution.z == z);
}

TEST_CASE("solver: the same problem gives the same bits, whatever came between, on any solver") {
  const Problem p = problem(), other = problem(0.012, 0.2);
  for (const QpBackend backend : {QpBackend::kDirect, QpBackend::kOsqp}) {
    Solver a = solver(settings(backend)), b = solver(settings(backend));
    const Solution first = a.solve(p.lcs, p.x0, p.x_desired);
    const MatrixXd z_other = a.solve(other.lcs, other.x0, other.x_desired).z;
    const Solution again = a.solve(p.lcs, p.x0, p.x_desired);
    const Solution elsewhere = b.solve(p.lcs, p.x0, p.x_desired);
    REQUIRE(first.status == SolveStatus::kOk);
    REQUIRE(first.z != z_other);
    REQUIRE(first.z == again.z);
    REQUIRE(first.delta == again.delta);
    REQUIRE(first.z == elsewhere.z);
    REQUIRE(first.w == elsewhere.w);
  }
}

TEST_CASE("solver: weights can be exchanged and exchanged back") {
  const Problem p = problem();
  Solver c3 = solver(settings());
  const MatrixXd roll = c3.solve(p.lcs, p.x0, p.x_desired).z;
  c3.set_costs(rolling_ball::costs(rolling_ball::Phase::kReturn));
  REQUIRE(c3.solve(p.lcs, p.x0, p.x_desired).status == SolveStatus::kOk);
  REQUIRE(c3.solve(p.lcs, p.x0, p.x_desired).z != roll);
  c3.set_costs(rolling_ball::costs(rolling_ball::Phase::kRoll));
  REQUIRE(c3.solve(p.lcs, p.x0, p.x_desired).z == roll);
}

TEST_CASE("solver: OSQP's workspace outlives an exchange of weights, and shows no trace of it") {
  const Problem given = problem();
  const Costs roll = rolling_ball::costs(rolling_ball::Phase::kRoll);
  Costs heavier = roll;
  heavier.Q[0] *= 10.0;
  heavier.R[0] *= 3.0;
  const auto solved_with = [&](const std::vector<Costs>& one_after_another) {
    Solver made(rolling_ball::sizes(), settings(QpBackend::kOsqp));
    for (const Costs& costs : one_after_another) {
      made.set_costs(costs);
      made.solve(given.lcs, given.x0, given.x_desired);
    }
    return MatrixXd(made.solve(given.lcs, given.x0, given.x_desired).z);
  };
  const MatrixXd fresh = solved_with({roll});
  CHECK(solved_with({roll, heavier, roll}) == fresh);
  CHECK((solved_with({heavier, roll}) - fresh).cwiseAbs().maxCoeff() < 1e-3);
  CHECK((solved_with({heavier}) - fresh).cwiseAbs().maxCoeff() > 1e-3);
}

TEST_CASE("solver: wherever the deadline strikes, the answer is that of the last complete QP") {
  const Problem p = problem();
  std::vector<MatrixXd> z_after(1);  // after 1, 2, 3 QPs
  for (int s = 1; s <= 3; ++s) {
    Settings fewer = settings();
    fewer.admm_iterations = s;
    Solver c3 = solver(fewer);
    z_after.push_back(c3.solve(p.lcs, p.x0, p.x_desired).z);
  }
  Solver c3 = solver(settings());
  int truncated = 0, seen[4] = {};
  for (int questions = 0;; ++questions) {
    Countdown countdown{questions};
    const Solution& solution =
        c3.solve(p.lcs, p.x0, p.x_desired, {&Countdown::reached, &countdown});
    REQUIRE(solution.iterations >= 1);
    REQUIRE(solution.z == z_after[solution.iterations]);
    ++seen[solution.iterations];
    if (solution.status == SolveStatus::kOk) break;
    REQUIRE(solution.status == SolveStatus::kTruncated);
    REQUIRE(solution.iterations < 3);
    ++truncated;
  }
  // asked before every projection and at every node of branch and bound, in both rounds
  REQUIRE(truncated > 30);
  REQUIRE(seen[1] > 10);
  REQUIRE(seen[2] > 10);
}

TEST_CASE("solver: a projection that hits its bound of nodes flags the whole answer") {
  // random contacts that all work against each other, to make the search long
  support::Random random(31);
  const Sizes sizes{3, 8, 2, 2};
  const auto definite = [&](int n) {
    const MatrixXd half = random.matrix(n, n);
    return MatrixXd(half * half.transpose() + 0.05 * MatrixXd::Identity(n, n));
  };
  int flagged = 0, without_point = 0, enough = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const lcs::Lcs lcs{random.matrix(3, 3), random.matrix(3, 2), random.matrix(3, 8),
                       random.vector(3),    random.matrix(8, 3), definite(8),
                       random.matrix(8, 2), random.vector(8)};
    const Costs costs{definite(3), definite(3), definite(2), definite(13), definite(13)};
    const VectorXd x0 = 3.0 * random.vector(3);
    const MatrixXd x_desired = random.matrix(3, 3);
    for (const int max_nodes : {3, 8, 12, 10000}) {
      Settings few = settings();
      few.max_nodes = max_nodes;
      Solver c3(sizes, few);
      c3.set_costs(costs);
      const Solution& solution = c3.solve(lcs, x0, x_desired);
      if (solution.status == SolveStatus::kFailed) {
        check_failed(solution, Failure::kProjection);
        CHECK(solution.projection.status == ProjectionStatus::kNotFound);
        CHECK(solution.projection.nodes == max_nodes);
        CHECK(max_nodes < 10000);
        ++without_point;
      } else {
        CHECK((solution.status == SolveStatus::kTruncated) == (solution.inexact_projections > 0));
        CHECK(solution.iterations == 3);
        ++(solution.inexact_projections > 0 ? flagged : enough);
      }
    }
  }
  CAPTURE(flagged, without_point, enough);
  REQUIRE(flagged > 0);
  REQUIRE(without_point > 0);
  REQUIRE(enough >= 10);
}

TEST_CASE("solver: NaN, wrong sizes and missing costs fail by name and give zeros") {
  const Problem p = problem();
  Solver without_costs(rolling_ball::sizes(), settings());
  check_failed(without_costs.solve(p.lcs, p.x0, p.x_desired), Failure::kNoCosts);

  Solver c3 = solver(settings());
  VectorXd x0 = p.x0;
  x0[4] = kNaN;
  check_failed(c3.solve(p.lcs, x0, p.x_desired), Failure::kNotFinite);
  MatrixXd x_desired = p.x_desired;
  x_desired(0, 5) = std::numeric_limits<double>::infinity();
  check_failed(c3.solve(p.lcs, p.x0, x_desired), Failure::kNotFinite);
  lcs::Lcs lcs = p.lcs;
  lcs.F(1, 1) = kNaN;
  check_failed(c3.solve(lcs, p.x0, p.x_desired), Failure::kNotFinite);
  lcs = p.lcs;
  lcs.E = MatrixXd::Zero(12, 18);
  check_failed(c3.solve(lcs, p.x0, p.x_desired), Failure::kWrongSize);
  check_failed(c3.solve(p.lcs, p.x0.head(18), p.x_desired), Failure::kWrongSize);
  check_failed(c3.solve(p.lcs, p.x0, p.x_desired.leftCols(5)), Failure::kWrongSize);
  check_failed(c3.solve(std::vector<lcs::Lcs>(4, p.lcs), p.x0, p.x_desired), Failure::kWrongSize);

  // and recovers
  REQUIRE(c3.solve(p.lcs, p.x0, p.x_desired).status == SolveStatus::kOk);
}

TEST_CASE("solver: numbers that overflow on the way are a failure, never NaN in the answer") {
  const Problem p = problem();
  for (const QpBackend backend : {QpBackend::kDirect, QpBackend::kOsqp}) {
    Solver c3 = solver(settings(backend));
    const Solution& solution = c3.solve(p.lcs, VectorXd(p.x0 * 1e306), p.x_desired);
    CHECK(solution.z.allFinite());
    CHECK(solution.x_N.allFinite());
    CHECK(solution.status == SolveStatus::kFailed);
  }
}

TEST_CASE("solver: an LCP's set that is empty is a failure of the projection") {
  Problem p = problem();
  p.lcs.E.row(0).setZero();
  p.lcs.F.row(0).setZero();
  p.lcs.H.row(0).setZero();
  p.lcs.c[0] = -1.0;
  Solver c3 = solver(settings());
  const Solution& solution = c3.solve(p.lcs, p.x0, p.x_desired);
  check_failed(solution, Failure::kProjection);
  CHECK(solution.projection.status == ProjectionStatus::kEmpty);
  CHECK(solution.failed_stage == 0);
}

TEST_CASE("solver: lambda_0 is the LCP's own answer, not that of F + ε I, or a failure") {
  lcs::Lcs lcs;
  lcs.A = lcs.B = MatrixXd::Identity(1, 1);
  lcs.d = VectorXd::Zero(1);
  lcs.D = MatrixXd::Ones(1, 2);
  lcs.E = lcs.H = MatrixXd::Zero(2, 1);
  lcs.F = (MatrixXd(2, 2) << 0, 1, 1, 0).finished();
  lcs.c = -VectorXd::Ones(2);
  Settings fixed = settings();
  fixed.fix_lambda_0 = true;
  fixed.projection = ProjectionKind::kPlus;
  Solver c3({1, 2, 1, 3}, fixed);
  Costs costs;
  costs.Q_N = MatrixXd::Identity(1, 1);
  costs.Q = costs.R = costs.Q_N;
  costs.plus = {VectorXd::Ones(2), VectorXd::Ones(2), VectorXd::Ones(2), VectorXd::Ones(2)};
  c3.set_costs(costs);
  const VectorXd x0 = VectorXd::Ones(1);
  const MatrixXd x_desired = MatrixXd::Zero(1, 4);
  const Solution& solution = c3.solve(lcs, x0, x_desired);
  REQUIRE(solution.status == SolveStatus::kOk);  // λ = [1, 1] is the only answer
  CHECK(solution.z(1, 0) == Approx(1.0).epsilon(1e-12));
  CHECK(solution.z(2, 0) == Approx(1.0).epsilon(1e-12));

  lcs.F.setZero();  // 0 λ − 1 ≥ 0 never holds
  check_failed(c3.solve(lcs, x0, x_desired), Failure::kLambda0);
  lcs.F = (MatrixXd(2, 2) << 1, -1, -1, 1).finished();
  lcs.c = Eigen::Vector2d(-1, 0.5);
  check_failed(c3.solve(lcs, x0, x_desired), Failure::kLambda0);
}

TEST_CASE("solver: costs that cannot be used are refused and leave no half-set solver behind") {
  const Problem p = problem();
  Solver c3 = solver(settings());
  Costs bad = rolling_ball::costs(rolling_ball::Phase::kRoll);
  bad.G[0](0, 0) = -1.0;
  const MatrixXd z = c3.solve(p.lcs, p.x0, p.x_desired).z;
  REQUIRE_THROWS_AS(c3.set_costs(bad), std::invalid_argument);
  REQUIRE(c3.solve(p.lcs, p.x0, p.x_desired).z == z);  // refused at the door: the old ones stay
  Constraints bounds;
  bounds.u_max = VectorXd::Ones(3);
  REQUIRE_THROWS_AS(c3.set_costs(rolling_ball::costs(rolling_ball::Phase::kRoll), bounds),
                    std::invalid_argument);
}

TEST_CASE("solver: both QP steps and both projections solve the ball's problem") {
  const Problem p = problem();
  Settings precise = settings(QpBackend::kOsqp);
  precise.osqp = {50000, 1e-9, 0.1, 50, true};
  for (const ProjectionKind kind : {ProjectionKind::kMiqp, ProjectionKind::kLcp}) {
    Settings by_direct = settings(), by_osqp = precise;
    by_direct.projection = by_osqp.projection = kind;
    Solver a = solver(by_direct), b = solver(by_osqp);
    const VectorXd u_direct = a.solve(p.lcs, p.x0, p.x_desired).u_0();
    const VectorXd u_osqp = b.solve(p.lcs, p.x0, p.x_desired).u_0();
    CHECK((u_direct - u_osqp).norm() < 1e-5 * (1e-3 + u_direct.norm()));
  }
}

TEST_CASE("solver: a G that is given with C3+ changes nothing, whatever the QP back end") {
  const Problem p = problem();
  Settings precise = settings(QpBackend::kOsqp);
  precise.osqp = {50000, 1e-9, 0.1, 50, true};
  Settings by_direct = settings();
  by_direct.projection = precise.projection = ProjectionKind::kPlus;
  Costs costs = rolling_ball::costs(rolling_ball::Phase::kRoll);
  const int n_lambda = rolling_ball::sizes().n_lambda;
  const VectorXd ones = VectorXd::Ones(n_lambda);
  costs.plus = {ones, ones, ones, ones};
  costs.G = {};
  Solver direct(rolling_ball::sizes(), by_direct);
  direct.set_costs(costs);
  const VectorXd expected = direct.solve(p.lcs, p.x0, p.x_desired).u_0();
  costs.G = MatrixXd(MatrixXd::Identity(rolling_ball::sizes().n_z(), rolling_ball::sizes().n_z()));
  for (const Settings& with : {by_direct, precise}) {
    Solver solver(rolling_ball::sizes(), with);
    solver.set_costs(costs);
    const Solution& solution = solver.solve(p.lcs, p.x0, p.x_desired);
    REQUIRE(solution.status == SolveStatus::kOk);
    CHECK((solution.u_0() - expected).norm() < 1e-5 * (1e-3 + expected.norm()));
  }
}

TEST_CASE("solver: a solve does not allocate") {
  const Problem p = problem(), other = problem(-0.0005, 0.1);
  const std::vector<lcs::Lcs> varying(rolling_ball::kN, p.lcs);
  for (const QpBackend backend : {QpBackend::kDirect, QpBackend::kOsqp}) {
    for (const ProjectionKind kind : {ProjectionKind::kMiqp, ProjectionKind::kLcp}) {
      Settings with = settings(backend);
      with.projection = kind;
      Solver c3 = solver(with);
      std::int64_t heap_calls = -1;
      int ok = 0;
      {
        const support::AllocationCounter heap;
        ok += c3.solve(p.lcs, p.x0, p.x_desired).status == SolveStatus::kOk;
        ok += c3.solve(other.lcs, other.x0, other.x_desired).status == SolveStatus::kOk;
        ok += c3.solve(varying, p.x0, p.x_desired).status == SolveStatus::kOk;
        heap_calls = heap.count();
      }
      CAPTURE(static_cast<int>(backend), static_cast<int>(kind));
      CHECK(ok == 3);
      CHECK(heap_calls == 0);
    }
  }
}

namespace {

/// Random, stable, with bounds on u or without: blocks of the given sizes.
struct Sized {
  Sizes sizes;
  lcs::Lcs lcs;
  Costs costs;
  VectorXd x0;
  MatrixXd x_desired;
};

Sized sized(int n_lambda, int n_u, unsigned seed) {
  support::Random random(seed);
  const int n_x = 3, N = 4, n_z = n_x + n_lambda + n_u;
  const auto identity = [](int n) { return MatrixXd(MatrixXd::Identity(n, n)); };
  Sized p{{n_x, n_lambda, n_u, N}, {}, {}, random.vector(n_x), random.matrix(n_x, N + 1)};
  p.lcs = {0.5 * random.matrix(n_x, n_x), random.matrix(n_x, n_u),
           random.matrix(n_x, n_lambda),  random.vector(n_x),
           random.matrix(n_lambda, n_x),  identity(n_lambda),
           MatrixXd::Zero(n_lambda, n_u), random.vector(n_lambda)};
  p.costs = {identity(n_x), identity(n_x), identity(n_u), identity(n_z), identity(n_z)};
  p.costs.convex = {identity(n_x), identity(n_u), 0.5, 1e-3};
  const VectorXd ones = VectorXd::Ones(n_lambda);
  p.costs.plus = {ones, ones, ones, ones};
  return p;
}

/// `to` is `from` without its contacts, without its inputs, or without both.
void strip(const Sized& from, Sized& to) {
  const Sizes& s = to.sizes;
  to.x0 = from.x0;
  to.x_desired = from.x_desired;
  to.lcs = {from.lcs.A,
            from.lcs.B.leftCols(s.n_u),
            from.lcs.D.leftCols(s.n_lambda),
            from.lcs.d,
            from.lcs.E.topRows(s.n_lambda),
            from.lcs.F.topLeftCorner(s.n_lambda, s.n_lambda),
            from.lcs.H.topLeftCorner(s.n_lambda, s.n_u),
            from.lcs.c.head(s.n_lambda)};
}

}  // namespace

TEST_CASE(
    "solver: without contacts or without inputs it plans as with ones that move nothing, with "
    "every projection and QP step") {
  for (const auto& [n_lambda, n_u] : {std::pair{0, 2}, std::pair{2, 0}, std::pair{0, 0}}) {
    for (const QpBackend backend :
         {QpBackend::kDirect, QpBackend::kInteriorPoint, QpBackend::kOsqp}) {
      for (const ProjectionKind kind :
           {ProjectionKind::kMiqp, ProjectionKind::kLcp, ProjectionKind::kAdmm,
            ProjectionKind::kConvex, ProjectionKind::kPlus}) {
        Sized full = sized(2, 2, 5), part = sized(n_lambda, n_u, 6);
        if (n_lambda == 0) {
          full.lcs.D.setZero();
          full.lcs.E.setZero();
          full.lcs.c.setOnes();
        }
        if (n_u == 0) full.lcs.B.setZero();
        strip(full, part);
        Settings with = settings(backend);
        with.projection = kind;
        with.osqp = {20000, 1e-9, 0.1, 50, false};
        with.project_last = true;
        const auto solve = [&](const Sized& p) {
          Constraints bounds;
          if (backend != QpBackend::kDirect) {
            bounds.x_max = VectorXd::Constant(3, 100.0);
            bounds.x_min = VectorXd::Constant(3, -100.0);
            bounds.u_max = VectorXd::Constant(p.sizes.n_u, 0.1);
            bounds.lambda_max = VectorXd::Constant(p.sizes.n_lambda, 50.0);
          }
          Solver c3(p.sizes, with);
          c3.set_costs(p.costs, bounds);
          return c3.solve(p.lcs, p.x0, p.x_desired);
        };
        const Solution got = solve(part), expected = solve(full);
        CAPTURE(n_lambda, n_u, static_cast<int>(backend), static_cast<int>(kind));
        CHECK(got.status == SolveStatus::kOk);
        CHECK(got.sizes.n_z() == 3 + n_lambda + n_u);
        CHECK((got.z.topRows(3) - expected.z.topRows(3)).norm() < 1e-5);
        CHECK((got.x_N - expected.x_N).norm() < 1e-5);
        if (n_u > 0) CHECK((got.u_0() - expected.u_0()).norm() < 1e-5);
        if (n_lambda == 0) CHECK(got.complementarity_violation == 0.0);
      }
    }
  }
}
