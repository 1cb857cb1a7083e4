// Random LCPs of every kind, checked by enumeration of all bases, and frictional contact with as
// many ties as there can be.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "controller/lcs/acceptance.hpp"
#include "controller/lcs/lemke.hpp"
#include "controller/lcs/simulate.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random.hpp"
#include "tests/support/resting_box.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using lcs::LcpReport;
using lcs::LcpStatus;
using lcs::Lemke;
using support::Random;

namespace {

using Wide = long double;
using MatrixXw = Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic>;
using VectorXw = Eigen::Matrix<Wide, Eigen::Dynamic, 1>;

/// The largest |min(λ_i, y_i)|, each beside what it is made of: forces beside the largest in their
/// units, gaps beside the terms of their row.
double violation(const MatrixXd& F, const VectorXd& terms, const VectorXd& q,
                 const VectorXd& lambda, const VectorXd& unit) {
  const VectorXw force = lambda.cast<Wide>();
  const VectorXw y = F.cast<Wide>() * force + q.cast<Wide>();
  const Wide largest = (force.array() / unit.cast<Wide>().array()).maxCoeff();
  Wide worst = -std::min(Wide(0), force.minCoeff());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Wide size = terms[i] + F.row(i).cwiseAbs().cast<Wide>().dot(unit.cast<Wide>()) * largest;
    const Wide gap = size > 0 ? y[i] / size : y[i];
    const Wide share = largest > 0 ? force[i] / unit[i] / largest : 0;
    worst = std::max(worst, std::abs(std::min(share, gap)));
  }
  return static_cast<double>(worst);
}

/// Whether one of the 2^n bases, none of them nearly singular, is a solution.
bool enumeration_solves(const MatrixXd& F, const VectorXd& q) {
  const int n = static_cast<int>(q.size());
  const MatrixXw F_wide = F.cast<Wide>();
  const VectorXw q_wide = q.cast<Wide>();
  for (int mode = 0; mode < (1 << n); ++mode) {
    std::vector<int> support;
    for (int i = 0; i < n; ++i) {
      if (mode & (1 << i)) support.push_back(i);
    }
    VectorXw lambda = VectorXw::Zero(n);
    if (!support.empty()) {
      const Eigen::FullPivLU<MatrixXw> lu(F_wide(support, support));
      const Wide smallest = lu.matrixLU().diagonal().cwiseAbs().minCoeff();
      if (!(smallest > Wide(1e-6) * lu.maxPivot())) continue;
      const VectorXw solution = lu.solve(-q_wide(support));
      for (std::size_t i = 0; i < support.size(); ++i) lambda[support[i]] = solution[i];
    }
    const VectorXw y = F_wide * lambda + q_wide;
    if (lambda.minCoeff() >= -1e-15L && y.minCoeff() >= -1e-15L) return true;
  }
  return false;
}

struct Lcp {
  MatrixXd F;
  VectorXd q;
};

/// Small whole numbers, in which ties, singular bases and rays are common.
MatrixXd whole(Random& random, int rows, int cols) {
  return MatrixXd::NullaryExpr(rows, cols, [&] { return double(random.index(5) - 2); });
}

