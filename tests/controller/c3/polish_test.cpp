#include "controller/c3/polish.hpp"

#include <limits>

#include <catch2/catch.hpp>

#include "controller/c3/solver.hpp"
#include "controller/lcs/simulate.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/rolling_ball.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kQps = 60;

MatrixXd one(double value) { return MatrixXd::Constant(1, 1, value); }
VectorXd entry(double value) { return VectorXd::Constant(1, value); }

/// x⁺ = max(0, x + u): a wall at 0, whose force λ = max(0, −(x + u)).
lcs::Lcs wall() { return {one(1), one(1), one(1), entry(0), one(1), one(1), one(1), entry(0)}; }

/// One stage of it: (x_1 − x_d)² + R u².
struct Wall {
  lcs::Lcs lcs = wall();
  Sizes sizes{1, 1, 1, 1};
  Costs costs;
  Polish polish{sizes, kQps};
  explicit Wall(double R, const Constraints& constraints = {}) {
    costs.Q = one(0);
    costs.Q_N = one(1);
    costs.R = one(R);
    polish.set_costs(costs, constraints);
  }
  /// The input that is found from another one.
  double from(double u, double x_d) {
    polish.start({&lcs, 0}, entry(1), MatrixXd::Constant(1, 2, x_d), one(u), one(0));
    polish.improve(one(u), {});
    return polish.u()(0, 0);
  }
};

struct Ball {
  VectorXd x0;
  lcs::Lcs lcs;
  MatrixXd x_desired;
  Costs costs = rolling_ball::costs(rolling_ball::Phase::kRoll);
  Sizes sizes = rolling_ball::sizes();
  explicit Ball(double gap, double slip = 0.03)
      : x0(rolling_ball::state(gap, slip)),
        lcs(rolling_ball::lcs(x0)),
        x_desired(rolling_ball::x_desired(x0)) {
    costs.plus = {VectorXd::Constant(12, 0.01), VectorXd::Constant(12, 0.1), VectorXd::Ones(12),
                  VectorXd::Ones(12)};
  }
};

Settings settings(int polish, ProjectionKind projection = ProjectionKind::kMiqp) {
  Settings made{3,          1.0,   2.2, QpBackend::kDirect, {2000, 1e-6, 0.1, 50, false},
                projection, 10000, true};
  made.polish = polish;
  return made;
}

/// The cost of inputs, which the system is simulated with.
double simulated(const Ball& ball, const MatrixXd& u) {
  const lcs::Simulation simulation = lcs::simulate(ball.lcs, ball.x0, u);
  REQUIRE(simulation.report.ok());
  MatrixXd z = MatrixXd::Zero(ball.sizes.n_z(), ball.sizes.N);
  z.topRows(ball.sizes.n_x) = simulation.x.leftCols(ball.sizes.N);
  z.bottomRows(ball.sizes.n_u) = u;
  return cost(ball.costs, ball.sizes, ball.x_desired, z, simulation.x.col(ball.sizes.N));
}

MatrixXd inputs(const Solution& solution) {
  return solution.z.middleRows(solution.sizes.n_x + solution.sizes.n_lambda, solution.sizes.n_u);
}

/// Strikes at the given question and at every one after it.
struct Countdown {
  int left;
  static bool reached(void* context) noexcept {
    return --static_cast<Countdown*>(context)->left < 0;
  }
};

}  // namespace

TEST_CASE("polish: within a mode it finds the minimiser of the QP") {
  // (1 + u − 3)² + R u²
  CHECK(Wall(0.5).from(0.2, 3.0) == Approx(2.0 / 1.5).epsilon(1e-7));
}

TEST_CASE(
    "polish: a pair whose both sides are zero passes into its other mode where that is cheaper") {
  Wall wall(0.5);
  // in the wall u = −1 is the cheapest, its kink; beyond it (1 + u − 3)² + R u²
  CHECK(wall.from(-4.0, 3.0) == Approx(2.0 / 1.5).epsilon(1e-7));
  CHECK(wall.polish.report().cost_before == Approx(9.0 + 8.0));
  CHECK(wall.polish.report().status == PolishStatus::kBest);
  CHECK(wall.polish.lambda()(0, 0) == 0.0);
}

