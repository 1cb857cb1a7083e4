#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "controller/c3/projection.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

MatrixXd definite_matrix(support::Random& random, int n) {
  const MatrixXd half = random.matrix(n, n);
  return half * half.transpose() + 0.05 * MatrixXd::Identity(n, n);
}

lcs::Lcs random_lcs(support::Random& random, const Sizes& s, const MatrixXd& F) {
  lcs::Lcs lcs;
  lcs.E = random.matrix(s.n_lambda, s.n_x);
  lcs.F = F;
  lcs.H = random.matrix(s.n_lambda, s.n_u);
  lcs.c = random.vector(s.n_lambda);
  return lcs;
}

VectorXd gap(const lcs::Lcs& lcs, const Sizes& sizes, const VectorXd& z) {
  return lcs.E * sizes.x(z) + lcs.F * sizes.lambda(z) + lcs.H * sizes.u(z) + lcs.c;
}

Costs random_costs(support::Random& random, const Sizes& s, double alpha, double epsilon) {
  Costs costs;
  costs.convex = {definite_matrix(random, s.n_x), definite_matrix(random, s.n_u), alpha, epsilon};
  return costs;
}

/// The objective of (24) as it is printed, with the norms squared.
double objective(const lcs::Lcs& lcs, const Sizes& s, const ConvexWeights& weights,
                 const VectorXd& v, const VectorXd& delta) {
  const MatrixXd F = lcs.F + weights.epsilon * MatrixXd::Identity(lcs.F.rows(), lcs.F.cols());
  const VectorXd x = s.x(delta) - s.x(v), u = s.u(delta) - s.u(v);
  const VectorXd lambda = s.lambda(delta), moved = lambda - s.lambda(v);
  return 0.5 * x.dot(weights.Q_x * x) + 0.5 * u.dot(weights.Q_u * u) +
         0.5 * weights.alpha * moved.dot(F * moved) +
         0.5 * (1.0 - weights.alpha) * lambda.dot(F * lambda);
}

/// The minimiser by trying every set of active constraints. Independent of the solver: the KKT
/// system of each set, checked for feasibility; the least objective wins.
double enumerate(const lcs::Lcs& lcs, const Sizes& s, const ConvexWeights& weights,
                 const VectorXd& v, VectorXd& minimiser) {
  const int n = s.n_lambda, n_z = s.n_z();
  const MatrixXd F = 0.5 * (lcs.F + lcs.F.transpose()) + weights.epsilon * MatrixXd::Identity(n, n);
  MatrixXd W = MatrixXd::Zero(n_z, n_z);
  W.topLeftCorner(s.n_x, s.n_x) = weights.Q_x;
  W.block(s.n_x, s.n_x, n, n) = F;
  W.bottomRightCorner(s.n_u, s.n_u) = weights.Q_u;
  VectorXd linear = W * v;
  linear.segment(s.n_x, n) = weights.alpha * F * s.lambda(v);
  double best = kInfinity;
  for (int active = 0; active < (1 << (2 * n)); ++active) {
    MatrixXd rows = MatrixXd::Zero(2 * n, n_z);
    VectorXd right = VectorXd::Zero(2 * n);
    int count = 0;
    for (int i = 0; i < 2 * n; ++i) {
      if ((active & (1 << i)) == 0) continue;
      if (i < n) {
        rows(count, s.n_x + i) = 1.0;
      } else {
        rows.row(count) << lcs.E.row(i - n), lcs.F.row(i - n), lcs.H.row(i - n);
        right[count] = -lcs.c[i - n];
      }
      ++count;
    }
    MatrixXd kkt = MatrixXd::Zero(n_z + count, n_z + count);
    kkt.topLeftCorner(n_z, n_z) = W;
    kkt.topRightCorner(n_z, count) = rows.topRows(count).transpose();
    kkt.bottomLeftCorner(count, n_z) = rows.topRows(count);
    VectorXd rhs(n_z + count);
    rhs << linear, right.head(count);
    const VectorXd solution = support::least_squares(kkt, rhs);
    if ((kkt * solution - rhs).norm() > 1e-9 * (1.0 + rhs.norm())) continue;
    const VectorXd delta = solution.head(n_z);
    if (s.lambda(delta).minCoeff() < -1e-9 || gap(lcs, s, delta).minCoeff() < -1e-9) continue;
    const double value = objective(lcs, s, weights, v, delta);
    if (value >= best) continue;
    best = value;
    minimiser = delta;
  }
  return best;
}