Lcp random_lcp(Random& random, int kind, int n) {
  const MatrixXd half = random.matrix(n, n), skew = random.matrix(n, n);
  Lcp p{random.matrix(n, n), random.vector(n)};
  switch (kind) {
    case 0:  // P: one solution
      p.F = half * half.transpose() + 0.1 * MatrixXd::Identity(n, n) + skew - skew.transpose();
      break;
    case 1: {  // positive semidefinite, singular, with a solution and ties
      const MatrixXd tall = whole(random, n, 1 + n / 2);
      p.F = tall * tall.transpose();
      VectorXd lambda = whole(random, n, 1).cwiseMax(0.0);
      p.q = -p.F * lambda;
      for (int i = 0; i < n; ++i) p.q[i] += lambda[i] == 0.0 ? random.index(3) : 0;
      break;
    }
    case 2: {  // copositive: not negative and positive semidefinite
      p.F = half.cwiseAbs() + skew * skew.transpose();
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) p.F(i, j) *= random.index(3) == 0 && i != j ? 0.0 : 1.0;
      }
      break;
    }
    case 3: {  // a ring: each gap is opened by the next force alone, so that covers end on rays
      p.F.setZero();
      for (int i = 0; i < n; ++i) p.F(i, (i + 1) % n) = 0.1 + std::abs(random.uniform());
      p.q = -VectorXd::Ones(n).cwiseProduct(random.vector(n).cwiseAbs());
      break;
    }
    case 4:  // a gap that nothing opens
      p.F.row(0) = -p.F.row(0).cwiseAbs();
      p.F.row(0) *= random.index(2);
      p.q[0] = -std::abs(p.q[0]) - 0.01;
      break;
    case 5:  // two rows that contradict each other: with any ε there is an answer, and a huge one
      p.F = half * half.transpose();
      if (n > 1) {
        p.F.row(1) = -p.F.row(0);
        p.q[0] = -1.0;
        p.q[1] = 0.5;
      }
      break;
    case 6:
      p.F = whole(random, n, n);
      p.q = whole(random, n, 1);
      break;
    default:
      break;
  }
  return p;
}

/// Whether w − F λ = q has an answer with w, λ ≥ 0 and w_i λ_i = 0, by every choice, for each i, of
/// w_i, λ_i or neither to be above 0: where its columns are independent, they have one solution.
bool has_answer(const MatrixXd& F, const VectorXd& q) {
  const int n = static_cast<int>(q.size());
  int choices = 1;
  for (int i = 0; i < n; ++i) choices *= 3;
  for (int choice = 0; choice < choices; ++choice) {
    MatrixXd columns(n, n);
    int count = 0;
    for (int i = 0, left = choice; i < n; ++i, left /= 3) {
      if (left % 3 == 1) columns.col(count++) = VectorXd::Unit(n, i);
      if (left % 3 == 2) columns.col(count++) = -F.col(i);
    }
    if (count == 0) {
      if (q.isZero(0.0)) return true;
      continue;
    }
    const std::optional<VectorXd> v = support::solve(columns.leftCols(count), q);
    if (!v) continue;
    if ((columns.leftCols(count) * *v - q).cwiseAbs().maxCoeff() < 1e-9 && v->minCoeff() > -1e-9)
      return true;
  }
  return false;
}

}  // namespace

TEST_CASE("lemke property: what it calls solved is, and what enumeration solves it solves") {
  int solved = 0, none = 0;
  for (int i = 0; i < test::property_instances(); ++i) {
    Random random(static_cast<unsigned>(i));
    for (int kind = 0; kind < 8; ++kind) {
      const int n = 1 + random.index(8);
      const Lcp p = random_lcp(random, kind, n);
      Lemke lemke(n);
      VectorXd lambda(n);
      const LcpReport report = lemke.solve(p.F, p.q, lambda);
      CAPTURE(i, kind, n, p.F, p.q, lambda);
      if (report.status == LcpStatus::kSolved) {
        ++solved;
        CHECK(violation(p.F, p.q.cwiseAbs(), p.q, lambda, VectorXd::Ones(n)) < 1e-11);
      } else {
        ++none;
        CHECK_FALSE(enumeration_solves(p.F, p.q));
        CHECK(lambda.isZero(0.0));
      }
    }
  }
  CHECK(solved > 3 * test::property_instances());
  CHECK(none > test::property_instances());
}

