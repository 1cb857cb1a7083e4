#include "controller/lcs/lemke.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using lcs::LcpReport;
using lcs::LcpStatus;
using lcs::Lemke;

namespace {

double residual(const MatrixXd& F, const VectorXd& q, const VectorXd& lambda) {
  return (F * lambda + q).cwiseMin(lambda).cwiseAbs().maxCoeff();
}

/// All complementary bases, one by one. The first that is a solution; none if none is.
std::optional<VectorXd> enumerate(const MatrixXd& F, const VectorXd& q) {
  const int n = static_cast<int>(q.size());
  for (int mode = 0; mode < (1 << n); ++mode) {
    std::vector<int> support;
    for (int i = 0; i < n; ++i) {
      if (mode & (1 << i)) support.push_back(i);
    }
    VectorXd lambda = VectorXd::Zero(n);
    if (!support.empty()) {
      const std::optional<VectorXd> solution =
          c3rt::support::solve(F(support, support), -q(support));
      if (!solution) continue;
      for (std::size_t i = 0; i < support.size(); ++i) lambda[support[i]] = (*solution)[i];
    }
    if (lambda.minCoeff() >= -1e-10 && (F * lambda + q).minCoeff() >= -1e-10) return lambda;
  }
  return std::nullopt;
}

/// A P-matrix (positive definite symmetric part, any skew part): the solution is unique.
MatrixXd p_matrix(support::Random& random, int n) {
  const MatrixXd half = random.matrix(n, n), skew = random.matrix(n, n);
  return half * half.transpose() + 0.1 * MatrixXd::Identity(n, n) + skew - skew.transpose();
}

}  // namespace

TEST_CASE("lemke: on P-matrices it finds the one solution that enumeration finds") {
  support::Random random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + random.index(8);
    const MatrixXd F = p_matrix(random, n);
    const VectorXd q = random.vector(n);
    const auto expected = enumerate(F, q);
    REQUIRE(expected.has_value());
    Lemke lemke(n);
    VectorXd lambda(n);
    const LcpReport report = lemke.solve(F, q, lambda);
    CAPTURE(trial, n, report.pivots);
    CHECK(report.status == LcpStatus::kSolved);
    CHECK((lambda - *expected).norm() < 1e-8 * (1.0 + expected->norm()));
  }
}

TEST_CASE("lemke: frictional contact, copositive and degenerate, is solved at every state") {
  support::Random random(2);
  Lemke lemke(12);
  VectorXd lambda(12);
  int with_contact = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const VectorXd x = rolling_ball::state(random.uniform(-0.002, 0.01), random.uniform(-0.2, 0.2));
    const double mu = trial % 5 == 0 ? 0.0 : random.uniform(0.1, 1.0);
    const lcs::Lcs lcs = rolling_ball::unscaled_lcs(x, trial % 2 == 0 ? 0.1 : 0.0133, mu);
    // zero input leaves ties everywhere: nothing moves the ball sideways
    const VectorXd u = trial % 3 == 0 ? VectorXd::Zero(3) : VectorXd(random.vector(3));
    const VectorXd q = lcs.E * x + lcs.H * u + lcs.c;
    const LcpReport report = lemke.solve(lcs.F, q, lambda);
    CAPTURE(trial, report.pivots, report.residual);
    CHECK(report.status == LcpStatus::kSolved);
    CHECK(residual(lcs.F, q, lambda) < 1e-9);
    CHECK(report.residual < 1e-9);
    with_contact += lambda.segment(2, 2).maxCoeff() > 0.0;
  }
  REQUIRE(with_contact > 400);
}

TEST_CASE("lemke: equal rows, zero right sides and ties do not make it cycle") {
  support::Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + random.index(7);
    const MatrixXd half = random.matrix(n, 1 + n / 2);
    const MatrixXd F = half * half.transpose();  // positive semidefinite, singular
    VectorXd reachable = random.vector(n).cwiseAbs();
    for (int i = 0; i < n; ++i) {
      if (random.index(2) == 0) reachable[i] = 0.0;
    }
    VectorXd q = -F * reachable;  // λ = reachable is feasible, so a solution exists
    for (int i = 0; i < n; ++i) {
      if (reachable[i] == 0.0) q[i] += random.index(3);
    }
    Lemke lemke(n);
    VectorXd lambda(n);
    const LcpReport report = lemke.solve(F, q, lambda);
    CAPTURE(trial, n, report.pivots);
    CHECK(report.status == LcpStatus::kSolved);
    CHECK(residual(F, q, lambda) < 1e-9);
  }
}