ProjectionReport project(const lcs::Lcs& lcs, const Sizes& sizes, const Costs& costs,
                         const VectorXd& v, VectorXd& delta) {
  const auto projection = make_convex_projection(sizes);
  projection->set_weights(costs);
  projection->start(lcs);
  delta.resize(sizes.n_z());
  return projection->project(v, delta, {});
}

}  // namespace

TEST_CASE("convex projection: it is the minimiser that trying all active sets finds") {
  support::Random random(31);
  for (int trial = 0; trial < 120; ++trial) {
    const Sizes s{1 + random.index(4), 1 + random.index(4), 1 + random.index(2), 1};
    MatrixXd F = definite_matrix(random, s.n_lambda);
    if (trial % 3 == 1) {  // without symmetry: its symmetric part weighs, F itself constrains
      const MatrixXd skew = random.matrix(s.n_lambda, s.n_lambda);
      F += skew - skew.transpose();
    }
    if (trial % 3 == 2) {  // singular, as Anitescu's: epsilon makes it definite
      const MatrixXd half = random.matrix(s.n_lambda, 1 + s.n_lambda / 2);
      F = half * half.transpose();
    }
    const double alphas[] = {0.0, 0.01, 0.5, 1.0};
    const Costs costs = random_costs(random, s, alphas[trial % 4], trial % 3 == 2 ? 1e-3 : 0.0);
    const lcs::Lcs lcs = random_lcs(random, s, F);
    const VectorXd v = 2.0 * random.vector(s.n_z());
    VectorXd delta, expected;
    const ProjectionReport report = project(lcs, s, costs, v, delta);
    const double best = enumerate(lcs, s, costs.convex, v, expected);
    CAPTURE(trial, s.n_x, s.n_lambda, s.n_u);
    REQUIRE(best < kInfinity);
    CHECK(report.status == ProjectionStatus::kSolved);
    CHECK(objective(lcs, s, costs.convex, v, delta) == Approx(best).epsilon(1e-8).margin(1e-10));
    CHECK((delta - expected).norm() < 1e-6 * (1.0 + expected.norm()));
    CHECK(s.lambda(delta).minCoeff() >= 0.0);
    CHECK(gap(lcs, s, delta).minCoeff() > -1e-9 * (1.0 + delta.norm()));
    CHECK(report.objective == Approx((delta - v).squaredNorm()));
  }
}

TEST_CASE("convex projection: the violation is linear in alpha, within the bound of Lemma 3") {
  support::Random random(32);
  int violated = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Sizes s{2 + random.index(4), 1 + random.index(8), 1 + random.index(3), 1};
    MatrixXd F = definite_matrix(random, s.n_lambda);
    double epsilon = 0.0;
    if (trial % 2 == 1) {  // positive semidefinite, and what epsilon adds
      const MatrixXd half = random.matrix(s.n_lambda, 1 + s.n_lambda / 2);
      epsilon = 1e-3;
      F = half * half.transpose() + epsilon * MatrixXd::Identity(s.n_lambda, s.n_lambda);
    }
    const lcs::Lcs lcs = random_lcs(random, s, F);
    const VectorXd v = 2.0 * random.vector(s.n_z());
    const VectorXd eigenvalues = support::eigenvalues(F);
    const double condition = eigenvalues.maxCoeff() / eigenvalues.minCoeff();
    Costs costs = random_costs(random, s, 0.0, 0.0);
    for (double alpha = 1.0; alpha > 1e-7; alpha *= 0.1) {
      costs.convex.alpha = alpha;
      VectorXd delta;
      REQUIRE(project(lcs, s, costs, v, delta).status == ProjectionStatus::kSolved);
      const VectorXd y = gap(lcs, s, delta), lambda_d = s.lambda(v);
      const double violation = s.lambda(delta).dot(y);
      CAPTURE(trial, alpha, condition, violation);
      // (30) and (32)
      CHECK(violation <= alpha * lambda_d.norm() * (1.0 + condition) * y.norm() + 1e-9);
      violated += alpha == 1.0 && violation > 0.01;
    }
    costs.convex.alpha = 0.0;
    VectorXd delta;
    REQUIRE(project(lcs, s, costs, v, delta).status == ProjectionStatus::kSolved);
    CHECK(gap(lcs, s, delta).cwiseMin(s.lambda(delta)).cwiseAbs().maxCoeff() < 1e-7);
  }
  REQUIRE(violated > 20);
}