TEST_CASE("polish: it ends at a kink that is a minimum from both sides") {
  Wall wall(0.1);
  // the target lies in the wall, and each newton into it costs
  for (const double u : {-4.0, 0.5}) {
    CHECK(wall.from(u, -1.0) == Approx(-1.0).epsilon(1e-6));
    CHECK(wall.polish.report().cost == Approx(1.1).epsilon(1e-6));
  }
}

TEST_CASE("polish: a move leaves a local minimum that no single step of the descent does") {
  // x⁺ = |x + u|: u = −4 and u = 2 both reach 3, and between them the cost rises to 9
  const double R = 0.1;
  Wall mirror(R);
  mirror.lcs.D = one(2);
  CHECK(mirror.from(-3.5, 3.0) == Approx(-4.0 / (1.0 + R)).epsilon(1e-7));
  CHECK(mirror.polish.report().cost == Approx(16.0 * R / (1.0 + R)));
  mirror.polish.explore({});
  CHECK(mirror.polish.u()(0, 0) == Approx(2.0 / (1.0 + R)).epsilon(1e-7));
  CHECK(mirror.polish.report().cost == Approx(4.0 * R / (1.0 + R)));
  CHECK(mirror.polish.report().status == PolishStatus::kBest);
  CHECK(mirror.polish.report().qps <= kQps);
}

TEST_CASE("polish: bounds are met, and inputs outside them are taken at them") {
  Constraints constraints;
  constraints.u_min = entry(-2.0);
  constraints.u_max = entry(1.0);
  Wall wall(0.5, constraints);
  CHECK(wall.from(0.2, 3.0) == Approx(1.0).epsilon(1e-7));
  CHECK(wall.from(5.0, 3.0) == Approx(1.0).epsilon(1e-7));
  CHECK(wall.polish.report().cost_before == Approx(1.0 + 0.5));
}

TEST_CASE("polish: a plan outside a bound of the state counts for nothing") {
  Constraints constraints;
  constraints.x_N_max = entry(1.5);
  Wall wall(0.5, constraints);
  CHECK(wall.from(1.0, 3.0) == Approx(0.5).epsilon(1e-7));
  CHECK(wall.polish.report().cost_before == kInfinity);
}

TEST_CASE("polish: inputs without a simulation get the modes of the last projection") {
  // y = x + u − λ: λ is any that is (x + u)₊ or 0, and none at all for x + u < 0
  Wall wall(0.5);
  wall.lcs.F = one(-1);
  const MatrixXd x_d = MatrixXd::Constant(1, 2, 3.0);
  for (const double force : {0.0, 1.0}) {
    wall.polish.start({&wall.lcs, 0}, entry(1), x_d, one(-2), one(force));
    wall.polish.improve(one(-2), {});
    // x⁺ = 1 + u without the force, 2 (1 + u) with it
    const double u = force == 0.0 ? 2.0 / 1.5 : 2.0 / 4.5;
    CHECK(wall.polish.u()(0, 0) == Approx(u).epsilon(1e-6));
    CHECK(wall.polish.lambda()(0, 0) == Approx(force * (1.0 + u)).epsilon(1e-6));
  }
}

TEST_CASE("polish: with every projection the plan is complementary and costs no more than before") {
  for (const ProjectionKind projection : {ProjectionKind::kMiqp, ProjectionKind::kLcp,
                                          ProjectionKind::kAdmm, ProjectionKind::kPlus}) {
    for (const double gap : {0.0, 0.002, 0.01}) {
      const Ball ball(gap);
      Solver without(ball.sizes, settings(0, projection)),
          with(ball.sizes, settings(kQps, projection));
      without.set_costs(ball.costs);
      with.set_costs(ball.costs);
      const Solution& before = without.solve(ball.lcs, ball.x0, ball.x_desired);
      const Solution& after = with.solve(ball.lcs, ball.x0, ball.x_desired);
      CAPTURE(static_cast<int>(projection), gap);
      REQUIRE(before.status == SolveStatus::kOk);
      CHECK(before.polish.status == PolishStatus::kOff);
      REQUIRE(after.status == SolveStatus::kOk);
      CHECK(after.polish.qps > 0);
      CHECK(after.polish.qps <= kQps);
      CHECK(after.delta == before.delta);
      const double cost_before = simulated(ball, inputs(before));
      CHECK(after.polish.cost_before == Approx(cost_before));
      CHECK(after.polish.cost <= cost_before);
      CHECK(simulated(ball, inputs(after)) <= cost_before * (1.0 + 1e-6));
      // a plan of the system with complementary forces
      const double force = after.z.middleRows(ball.sizes.n_x, 12).cwiseAbs().maxCoeff();
      CHECK(after.complementarity_violation <= 1e-6 * (1.0 + force));
      for (int k = 0; k < ball.sizes.N; ++k) {
        const VectorXd z = after.z.col(k);
        const VectorXd next =
            k + 1 < ball.sizes.N ? VectorXd(ball.sizes.x(after.z.col(k + 1))) : after.x_N;
        CHECK((ball.lcs.A * ball.sizes.x(z) + ball.lcs.B * ball.sizes.u(z) +
               ball.lcs.D * ball.sizes.lambda(z) + ball.lcs.d - next)
                  .norm() < 1e-8);
      }
    }
  }
}