TEST_CASE("lemke: where there is no solution it says ray and gives no forces") {
  Lemke lemke(2);
  VectorXd lambda = VectorXd::Ones(2);
  const MatrixXd F = (MatrixXd(2, 2) << -1, 0, 0, -1).finished();
  const Eigen::Vector2d q(-1, -2);
  REQUIRE_FALSE(enumerate(F, q).has_value());
  const LcpReport report = lemke.solve(F, q, lambda);
  REQUIRE(report.status == LcpStatus::kRay);
  REQUIRE(report.residual == Approx(2.0));
  REQUIRE(lambda.isZero());
}

TEST_CASE("lemke: a ray over random matrices is never reported for a unique solution") {
  // and whenever it reports a solution, it is one
  support::Random random(4);
  int rays = 0, solved = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const int n = 2 + random.index(4);
    const MatrixXd F = random.matrix(n, n);
    const VectorXd q = random.vector(n);
    Lemke lemke(n);
    VectorXd lambda(n);
    const LcpReport report = lemke.solve(F, q, lambda);
    if (report.status == LcpStatus::kSolved) {
      ++solved;
      CHECK(residual(F, q, lambda) < 1e-7);
      CHECK(enumerate(F, q).has_value());
    } else {
      ++rays;
      CHECK(report.status == LcpStatus::kRay);
      CHECK(lambda.isZero());
    }
  }
  REQUIRE(rays > 20);
  REQUIRE(solved > 100);
}

TEST_CASE("lemke: where every covering vector ends on a ray, another start finds the answer") {
  // each gap is opened by the other force alone
  const MatrixXd F = (MatrixXd(2, 2) << 0, 1, 1, 0).finished();
  Lemke lemke(2);
  VectorXd lambda(2);
  REQUIRE(lemke.solve(F, -VectorXd::Ones(2), lambda).status == LcpStatus::kSolved);
  CHECK(lambda == Eigen::Vector2d(1, 1));

  const MatrixXd weak = (MatrixXd(2, 2) << 0, 1, 0.1, 0).finished();
  REQUIRE(lemke.solve(weak, Eigen::Vector2d(-1, -0.1), lambda).status == LcpStatus::kSolved);
  CHECK((lambda - Eigen::Vector2d(1, 1)).norm() < 1e-15);

  // and of twelve rows, more than there are bases tried of
  MatrixXd ring = MatrixXd::Zero(12, 12);
  for (int i = 0; i < 12; ++i) ring(i, (i + 1) % 12) = 1.0 + i;
  Lemke large(12);
  VectorXd forces(12);
  REQUIRE(large.solve(ring, -VectorXd::Ones(12), forces).status == LcpStatus::kSolved);
  CHECK(residual(ring, -VectorXd::Ones(12), forces) < 1e-15);
}

TEST_CASE("lemke: a gap that no force opens, beside one that has a huge force for any ε > 0") {
  Lemke one(1), two(2);
  VectorXd lambda(1), forces(2);
  CHECK(one.solve(MatrixXd::Zero(1, 1), -VectorXd::Ones(1), lambda).status != LcpStatus::kSolved);
  CHECK(lambda.isZero(0.0));
  // two rows that ask for opposite signs
  const MatrixXd F = (MatrixXd(2, 2) << 1, -1, -1, 1).finished();
  const LcpReport report = two.solve(F, Eigen::Vector2d(-1.0, 0.5), forces);
  CHECK(report.status != LcpStatus::kSolved);
  CHECK(report.epsilon == 0.0);
  CHECK(forces.isZero(0.0));
  // the same in units that make every entry large, or small
  for (const double unit : {1e-12, 1e-6, 1e6, 1e12}) {
    CHECK(two.solve(unit * F, Eigen::Vector2d(-1.0, 0.5), forces).status != LcpStatus::kSolved);
    CHECK(two.solve(F, unit * Eigen::Vector2d(-1.0, 0.5), forces).status != LcpStatus::kSolved);
  }
}

TEST_CASE("lemke: a plate on eight contacts, whose ratios all but tie") {
  std::ifstream file(C3RT_SOURCE_DIRECTORY "/tests/data/lcp/plate_8_contacts.json");
  const nlohmann::json plate = nlohmann::json::parse(file);
  const auto n = static_cast<int>(plate.at("q").size());
  REQUIRE(n == 48);
  MatrixXd F = MatrixXd::Zero(n, n);
  VectorXd q(n), lambda(n);
  for (int i = 0; i < n; ++i) q[i] = plate.at("q")[static_cast<std::size_t>(i)].get<double>();
  for (const auto& entry : plate.at("F"))
    F(entry[0].get<int>(), entry[1].get<int>()) = entry[2].get<double>();
  Lemke lemke(n);
  const LcpReport report = lemke.solve(F, q, lambda);
  REQUIRE(report.status == LcpStatus::kSolved);
  CHECK(residual(F, q, lambda) < 1e-11);
  CHECK(lambda.minCoeff() >= 0.0);
}

