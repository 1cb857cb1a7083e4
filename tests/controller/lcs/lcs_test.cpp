#include "controller/lcs/lcs.hpp"

#include <limits>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "controller/lcs/step.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"

using namespace c3rt;
using Catch::Matchers::Equals;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

lcs::Lcs small_system() {
  lcs::Lcs lcs;
  lcs.A = MatrixXd::Identity(2, 2);
  lcs.B = MatrixXd::Ones(2, 1);
  lcs.D = MatrixXd::Constant(2, 1, 0.5);
  lcs.d = VectorXd::Zero(2);
  lcs.E = MatrixXd::Ones(1, 2);
  lcs.F = MatrixXd::Ones(1, 1);
  lcs.H = MatrixXd::Zero(1, 1);
  lcs.c = VectorXd::Zero(1);
  return lcs;
}

}  // namespace

TEST_CASE("lcs: a block of the wrong shape is refused by its name") {
  lcs::Lcs lcs = small_system();
  REQUIRE_NOTHROW(lcs::check(lcs));
  lcs.E = MatrixXd::Ones(1, 3);
  REQUIRE_THROWS_WITH(lcs::check(lcs), Equals("Lcs.E: expected 1 x 2, got 1 x 3"));
  lcs = small_system();
  lcs.D = MatrixXd::Ones(2, 2);
  REQUIRE_THROWS_WITH(lcs::check(lcs), Equals("Lcs.D: expected 2 x 1, got 2 x 2"));
  lcs = small_system();
  lcs.F = MatrixXd::Ones(2, 1);
  REQUIRE_THROWS_WITH(lcs::check(lcs), Equals("Lcs.F: expected 1 x 1, got 2 x 1"));
  lcs = small_system();
  lcs.c = VectorXd::Zero(0);
  REQUIRE_THROWS_WITH(lcs::check(lcs), Equals("Lcs.c: expected 1 x 1, got 0 x 1"));
}

TEST_CASE("lcs: NaN and infinity are refused by the block's name") {
  lcs::Lcs lcs = small_system();
  lcs.H(0, 0) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_THROWS_WITH(lcs::check(lcs),
                      Equals("Lcs.H: expected finite numbers, got NaN or infinity"));
  lcs = small_system();
  lcs.d[1] = std::numeric_limits<double>::infinity();
  REQUIRE_THROWS_WITH(lcs::check(lcs),
                      Equals("Lcs.d: expected finite numbers, got NaN or infinity"));
}

TEST_CASE("lcs: the force scale is the ratio of the squared norms of A and D") {
  lcs::Lcs lcs = small_system();
  REQUIRE(lcs::force_scale(lcs) == Approx(2.0 / 0.5));
  lcs.D.setZero();
  REQUIRE_THROWS_AS(lcs::force_scale(lcs), std::invalid_argument);
  REQUIRE_THROWS_AS(lcs::scale_forces(lcs, 0.0), std::invalid_argument);
  REQUIRE_THROWS_AS(lcs::scale_forces(lcs, -1.0), std::invalid_argument);
}

TEST_CASE("lcs: scaling the forces leaves the next state as it is and divides the forces") {
  lcs::Lemke lemke(12);
  support::Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const VectorXd x =
        rolling_ball::state(random.uniform(-0.001, 0.004), random.uniform(-0.1, 0.1));
    const VectorXd u = 0.2 * random.vector(3);
    const lcs::Lcs given = rolling_ball::unscaled_lcs(x, 0.1);
    lcs::Lcs scaled = given;
    const double s = lcs::force_scale(given);
    lcs::scale_forces(scaled, s);
    VectorXd x_next(19), lambda(12), x_next_scaled(19), lambda_scaled(12);
    REQUIRE(lcs::step(given, x, u, lemke, x_next, lambda).ok());
    REQUIRE(lcs::step(scaled, x, u, lemke, x_next_scaled, lambda_scaled).ok());
    CHECK((x_next - x_next_scaled).norm() < 1e-9 * x_next.norm());
    // γ is not a force but scales with them; it is not unique where nothing slides
    CHECK((lambda - s * lambda_scaled).segment(2, 2).norm() < 1e-7 * lambda.norm());
  }
}

TEST_CASE("step: a mass on the ground rests, and flies when it is lifted") {
  // x = [height; velocity], λ = the ground's force, dt = 0.1, m = 2 kg, implicit in velocity
  const double dt = 0.1, m = 2.0, g = 9.81;
  lcs::Lcs lcs;
  lcs.A = (MatrixXd(2, 2) << 1, dt, 0, 1).finished();
  lcs.B = (MatrixXd(2, 1) << dt * dt / m, dt / m).finished();
  lcs.D = lcs.B;
  lcs.d = (VectorXd(2) << -dt * dt * g, -dt * g).finished();
  lcs.E = lcs.A.row(0);
  lcs.F = lcs.B.row(0);
  lcs.H = lcs.B.row(0);
  lcs.c = lcs.d.row(0);
  lcs::Lemke lemke(1);
  VectorXd x = VectorXd::Zero(2), u = VectorXd::Zero(1), x_next(2), lambda(1);
  REQUIRE(lcs::step(lcs, x, u, lemke, x_next, lambda).ok());
  REQUIRE(lambda[0] == Approx(m * g));
  REQUIRE(x_next.norm() < 1e-12);
  u[0] = 3.0 * m * g;
  REQUIRE(lcs::step(lcs, x, u, lemke, x_next, lambda).ok());
  REQUIRE(lambda[0] == 0.0);
  REQUIRE(x_next[1] == Approx(2.0 * g * dt));
}

TEST_CASE("step: it does not allocate") {
  const VectorXd x = rolling_ball::state(-0.0005), u = VectorXd::Constant(3, 0.1);
  const lcs::Lcs lcs = rolling_ball::unscaled_lcs(x, 0.0133);
  lcs::Lemke lemke(12);
  VectorXd x_next(19), lambda(12);
  std::int64_t heap_calls = -1;
  int solved = 0;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 10; ++i) solved += lcs::step(lcs, x, u, lemke, x_next, lambda).ok();
    heap_calls = heap.count();
  }
  REQUIRE(solved == 10);
  REQUIRE(heap_calls == 0);
}