TEST_CASE("polish: a known plan is kept where Algorithm 1's leads to none as good") {
  const Ball ball(0.002);
  Solver solver(ball.sizes, settings(kQps));
  solver.set_costs(ball.costs);
  const Solution first = solver.solve(ball.lcs, ball.x0, ball.x_desired);
  Start start;
  start.u = inputs(first);
  const Solution& second = solver.solve(ball.lcs, ball.x0, ball.x_desired, {}, &start);
  REQUIRE(second.status == SolveStatus::kOk);
  CHECK(second.delta == first.delta);  // the start has inputs alone
  CHECK(second.polish.cost <= first.polish.cost * (1.0 + 1e-9));
  start.u = MatrixXd::Zero(2, ball.sizes.N);
  CHECK(solver.solve(ball.lcs, ball.x0, ball.x_desired, {}, &start).failure == Failure::kWrongSize);
}

TEST_CASE("polish: what one call has no QPs left for, the next goes on with") {
  const Ball ball(0.002);
  Solver solver(ball.sizes, settings(8)), whole(ball.sizes, settings(200));
  solver.set_costs(ball.costs);
  whole.set_costs(ball.costs);
  const double reference = whole.solve(ball.lcs, ball.x0, ball.x_desired).polish.cost;
  Start start;
  double first = 0.0, before = kInfinity;
  for (int call = 0; call < 20; ++call) {
    const Solution& solution = solver.solve(ball.lcs, ball.x0, ball.x_desired, {}, &start);
    REQUIRE(solution.status == SolveStatus::kOk);
    CHECK(solution.polish.qps <= 8);
    CHECK(solution.polish.cost <= before * (1.0 + 1e-6));
    CHECK(simulated(ball, inputs(solution)) == Approx(solution.polish.cost).epsilon(1e-6));
    before = solution.polish.cost;
    if (call == 0) first = before;
    start.u = inputs(solution);
    start.modes = solution.modes;
  }
  CHECK(first > 1.05 * reference);
  CHECK(before <= 1.05 * reference);
}

TEST_CASE("polish: modes say what is fixed and held, and shifted ones are a stage further on") {
  Wall wall(0.1);
  PairModes modes;
  (void)wall.from(-4.0, -1.0);  // ends at the kink, where both sides are zero
  wall.polish.read_modes(modes);
  CHECK((modes(0, 0) & kHeldMode) != 0);
  (void)wall.from(0.2, 3.0);  // ends within the mode without a force
  wall.polish.read_modes(modes);
  CHECK(modes(0, 0) == 0);

  const Ball ball(0.002);
  Solver solver(ball.sizes, settings(kQps)), without(ball.sizes, settings(0));
  solver.set_costs(ball.costs);
  without.set_costs(ball.costs);
  const Solution& solution = solver.solve(ball.lcs, ball.x0, ball.x_desired);
  for (int k = 0; k < ball.sizes.N; ++k) {
    for (int j = 0; j < ball.sizes.n_lambda; ++j) {
      if (ball.sizes.lambda(solution.z.col(k))[j] > 1e-6)
        CHECK((solution.modes(j, k) & kForceMode) != 0);
    }
  }
  Start start;
  shift(solution, 1.0, start);
  const int N = ball.sizes.N;
  CHECK(start.modes.leftCols(N - 1) == solution.modes.rightCols(N - 1));
  CHECK(start.modes.col(N - 1) == solution.modes.col(N - 1));
  start.modes.conservativeResize(ball.sizes.n_lambda, N - 1);
  CHECK(solver.solve(ball.lcs, ball.x0, ball.x_desired, {}, &start).failure == Failure::kWrongSize);
  const Solution& plain = without.solve(ball.lcs, ball.x0, ball.x_desired);
  CHECK((plain.modes.array() == kNoMode).all());
}

