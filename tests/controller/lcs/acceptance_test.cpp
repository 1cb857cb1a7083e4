#include "controller/lcs/acceptance.hpp"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

namespace {

bool is_accepted(const MatrixXd& F, const VectorXd& q, const VectorXd& terms,
                 const VectorXd& lambda) {
  VectorXd R(q.size()), C(q.size());
  lcs::equilibrate(F, terms, R, C);
  return lcs::miss(F, q, terms, R, C, lambda).accepted();
}

bool is_accepted(const MatrixXd& F, const VectorXd& q, const VectorXd& lambda) {
  return is_accepted(F, q, q.cwiseAbs(), lambda);
}

MatrixXd matrix(double a, double b, double c, double d) {
  return (MatrixXd(2, 2) << a, b, c, d).finished();
}

}  // namespace

TEST_CASE("acceptance: a gap of -1 is refused beside a force of any size") {
  const VectorXd q = -VectorXd::Ones(2);
  for (const double force : {1e6, 1e10, 1e12, 1e24, 1e100}) {
    CAPTURE(force);
    CHECK_FALSE(is_accepted(matrix(0, 1, 1, 0), q, Vector2d(0, force)));
    CHECK_FALSE(is_accepted(matrix(0, 1, 0.1, 0), q, Vector2d(force, 0)));
    CHECK_FALSE(is_accepted(MatrixXd::Zero(1, 1), q.head(1), VectorXd::Constant(1, force)));
    // the force is in the row of the gap, by an entry that makes -1 small beside it, or not
    CHECK_FALSE(
        is_accepted(matrix(1, -1, -1, 1), Vector2d(-1, 0.5), Vector2d(force, force - 0.75)));
    CHECK_FALSE(is_accepted(matrix(1, -1, -1, 1), Vector2d(-1, 0.5), Vector2d(force, force)));
    CHECK_FALSE(is_accepted(matrix(1, -1, -1e-12, 1e-12), q, Vector2d(force, force)));
  }
}

TEST_CASE("acceptance: what rounding leaves is accepted, in any units") {
  support::Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + random.index(10);
    MatrixXd F = random.matrix(n, n);
    VectorXd lambda = random.vector(n).cwiseMax(0.0);
    VectorXd q = -F * lambda;
    for (int i = 0; i < n; ++i) q[i] += lambda[i] == 0.0 ? random.index(2) : 0.0;
    VectorXd wrong = q;  // a part in a thousand of one row
    const int row = random.index(n);
    const double gap = -1e-3 * (F.row(row).cwiseAbs() * lambda + 0.1);
    wrong[row] = gap - F.row(row) * lambda;
    for (int i = 0; i < n; ++i) {
      const double of_row = std::ldexp(1.0, random.index(53) - 26);
      const double unit = std::ldexp(1.0, random.index(53) - 26);
      F.row(i) *= of_row;
      q[i] *= of_row;
      wrong[i] *= of_row;
      F.col(i) *= unit;
      lambda[i] /= unit;
    }
    CAPTURE(trial, n);
    CHECK(is_accepted(F, q, lambda));
    CHECK_FALSE(is_accepted(F, wrong, lambda));
  }
}

TEST_CASE("acceptance: a gap is judged beside what its q was added up from") {
  // φ = 1000 − 1000 + rounding: 1e-10 is nothing beside it, and everything beside 1e-9 − 1e-9
  const MatrixXd F = MatrixXd::Ones(1, 1);
  const VectorXd q = VectorXd::Constant(1, -1e-10), none = VectorXd::Zero(1);
  CHECK(is_accepted(F, q, VectorXd::Constant(1, 2e3), none));
  CHECK_FALSE(is_accepted(F, q, VectorXd::Constant(1, 2e-9), none));
}

TEST_CASE("acceptance: negative forces, NaN and infinity are refused") {
  const MatrixXd F = MatrixXd::Identity(2, 2);
  const VectorXd q = Vector2d(1, 1);
  CHECK(is_accepted(F, q, Vector2d(0, 0)));
  CHECK_FALSE(is_accepted(F, q, Vector2d(-1, 0)));
  CHECK_FALSE(is_accepted(F, q, Vector2d(0, std::numeric_limits<double>::quiet_NaN())));
  CHECK_FALSE(is_accepted(F, q, Vector2d(0, std::numeric_limits<double>::infinity())));
  CHECK_FALSE(is_accepted(1e300 * F, q, Vector2d(0, 1e300)));
}

TEST_CASE("acceptance: what is exact in the units as given is accepted in all") {
  support::Random random(2);
  int exact = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + random.index(6);
    const MatrixXd F = random.matrix(n, n);
    const VectorXd lambda = random.vector(n).cwiseMax(0.0);
    VectorXd q = -F * lambda;
    q[random.index(n)] += std::pow(10.0, random.uniform(-16.0, 0.0));
    double residual = -1.0;
    if (!lcs::is_exact(F, q, q.cwiseAbs(), lambda, residual)) continue;
    ++exact;
    VectorXd R(n), C(n);
    lcs::equilibrate(F, q.cwiseAbs(), R, C);
    const lcs::LcpMiss missed = lcs::miss(F, q, q.cwiseAbs(), R, C, lambda);
    CHECK(missed.accepted());
    CHECK(missed.residual == residual);
  }
  CHECK(exact > 50);
}

TEST_CASE("equilibrate: the largest entry of every row and column is near 1, whatever the units") {
  support::Random random(3);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + random.index(8);
    MatrixXd F = random.matrix(n, n);
    VectorXd terms = random.vector(n).cwiseAbs(), R(n), C(n);
    for (int i = 0; i < n; ++i) {
      const double row = std::pow(10.0, random.uniform(-8.0, 8.0));
      F.row(i) *= row;
      terms[i] *= row;
      F.col(i) *= std::pow(10.0, random.uniform(-8.0, 8.0));
    }
    lcs::equilibrate(F, terms, R, C);
    const MatrixXd scaled = R.asDiagonal() * F * C.asDiagonal();
    CAPTURE(trial, n);
    CHECK(scaled.cwiseAbs().maxCoeff() < 16.0);
    CHECK(scaled.cwiseAbs().colwise().maxCoeff().minCoeff() > 1.0 / 64.0);
    for (const double factor : R) CHECK(std::exp2(std::ilogb(factor)) == factor);
  }
}