TEST_CASE("convex projection: halving a small alpha halves the violation") {
  support::Random random(33);
  int compared = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Sizes s{3, 4, 2, 1};
    const lcs::Lcs lcs = random_lcs(random, s, definite_matrix(random, 4));
    const VectorXd v = 2.0 * random.vector(s.n_z());
    Costs costs = random_costs(random, s, 0.0, 0.0);
    double violation[2];
    for (int half = 0; half < 2; ++half) {
      costs.convex.alpha = half == 0 ? 2e-5 : 1e-5;
      VectorXd delta;
      REQUIRE(project(lcs, s, costs, v, delta).status == ProjectionStatus::kSolved);
      violation[half] = s.lambda(delta).dot(gap(lcs, s, delta));
    }
    if (violation[0] < 1e-7) continue;  // complementary whatever alpha is
    CAPTURE(trial, violation[0], violation[1]);
    CHECK(violation[0] / violation[1] == Approx(2.0).epsilon(1e-2));
    ++compared;
  }
  REQUIRE(compared > 10);
}

TEST_CASE(
    "convex projection: F with a negative eigenvalue is refused, zero and singular F are not") {
  support::Random random(34);
  const Sizes s{3, 3, 2, 1};
  const Costs costs = random_costs(random, s, 0.3, 0.0);
  const VectorXd v = random.vector(s.n_z());
  VectorXd delta;
  for (const double entry : {-1.0, -1e-3}) {
    MatrixXd F = MatrixXd::Identity(3, 3);
    F(1, 1) = entry;
    CHECK(project(random_lcs(random, s, F), s, costs, v, delta).status ==
          ProjectionStatus::kNotConvex);
    CHECK(delta == v);
  }
  const MatrixXd indefinite = (MatrixXd(3, 3) << 1, 2, 0, 2, 1, 0, 0, 0, 1).finished();
  CHECK(project(random_lcs(random, s, indefinite), s, costs, v, delta).status ==
        ProjectionStatus::kNotConvex);
  for (const MatrixXd& F : {MatrixXd(MatrixXd::Zero(3, 3)), MatrixXd(MatrixXd::Ones(3, 3))}) {
    const lcs::Lcs lcs = random_lcs(random, s, F);
    CHECK(project(lcs, s, costs, v, delta).status == ProjectionStatus::kSolved);
    CHECK(s.lambda(delta).minCoeff() >= 0.0);
    CHECK(gap(lcs, s, delta).minCoeff() > -1e-9);
  }
}

TEST_CASE("convex projection: constraints without a common point are no point") {
  const Sizes s{1, 1, 1, 1};
  lcs::Lcs lcs;
  lcs.E = lcs.H = MatrixXd::Zero(1, 1);
  lcs.F = MatrixXd::Zero(1, 1);
  lcs.c = VectorXd::Constant(1, -1.0);  // y = −1 whatever δ is
  Costs costs;
  costs.convex = {MatrixXd::Identity(1, 1), MatrixXd::Identity(1, 1), 0.5, 1e-3};
  const VectorXd v = VectorXd::Ones(3);
  VectorXd delta;
  REQUIRE(project(lcs, s, costs, v, delta).status == ProjectionStatus::kEmpty);
  REQUIRE(delta == v);
}

TEST_CASE("convex projection: by hand, one pair with the target on the wrong side of both") {
  // min ½ 4 (x − 1)² + ½ 2 α (λ − 3)² + ½ 2 (1 − α) λ²  with  y = −x + 2 λ − 1 ≥ 0, α = 0.1: λ =
  // 0.3 would leave y = −1.4; the KKT system gives μ = 1.4 / (¼ + 2) and λ = 0.3 + μ, x = 1 − μ / 4
  const Sizes s{1, 1, 1, 1};
  lcs::Lcs lcs;
  lcs.E = -MatrixXd::Identity(1, 1);
  lcs.F = 2.0 * MatrixXd::Identity(1, 1);
  lcs.H = MatrixXd::Zero(1, 1);
  lcs.c = VectorXd::Constant(1, -1.0);
  Costs costs;
  costs.convex = {4.0 * MatrixXd::Identity(1, 1), MatrixXd::Identity(1, 1), 0.1, 0.0};
  const VectorXd v = (VectorXd(3) << 1.0, 3.0, 7.0).finished();
  VectorXd delta;
  REQUIRE(project(lcs, s, costs, v, delta).status == ProjectionStatus::kSolved);
  const double mu = 1.4 / 2.25;
  REQUIRE(delta[0] == Approx(1.0 - mu / 4.0));
  REQUIRE(delta[1] == Approx(0.3 + mu));
  REQUIRE(delta[2] == Approx(7.0));
}