TEST_CASE("polish: the same problem gives the same bits, and nothing is allocated") {
  const Ball ball(0.002), other(0.01, 0.2);
  Solver a(ball.sizes, settings(kQps)), b(ball.sizes, settings(kQps));
  a.set_costs(ball.costs);
  b.set_costs(ball.costs);
  const Solution first = a.solve(ball.lcs, ball.x0, ball.x_desired);
  (void)a.solve(other.lcs, other.x0, other.x_desired);
  const support::AllocationCounter allocations;
  const Solution& again = a.solve(ball.lcs, ball.x0, ball.x_desired);
  const auto count = allocations.count();
  CHECK(count == 0);
  CHECK(again.z == first.z);
  CHECK(again.x_N == first.x_N);
  CHECK(b.solve(ball.lcs, ball.x0, ball.x_desired).z == first.z);
  Start start;
  start.u = inputs(first);
  start.modes = first.modes;
  const Solution resumed = b.solve(ball.lcs, ball.x0, ball.x_desired, {}, &start);
  (void)a.solve(other.lcs, other.x0, other.x_desired);
  const support::AllocationCounter of_start;
  const Solution& once_more = a.solve(ball.lcs, ball.x0, ball.x_desired, {}, &start);
  const auto count_of_start = of_start.count();
  CHECK(count_of_start == 0);
  CHECK(once_more.z == resumed.z);
  CHECK(once_more.modes == resumed.modes);
}

TEST_CASE(
    "polish: whenever the deadline strikes the plan is no worse than before, and status says so") {
  const Ball ball(0.002);
  Solver solver(ball.sizes, settings(kQps));
  solver.set_costs(ball.costs);
  const Solution whole = solver.solve(ball.lcs, ball.x0, ball.x_desired);
  REQUIRE(whole.polish.status == PolishStatus::kBest);
  REQUIRE(whole.polish.cost < whole.polish.cost_before);
  bool cut = false;
  for (int questions = 0; questions < 400; questions += 3) {
    Countdown countdown{questions};
    const Solution& solution =
        solver.solve(ball.lcs, ball.x0, ball.x_desired, {&Countdown::reached, &countdown});
    if (solution.status != SolveStatus::kOk) continue;  // Algorithm 1 itself was cut
    CHECK(solution.polish.cost <= solution.polish.cost_before);
    CHECK(solution.polish.cost >= whole.polish.cost * (1.0 - 1e-6));
    if (solution.polish.status == PolishStatus::kDeadline) cut = true;
  }
  CHECK(cut);
}

TEST_CASE("polish: a limit of QPs holds, and a negative one is refused") {
  const Ball ball(0.002);
  Solver solver(ball.sizes, settings(1));
  solver.set_costs(ball.costs);
  const Solution& solution = solver.solve(ball.lcs, ball.x0, ball.x_desired);
  CHECK(solution.polish.qps == 1);
  CHECK(solution.polish.status == PolishStatus::kQpLimit);
  CHECK(solution.polish.cost <= solution.polish.cost_before);
  CHECK_THROWS_WITH(check(settings(-1)), "Settings.polish: expected 0 or more, got -1");
}

TEST_CASE("polish: where no forces are complementary the solution is as without it") {
  // y = −1 whatever is done
  lcs::Lcs lcs = wall();
  lcs.E = lcs.F = lcs.H = one(0);
  lcs.c = entry(-1);
  Costs costs;
  costs.Q = one(1);
  costs.Q_N = one(1);
  costs.R = one(1);
  costs.plus = {entry(1), entry(1), entry(1), entry(1)};
  const Sizes sizes{1, 1, 1, 3};
  Solver without(sizes, settings(0, ProjectionKind::kPlus)),
      with(sizes, settings(kQps, ProjectionKind::kPlus));
  without.set_costs(costs);
  with.set_costs(costs);
  const MatrixXd x_desired = MatrixXd::Zero(1, 4);
  const MatrixXd z = without.solve(lcs, entry(1), x_desired).z;
  const Solution& solution = with.solve(lcs, entry(1), x_desired);
  CHECK(solution.status == SolveStatus::kOk);
  CHECK(solution.polish.status == PolishStatus::kNoPlan);
  CHECK(solution.polish.cost == kInfinity);
  CHECK(solution.z == z);
}
