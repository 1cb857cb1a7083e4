#include "controller/lcs/riccati.hpp"

#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd gain(const MatrixXd& P, const MatrixXd& A, const MatrixXd& B, const MatrixXd& R) {
  return support::solve_definite(R + B.transpose() * P * B, B.transpose() * P * A);
}

}  // namespace

TEST_CASE("riccati: a scalar system meets the quadratic formula") {
  const double a = 1.3, b = 0.7, q = 2.0, r = 0.5;
  // p = q + a² p − a² b² p² / (r + b² p)  ⇔  b² p² + (r (1 − a²) − q b²) p − q r = 0
  const double half = 0.5 * (r * (1 - a * a) - q * b * b);
  const double p = (-half + std::sqrt(half * half + b * b * q * r)) / (b * b);
  const auto one = [](double number) { return MatrixXd::Constant(1, 1, number); };
  CHECK(lcs::riccati(one(a), one(b), one(q), one(r))(0, 0) == Approx(p).epsilon(1e-12));
}

TEST_CASE("riccati: the solution meets the equation and stabilises random systems") {
  support::Random random(21);
  for (int trial = 0; trial < 30; ++trial) {
    const int n_x = 1 + random.index(8), n_u = 1 + random.index(3);
    const MatrixXd A = 0.8 * random.matrix(n_x, n_x), B = random.matrix(n_x, n_u);
    const MatrixXd root = random.matrix(n_x, n_x);
    const MatrixXd Q = root * root.transpose() + MatrixXd::Identity(n_x, n_x);
    const MatrixXd R = (0.1 + trial) * MatrixXd::Identity(n_u, n_u);
    const MatrixXd P = lcs::riccati(A, B, Q, R);
    const MatrixXd K = gain(P, A, B, R);
    CHECK((Q + A.transpose() * P * (A - B * K) - P).norm() < 1e-10 * P.norm());
    CHECK(P == P.transpose());
    CHECK((A - B * K).eigenvalues().cwiseAbs().maxCoeff() < 1.0);
  }
}

TEST_CASE("riccati: without input it is the sum of what the decaying state costs") {
  // an input that reaches nothing leaves the Lyapunov equation P = Q + Aᵀ P A
  const MatrixXd A = (MatrixXd(2, 2) << 0.5, 0.1, 0.0, 0.25).finished();
  MatrixXd P = MatrixXd::Zero(2, 2), power = MatrixXd::Identity(2, 2);
  for (int k = 0; k < 200; ++k) {
    P += power.transpose() * power;
    power = (A * power).eval();
  }
  const MatrixXd solved =
      lcs::riccati(A, MatrixXd::Zero(2, 1), MatrixXd::Identity(2, 2), MatrixXd::Identity(1, 1));
  CHECK((solved - P).norm() < 1e-12);
}

TEST_CASE("riccati: what cannot be solved is refused") {
  const MatrixXd one = MatrixXd::Ones(1, 1), two = 2.0 * one, zero = MatrixXd::Zero(1, 1);
  CHECK_THROWS_AS(lcs::riccati(two, zero, one, one), std::runtime_error);  // unstable, no input
  CHECK_THROWS_AS(lcs::riccati(two, one, one, zero), std::invalid_argument);
  CHECK_THROWS_AS(lcs::riccati(two, one, one, -one), std::invalid_argument);
  CHECK_THROWS_AS(lcs::riccati(two, one, MatrixXd::Ones(2, 2), one), std::invalid_argument);
}