TEST_CASE("lemke property: units of 1e-8 to 1e8 of every row and force change nothing") {
  int fewer_digits = 0;
  for (int i = 0; i < test::property_instances(); ++i) {
    Random random(static_cast<unsigned>(i));
    for (int kind = 0; kind < 8; ++kind) {
      const int n = 1 + random.index(8);
      const Lcp p = random_lcp(random, kind, n);
      VectorXd row(n), unit(n), plain(n), scaled(n);
      for (int k = 0; k < n; ++k) {
        row[k] = std::ldexp(1.0, random.index(53) - 26);
        unit[k] = std::ldexp(1.0, random.index(53) - 26);
      }
      Lemke lemke(n);
      const bool solved = lemke.solve(p.F, p.q, plain).status == LcpStatus::kSolved;
      const MatrixXd F = row.asDiagonal() * p.F * unit.asDiagonal();
      const VectorXd q = row.cwiseProduct(p.q);
      const LcpReport report = lemke.solve(F, q, scaled);
      CAPTURE(i, kind, n, p.F, p.q);
      // an answer without a regular basis is found in some units alone
      if ((report.status == LcpStatus::kSolved) != solved)
        CHECK_FALSE(enumeration_solves(p.F, p.q));
      if (report.status != LcpStatus::kSolved) continue;
      // what the largest force's rounding leaves in a row, 1e-12, is measured in the units that
      // `equilibrate` finds, and those are not always these
      const double missed = violation(F, q.cwiseAbs(), q, scaled, unit.cwiseInverse());
      CHECK(missed < 1e-7);
      fewer_digits += missed > 1e-9;
    }
  }
  CHECK(fewer_digits <= test::property_instances() / 5000);
}

TEST_CASE("lemke property: boxes on 4 to 10 corners, up to 64 rows, are solved") {
  int touching = 0, unsolved = 0;
  for (int i = 0; i < test::property_instances(); ++i) {
    Random random(static_cast<unsigned>(i));
    const support::ContactLcp p = support::resting_box(random);
    const auto n = static_cast<int>(p.q.size());
    Lemke lemke(n);
    VectorXd lambda(n);
    const LcpReport report = lemke.solve(p.F, p.q, p.terms, lambda);
    CAPTURE(i, n, report.pivots, report.residual);
    if (report.status != LcpStatus::kSolved) {
      CHECK(lambda.isZero(0.0));
      ++unsolved;
      continue;
    }
    CHECK(violation(p.F, p.terms, p.q, lambda, VectorXd::Ones(n)) < 1e-10);
    touching += lambda.maxCoeff() > 0.0;
  }
  // 2 of 10,000 end on rays from every start that is tried; none of the first 3,000
  CHECK(unsolved <= test::property_instances() / 2000);
  CHECK(touching > test::property_instances() / 2);
}

TEST_CASE("lemke property: a box goes on for 30 steps, whatever it does on its corners") {
  int stuck = 0;
  for (int i = 0; i < std::max(1, test::property_instances() / 10); ++i) {
    Random random(static_cast<unsigned>(i));
    const support::ContactLcp p = support::resting_box(random);
    const lcs::Simulation simulation = lcs::simulate(p.lcs, p.x, p.u.replicate(1, 30));
    CAPTURE(i, simulation.report.steps, simulation.report.residual);
    stuck += !simulation.report.ok();
  }
  CHECK(stuck <= test::property_instances() / 10000);
}

TEST_CASE("lemke property: up to 6 rows it says none only where no mode has an answer") {
  // whole numbers, so that many modes are singular and many answers degenerate
  int solved = 0, none = 0;
  for (int seed = 0; seed < 10 * c3rt::test::property_instances(); ++seed) {
    c3rt::support::Random random(static_cast<unsigned>(seed));
    const int n = 1 + random.index(seed % 10 == 0 ? 6 : 4);
    MatrixXd F(n, n);
    VectorXd q(n);
    for (int i = 0; i < n; ++i) {
      q[i] = random.index(4) - 2;
      for (int j = 0; j < n; ++j) F(i, j) = random.index(3) == 0 ? random.index(5) - 2 : 0;
    }
    Lemke lemke(n);
    VectorXd lambda(n);
    const LcpReport report = lemke.solve(F, q, lambda);
    const bool exists = has_answer(F, q);
    CAPTURE(seed, F, q, lambda);
    CHECK((report.status == LcpStatus::kSolved) == exists);
    if (exists) {
      CHECK(lambda.minCoeff() >= 0.0);
      CHECK(lambda.cwiseMin(F * lambda + q).cwiseAbs().maxCoeff() < 1e-8);
    }
    ++(exists ? solved : none);
  }
  CHECK(solved > none / 10);
  CHECK(none > solved / 10);
}
