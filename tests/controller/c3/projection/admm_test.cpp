#include <cmath>

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>

#include "controller/c3/projection.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Problem {
  Sizes sizes;
  lcs::Lcs lcs;
  Costs costs;
  VectorXd v;
};

Problem random_problem(support::Random& random) {
  Problem p{{1 + random.index(5), 1 + random.index(6), 1 + random.index(3), 1}, {}, {}, {}};
  const Sizes& s = p.sizes;
  const MatrixXd half = random.matrix(s.n_lambda, s.n_lambda);
  p.lcs.E = random.matrix(s.n_lambda, s.n_x);
  p.lcs.F = half * half.transpose() + 0.05 * MatrixXd::Identity(s.n_lambda, s.n_lambda);
  p.lcs.H = random.matrix(s.n_lambda, s.n_u);
  p.lcs.c = random.vector(s.n_lambda);
  p.costs.U = random.vector(s.n_z()).array().exp().matrix().asDiagonal();
  p.v = 2.0 * random.vector(s.n_z());
  return p;
}

double violation(const Problem& p, const VectorXd& z) {
  const VectorXd y =
      p.lcs.E * p.sizes.x(z) + p.lcs.F * p.sizes.lambda(z) + p.lcs.H * p.sizes.u(z) + p.lcs.c;
  return y.cwiseMin(p.sizes.lambda(z)).cwiseAbs().maxCoeff();
}

ProjectionReport project(Projection& projection, const Problem& p, VectorXd& delta) {
  projection.set_weights(p.costs);
  projection.start(p.lcs);
  delta.resize(p.sizes.n_z());
  return projection.project(p.v, delta, {});
}

}  // namespace

TEST_CASE(
    "ADMM projection: nearer to the set than v, mostly in it, and then hardly farther than exact") {
  support::Random random(71);
  int outside = 0, in_set = 0;
  double before = 0.0, after = 0.0, distance = 0.0, exact_distance = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    const Problem p = random_problem(random);
    if (violation(p, p.v) < 1e-6) continue;
    ++outside;
    VectorXd delta, exact;
    const ProjectionReport report = project(*make_admm_projection(p.sizes, {}), p, delta);
    const ProjectionReport best = project(*make_miqp_projection(p.sizes, 1 << 14), p, exact);
    CAPTURE(trial);
    REQUIRE(report.status == ProjectionStatus::kSolved);
    REQUIRE(best.status == ProjectionStatus::kSolved);
    CHECK(report.objective == Approx((delta - p.v).dot(p.costs.U * (delta - p.v))));
    before += violation(p, p.v);
    after += violation(p, delta);
    if (violation(p, delta) > 1e-8) continue;
    ++in_set;
    CHECK(report.objective >= best.objective * (1.0 - 1e-6) - 1e-12);
    distance += std::sqrt(report.objective);
    exact_distance += std::sqrt(best.objective);
  }
  CAPTURE(outside, in_set, before, after, distance, exact_distance);
  CHECK(outside > 250);
  CHECK(after < 0.05 * before);
  CHECK(in_set > 0.75 * outside);
  CHECK(distance < 1.1 * exact_distance);
}

TEST_CASE("ADMM projection: a point of the set stays, after one turn") {
  support::Random random(72);
  for (int trial = 0; trial < 50; ++trial) {
    Problem p = random_problem(random);
    VectorXd delta;
    REQUIRE(project(*make_miqp_projection(p.sizes, 1 << 14), p, delta).status ==
            ProjectionStatus::kSolved);
    p.v = delta;
    const ProjectionReport report = project(*make_admm_projection(p.sizes, {}), p, delta);
    CHECK(report.nodes == 1);
    CHECK((delta - p.v).norm() < 1e-9 * (1.0 + p.v.norm()));
  }
}

TEST_CASE("ADMM projection: more turns come nearer to the set, and the count of turns is a bound") {
  support::Random random(73);
  double few = 0.0, many = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    const Problem p = random_problem(random);
    VectorXd delta;
    for (const int turns : {2, 40}) {
      const ProjectionReport report =
          project(*make_admm_projection(p.sizes, {10.0, 1.0, turns}), p, delta);
      REQUIRE(report.status == ProjectionStatus::kSolved);
      REQUIRE(report.nodes <= turns);
      (turns == 2 ? few : many) += violation(p, delta);
    }
  }
  CHECK(many < 0.1 * few);
}

TEST_CASE("ADMM projection: inequalities without a common point are no point") {
  Problem p{{1, 1, 1, 1}, {}, {}, VectorXd::Ones(3)};
  p.lcs.E = p.lcs.F = p.lcs.H = MatrixXd::Zero(1, 1);
  p.lcs.c = VectorXd::Constant(1, -1.0);
  p.costs.U = MatrixXd::Identity(3, 3);
  VectorXd delta;
  REQUIRE(project(*make_admm_projection(p.sizes, {}), p, delta).status == ProjectionStatus::kEmpty);
  REQUIRE(delta == p.v);
}
