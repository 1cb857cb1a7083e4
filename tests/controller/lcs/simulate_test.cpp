#include "controller/lcs/simulate.hpp"

#include <limits>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Catch::Matchers::Equals;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kMass = 2.0, kGravity = 9.81;

// x = [height; velocity], λ = the ground's force, implicit in velocity
lcs::Lcs falling_mass(double dt) {
  lcs::Lcs lcs;
  lcs.A = (MatrixXd(2, 2) << 1, dt, 0, 1).finished();
  lcs.B = (MatrixXd(2, 1) << dt * dt / kMass, dt / kMass).finished();
  lcs.D = lcs.B;
  lcs.d = (VectorXd(2) << -dt * dt * kGravity, -dt * kGravity).finished();
  lcs.E = lcs.A.row(0);
  lcs.F = lcs.B.row(0);
  lcs.H = lcs.B.row(0);
  lcs.c = lcs.d.row(0);
  return lcs;
}

// λ ⊥ −λ + x: two solutions for x > 0, none for x < 0, whatever small ε is added to F
lcs::Lcs unsolvable_below_zero() {
  lcs::Lcs lcs;
  lcs.A = MatrixXd::Identity(1, 1);
  lcs.B = MatrixXd::Ones(1, 1);
  lcs.D = MatrixXd::Zero(1, 1);
  lcs.d = VectorXd::Zero(1);
  lcs.E = MatrixXd::Ones(1, 1);
  lcs.F = -MatrixXd::Ones(1, 1);
  lcs.H = MatrixXd::Zero(1, 1);
  lcs.c = VectorXd::Zero(1);
  return lcs;
}

// F positive definite: every LCP has one solution
lcs::Lcs random_system(support::Random& random, int n_x, int n_lambda, int n_u) {
  lcs::Lcs lcs;
  lcs.A = 0.5 * random.matrix(n_x, n_x);
  lcs.B = random.matrix(n_x, n_u);
  lcs.D = random.matrix(n_x, n_lambda);
  lcs.d = random.vector(n_x);
  lcs.E = random.matrix(n_lambda, n_x);
  const MatrixXd root = random.matrix(n_lambda, n_lambda);
  lcs.F = root * root.transpose() + 0.1 * MatrixXd::Identity(n_lambda, n_lambda) + root -
          root.transpose();
  lcs.H = random.matrix(n_lambda, n_u);
  lcs.c = random.vector(n_lambda);
  return lcs;
}

}  // namespace

TEST_CASE("simulate: a mass falls by the discrete closed form, lands and rests on its weight") {
  const double dt = 0.01;
  const int N = 60;
  const VectorXd x_0 = (VectorXd(2) << 1.0, 0.0).finished();
  const lcs::Simulation result = lcs::simulate(falling_mass(dt), x_0, MatrixXd::Zero(1, N));
  REQUIRE(result.report.ok());
  REQUIRE(result.report.steps == N);
  REQUIRE(result.x.cols() == N + 1);
  REQUIRE(result.lambda.cols() == N);
  for (int k = 0; k <= 44; ++k) {  // g dt² k (k + 1) / 2 < 1 until k = 44
    CHECK(result.x(1, k) == Approx(-kGravity * dt * k).margin(1e-12));
    CHECK(result.x(0, k) == Approx(1.0 - 0.5 * kGravity * dt * dt * k * (k + 1)));
  }
  CHECK(result.x.col(N).norm() < 1e-9);
  CHECK(result.lambda(0, N - 1) == Approx(kMass * kGravity));
}

