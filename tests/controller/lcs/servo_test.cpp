#include "controller/lcs/servo.hpp"

#include <catch2/catch.hpp>

#include "controller/lcs/simulate.hpp"
#include "controller/lcs/step.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kMass = 2.0, kStep = 0.05, kWall = 0.1, kStiffness = 1e5, kDamping = 300.0;

// x = [position; velocity] of a mass before a wall, λ the wall's impulse, u a force
lcs::Lcs mass_before_wall() {
  lcs::Lcs lcs;
  lcs.A = (MatrixXd(2, 2) << 1, kStep, 0, 1).finished();
  lcs.B = (MatrixXd(2, 1) << kStep * kStep / kMass, kStep / kMass).finished();
  lcs.D = (MatrixXd(2, 1) << -kStep / kMass, -1 / kMass).finished();
  lcs.d = VectorXd::Zero(2);
  // the wall is at kWall: kWall − p⁺ ≥ 0
  lcs.E = -lcs.A.row(0);
  lcs.F = -lcs.D.row(0);
  lcs.H = -lcs.B.row(0);
  lcs.c = VectorXd::Constant(1, kWall);
  return lcs;
}

lcs::Lcs random_system(support::Random& random, int n_x, int n_lambda, int n_u) {
  lcs::Lcs lcs;
  lcs.A = 0.5 * random.matrix(n_x, n_x);
  lcs.B = 0.3 * random.matrix(n_x, n_u);
  lcs.D = 0.1 * random.matrix(n_x, n_lambda);
  lcs.d = random.vector(n_x);
  lcs.E = random.matrix(n_lambda, n_x);
  const MatrixXd root = random.matrix(n_lambda, n_lambda);
  lcs.F = root * root.transpose() + 4.0 * MatrixXd::Identity(n_lambda, n_lambda);
  lcs.H = 0.3 * random.matrix(n_lambda, n_u);
  lcs.c = random.vector(n_lambda);
  return lcs;
}

}  // namespace

TEST_CASE("servo: a simulation of the closed loop is that of the system with its inputs") {
  support::Random random(7);
  constexpr int kX = 5, kLambda = 4, kU = 2, kN = 6;
  for (int trial = 0; trial < 50; ++trial) {
    CAPTURE(trial);
    const lcs::Lcs lcs = random_system(random, kX, kLambda, kU);
    const MatrixXd K = 0.2 * random.matrix(kU, kX);
    const MatrixXd r = random.matrix(kX, kN);
    const VectorXd x_0 = random.vector(kX);
    lcs::Lcs closed;
    MatrixXd G;
    lcs::close_loop(lcs, K, closed, G);
    const lcs::Simulation tracked = lcs::simulate(closed, x_0, G * r);
    REQUIRE(tracked.report.ok());
    // the law looks at the end of the step, which the simulation says
    MatrixXd u(kU, kN);
    for (int k = 0; k < kN; ++k) u.col(k) = K * (r.col(k) - tracked.x.col(k + 1));
    for (int k = 0; k < kN; ++k) {
      const VectorXd x = tracked.x.col(k), lambda = tracked.lambda.col(k);
      const VectorXd next = lcs.A * x + lcs.B * u.col(k) + lcs.D * lambda + lcs.d;
      CHECK((next - tracked.x.col(k + 1)).norm() < 1e-9 * (1.0 + next.norm()));
      const VectorXd gap = lcs.E * x + lcs.F * lambda + lcs.H * u.col(k) + lcs.c;
      CHECK(gap.cwiseMin(lambda).cwiseAbs().maxCoeff() < 1e-8);
    }
  }
}

TEST_CASE("servo: however stiff for the step, a mass follows its reference and stops at a wall") {
  const lcs::Lcs lcs = mass_before_wall();
  const MatrixXd K = (MatrixXd(1, 2) << kStiffness, kDamping).finished();
  lcs::Lcs closed;
  MatrixXd G;
  lcs::close_loop(lcs, K, closed, G);
  MatrixXd r = MatrixXd::Zero(2, 10);
  for (int k = 0; k < 10; ++k) r(0, k) = k < 5 ? 0.01 * (k + 1) : 0.2;
  const lcs::Simulation tracked = lcs::simulate(closed, VectorXd::Zero(2), G * r);
  REQUIRE(tracked.report.ok());
  for (int k = 0; k < 5; ++k) CHECK(tracked.x(0, k + 1) == Approx(r(0, k)).margin(2e-3));
  // the law that looks at the beginning of a step multiplies errors by Δt² k/m ≫ 1
  CHECK(kStep * kStep * kStiffness / kMass > 100.0);
  CHECK(tracked.x(0, 10) == Approx(kWall));
  CHECK(tracked.lambda(0, 9) == Approx(kStep * kStiffness * (0.2 - kWall)).epsilon(1e-6));
}