TEST_CASE("lemke: forces of 1e6 N beside gaps of 1e-6 m, exact in every row") {
  // a press: stiffness 1e12 N/m, and a feather beside it
  Lemke lemke(2);
  VectorXd lambda(2);
  const MatrixXd F = (MatrixXd(2, 2) << 1e-12, 0, 1e-13, 1e3).finished();
  const Eigen::Vector2d q(-1e-6, -2e-7);
  REQUIRE(lemke.solve(F, q, lambda).status == LcpStatus::kSolved);
  CHECK(lambda[0] == Approx(1e6));
  CHECK(lambda[1] == Approx(1e-10));
}

TEST_CASE(
    "lemke: rows and columns in units of their own, 1e-8 to 1e8, change the units of the answer") {
  support::Random random(8);
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + random.index(8);
    const MatrixXd F = p_matrix(random, n);
    const VectorXd q = random.vector(n);
    VectorXd row(n), column(n), lambda(n), scaled(n);
    for (int i = 0; i < n; ++i) {
      row[i] = std::pow(10.0, random.uniform(-8.0, 8.0));
      column[i] = std::pow(10.0, random.uniform(-8.0, 8.0));
    }
    Lemke lemke(n);
    REQUIRE(lemke.solve(F, q, lambda).status == LcpStatus::kSolved);
    const MatrixXd scaled_F = row.asDiagonal() * F * column.asDiagonal();
    const LcpReport report = lemke.solve(scaled_F, row.cwiseProduct(q), scaled);
    CAPTURE(trial, n, report.pivots);
    CHECK(report.status == LcpStatus::kSolved);
    CHECK((column.cwiseProduct(scaled) - lambda).norm() < 1e-8 * (1.0 + lambda.norm()));
  }
}

TEST_CASE("lemke: an answer that lies on no complementary basis is found") {
  MatrixXd F = MatrixXd::Zero(2, 2);
  F(1, 0) = 1.0;
  const VectorXd q = Eigen::Vector2d(0.0, -1.0);
  Lemke lemke(2);
  VectorXd lambda(2);
  const LcpReport report = lemke.solve(F, q, lambda);
  CHECK(report.status == LcpStatus::kSolved);
  CHECK(lambda == Eigen::Vector2d(1.0, 0.0));
}

TEST_CASE("lemke: NaN and wrong sizes are a status, not a crash") {
  Lemke lemke(2);
  VectorXd lambda(2);
  Eigen::Matrix2d F = Eigen::Matrix2d::Identity();
  Eigen::Vector2d q(-1, -1);
  q[1] = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(lemke.solve(F, q, lambda).status == LcpStatus::kInaccurate);
  REQUIRE(lambda.isZero());
  F(0, 1) = std::numeric_limits<double>::infinity();
  REQUIRE(lemke.solve(F, Eigen::Vector2d(-1, -1), lambda).status == LcpStatus::kInaccurate);
  REQUIRE(lemke.solve(MatrixXd::Identity(3, 3), -VectorXd::Ones(3), lambda).status ==
          LcpStatus::kInaccurate);
}

TEST_CASE("lemke: it does not allocate, whether it solves, at once or by other ways, or not") {
  support::Random random(7);
  const MatrixXd F = p_matrix(random, 20), no_solution = -MatrixXd::Identity(20, 20);
  const VectorXd q = random.vector(20), negative = -VectorXd::Ones(20);
  const MatrixXd ring = (MatrixXd(2, 2) << 0, 1, 1, 0).finished(), none = MatrixXd::Zero(2, 2);
  const VectorXd closed = -VectorXd::Ones(2);
  Lemke lemke(20), small(2);
  VectorXd lambda(20), forces(2);
  std::int64_t heap_calls = -1;
  LcpReport solved{}, ray{}, by_a_start{}, small_ray{};
  {
    const support::AllocationCounter heap;
    solved = lemke.solve(F, q, lambda);
    ray = lemke.solve(no_solution, negative, lambda);
    by_a_start = small.solve(ring, closed, forces);
    small_ray = small.solve(none, closed, forces);
    heap_calls = heap.count();
  }
  REQUIRE(solved.status == LcpStatus::kSolved);
  REQUIRE(ray.status == LcpStatus::kRay);
  REQUIRE(by_a_start.status == LcpStatus::kSolved);
  REQUIRE(small_ray.status == LcpStatus::kRay);
  REQUIRE(heap_calls == 0);
}