TEST_CASE("simulate: every state follows from the one before by one step") {
  support::Random random(11);
  const int N = 20;
  const lcs::Lcs lcs = random_system(random, 5, 6, 3);
  const VectorXd x_0 = random.vector(5);
  const MatrixXd u = random.matrix(3, N);
  const lcs::Simulation result = lcs::simulate(lcs, x_0, u);
  REQUIRE(result.report.ok());
  CHECK(result.x.col(0) == x_0);
  for (int k = 0; k < N; ++k) {
    const VectorXd x = result.x.col(k), lambda = result.lambda.col(k);
    const VectorXd y = lcs.E * x + lcs.F * lambda + lcs.H * u.col(k) + lcs.c;
    CHECK((lcs.A * x + lcs.B * u.col(k) + lcs.D * lambda + lcs.d - result.x.col(k + 1)).norm() <
          1e-12);
    CHECK(lambda.cwiseMin(y).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("simulate: a time-varying system uses at each step the matrices of that step") {
  // three steps of different length: the time that has passed is their sum
  const std::vector<lcs::Lcs> lcs{falling_mass(0.1), falling_mass(0.2), falling_mass(0.05)};
  const VectorXd x_0 = (VectorXd(2) << 10.0, 0.0).finished();
  const lcs::Simulation result = lcs::simulate(lcs, x_0, MatrixXd::Zero(1, 3));
  REQUIRE(result.report.ok());
  CHECK(result.x(1, 1) == Approx(-kGravity * 0.1));
  CHECK(result.x(1, 2) == Approx(-kGravity * 0.3));
  CHECK(result.x(1, 3) == Approx(-kGravity * 0.35));
  CHECK(result.x(0, 3) == Approx(10.0 - kGravity * (0.1 * 0.1 + 0.2 * 0.3 + 0.05 * 0.35)));
}

TEST_CASE("simulate: it stops at the step whose LCP has no answer and says which") {
  const VectorXd x_0 = VectorXd::Constant(1, 2.5);
  const MatrixXd u = MatrixXd::Constant(1, 6, -1.0);  // x = 2.5, 1.5, 0.5, −0.5
  const lcs::Simulation result = lcs::simulate(unsolvable_below_zero(), x_0, u);
  CHECK_FALSE(result.report.ok());
  CHECK(result.report.lcp.status == lcs::LcpStatus::kRay);
  CHECK(result.report.steps == 3);
  REQUIRE(result.x.cols() == 4);
  REQUIRE(result.lambda.cols() == 3);
  CHECK(result.x(0, 3) == Approx(-0.5));
}

TEST_CASE("simulate: wrong sizes and NaN are refused by name") {
  const lcs::Lcs lcs = falling_mass(0.1);
  const VectorXd x_0 = VectorXd::Zero(2);
  REQUIRE_THROWS_WITH(lcs::simulate(lcs, VectorXd::Zero(3), MatrixXd::Zero(1, 2)),
                      Equals("simulate: x_0: expected 2 x 1, got 3 x 1"));
  REQUIRE_THROWS_WITH(lcs::simulate(lcs, x_0, MatrixXd::Zero(2, 2)),
                      Equals("simulate: u: expected 1 x 2, got 2 x 2"));
  MatrixXd u = MatrixXd::Zero(1, 2);
  u(0, 1) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_THROWS_WITH(lcs::simulate(lcs, x_0, u),
                      Equals("simulate: u: expected finite numbers, got NaN or infinity"));
  REQUIRE_THROWS_WITH(lcs::simulate(std::vector<lcs::Lcs>{lcs}, x_0, MatrixXd::Zero(1, 2)),
                      Equals("simulate: expected 2 systems, one for each input, got 1"));
  REQUIRE_THROWS_WITH(
      lcs::simulate(std::vector<lcs::Lcs>{lcs, unsolvable_below_zero()}, x_0, MatrixXd::Zero(1, 2)),
      Equals("simulate: system 1 differs in size from system 0"));
}

TEST_CASE("simulate: into the caller's storage it gives the same bits and does not allocate") {
  support::Random random(12);
  const int N = 10;
  const lcs::Lcs lcs = random_system(random, 5, 6, 3);
  const std::vector<lcs::Lcs> varying(N, lcs);
  const VectorXd x_0 = random.vector(5);
  const MatrixXd u = random.matrix(3, N);
  const lcs::Simulation expected = lcs::simulate(lcs, x_0, u);
  lcs::Lemke lemke(6);
  MatrixXd x(5, N + 1), lambda(6, N), x_varying(5, N + 1), lambda_varying(6, N);
  const support::AllocationCounter counter;
  const lcs::SimulateReport report = lcs::simulate(lcs, x_0, u, lemke, x, lambda);
  const lcs::SimulateReport report_varying =
      lcs::simulate(varying, x_0, u, lemke, x_varying, lambda_varying);
  const auto count = counter.count();
  if (support::AllocationCounter::counts()) REQUIRE(count == 0);
  REQUIRE(report.ok());
  REQUIRE(report_varying.ok());
  CHECK(x == expected.x);
  CHECK(lambda == expected.lambda);
  CHECK(x_varying == expected.x);
  CHECK(lambda_varying == expected.lambda);
}
