#include "controller/c3/projection.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "controller/lcs/lemke.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"
#include "tests/support/weighted_by.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using c3rt::test::weighted_by;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

VectorXd gap(const lcs::Lcs& lcs, const Sizes& sizes, const VectorXd& z) {
  return lcs.E * sizes.x(z) + lcs.F * sizes.lambda(z) + lcs.H * sizes.u(z) + lcs.c;
}

/// Smallest (δ−v)ᵀU(δ−v) over the LCP's set, by trying for every pair each of: λ = 0, y = 0, both.
/// Independent of the solver: equality-constrained least squares, checked for feasibility.
double enumerate(const lcs::Lcs& lcs, const Sizes& sizes, const MatrixXd& U, const VectorXd& v,
                 VectorXd* minimiser = nullptr) {
  const int n = sizes.n_lambda, n_z = sizes.n_z();
  MatrixXd gap_rows(n, n_z);
  gap_rows << lcs.E, lcs.F, lcs.H;
  const MatrixXd half_inverse =  // U⁻¹ = half_inverseᵀ half_inverse
      support::inverse_root(U);
  int combinations = 1;
  for (int i = 0; i < n; ++i) combinations *= 3;
  double best = kInfinity;
  for (int code = 0; code < combinations; ++code) {
    int n_rows = 0;
    MatrixXd rows(2 * n, n_z);
    VectorXd right(2 * n);
    for (int i = 0, rest = code; i < n; ++i, rest /= 3) {
      if (rest % 3 != 1) {
        rows.row(n_rows).setZero();
        rows(n_rows, sizes.n_x + i) = 1.0;
        right[n_rows++] = 0.0;
      }
      if (rest % 3 != 0) {
        rows.row(n_rows) = gap_rows.row(i);
        right[n_rows++] = -lcs.c[i];
      }
    }
    // e = δ − v = half_inverseᵀ f, least ‖f‖ with rows e = right − rows v
    const MatrixXd transformed = rows.topRows(n_rows) * half_inverse.transpose();
    const VectorXd target = right.head(n_rows) - rows.topRows(n_rows) * v;
    const VectorXd f = support::least_squares(transformed, target);
    if ((transformed * f - target).norm() > 1e-9 * (1.0 + target.norm())) continue;
    if (f.squaredNorm() >= best) continue;
    const VectorXd delta = v + half_inverse.transpose() * f;
    const double slack = -1e-9 * (1.0 + delta.norm());
    if (sizes.lambda(delta).minCoeff() < slack) continue;
    if (gap(lcs, sizes, delta).minCoeff() < slack) continue;
    best = f.squaredNorm();
    if (minimiser != nullptr) *minimiser = delta;
  }
  return best;
}

lcs::Lcs random_lcs(support::Random& random, const Sizes& s, const MatrixXd& F) {
  lcs::Lcs lcs;
  lcs.A = random.matrix(s.n_x, s.n_x);
  lcs.B = random.matrix(s.n_x, s.n_u);
  lcs.D = random.matrix(s.n_x, s.n_lambda);
  lcs.d = random.vector(s.n_x);
  lcs.E = random.matrix(s.n_lambda, s.n_x);
  lcs.F = F;
  lcs.H = random.matrix(s.n_lambda, s.n_u);
  lcs.c = random.vector(s.n_lambda);
  return lcs;
}

MatrixXd definite(support::Random& random, int n) {
  const MatrixXd half = random.matrix(n, n);
  return half * half.transpose() + 0.05 * MatrixXd::Identity(n, n);
}

void compare(const lcs::Lcs& lcs, const Sizes& sizes, const MatrixXd& U, const VectorXd& v) {
  const auto projection = make_miqp_projection(sizes, 1 << 16);
  projection->set_weights(weighted_by(U));
  projection->start(lcs);
  VectorXd delta(sizes.n_z());
  const ProjectionReport report = projection->project(v, delta, {});
  const double expected = enumerate(lcs, sizes, U, v);
  CAPTURE(report.nodes, sizes.n_x, sizes.n_lambda, sizes.n_u);
  if (expected == kInfinity) {
    CHECK(report.status == ProjectionStatus::kEmpty);
    CHECK(delta == v);
    return;
  }
  CHECK(report.status == ProjectionStatus::kSolved);
  CHECK(report.objective == Approx(expected).epsilon(1e-8).margin(1e-12));
  CHECK(report.objective == Approx((delta - v).dot(U * (delta - v))).epsilon(1e-9).margin(1e-12));
  const double size = 1.0 + delta.cwiseAbs().maxCoeff();
  CHECK(gap(lcs, sizes, delta).cwiseMin(sizes.lambda(delta)).cwiseAbs().maxCoeff() < 1e-9 * size);
}

}  // namespace

TEST_CASE("MIQP projection: it is as near as the nearest point that enumeration finds") {
  support::Random random(11);
  for (int trial = 0; trial < 150; ++trial) {
    const Sizes sizes{1 + random.index(5), 1 + random.index(5), 1 + random.index(3), 1};
    const MatrixXd F = definite(random, sizes.n_lambda);
    const lcs::Lcs lcs = random_lcs(random, sizes, F);
    const MatrixXd U =
        trial % 2 == 0
            ? definite(random, sizes.n_z())
            : MatrixXd(
                  random.matrix(sizes.n_z(), 1).cwiseAbs().array().exp().matrix().asDiagonal());
    CAPTURE(trial);
    compare(lcs, sizes, U, 3.0 * random.vector(sizes.n_z()));
  }
}

TEST_CASE("MIQP projection: eight pairs, each with both modes open") {
  support::Random random(12);
  for (int trial = 0; trial < 3; ++trial) {
    const Sizes sizes{3, 8, 2, 1};
    const lcs::Lcs lcs = random_lcs(random, sizes, definite(random, 8));
    CAPTURE(trial);
    compare(lcs, sizes, definite(random, sizes.n_z()),
            VectorXd::Constant(sizes.n_z(), 1.0) + random.vector(sizes.n_z()));
  }
}

TEST_CASE("MIQP projection: ten pairs, as both contact models make them") {
  support::Random random(18);
  for (int trial = 0; trial < 2; ++trial) {
    const Sizes sizes{2, 10, 1, 1};
    lcs::Lcs lcs = random_lcs(random, sizes, MatrixXd::Zero(10, 10));
    if (trial == 0) {  // Anitescu: five contacts of two edges; F has rank 4
      const MatrixXd normals = random.matrix(5, 4), tangents = random.matrix(5, 4);
      MatrixXd J(10, 4);
      J << normals + tangents, normals - tangents;
      lcs.F = J * J.transpose();
    } else {  // Stewart and Trinkle: two contacts, [γ; normal; four edges], slips along ±t add up
              // to γ
      const MatrixXd normals = random.matrix(2, 3), tangents = random.matrix(3, 3);
      MatrixXd J(8, 3);
      J << normals, tangents, -tangents;
      lcs.F.block(2, 2, 8, 8) = J * J.transpose();
      for (int edge = 0; edge < 6; ++edge) {
        const int contact = edge % 3 == 2 ? 1 : 0;
        lcs.F(contact, 4 + edge) = -1.0;
        lcs.F(4 + edge, contact) = 1.0;
      }
      lcs.F(0, 2) = lcs.F(1, 3) = 0.7;
      lcs.E.topRows(2).setZero();
      lcs.H.topRows(2).setZero();
      lcs.c.head(2).setZero();
    }
    CAPTURE(trial);
    compare(lcs, sizes,
            MatrixXd(VectorXd(2.0 * random.vector(13)).array().exp().matrix().asDiagonal()),
            VectorXd::Constant(13, 0.3) + random.vector(13));
  }
}

TEST_CASE("MIQP projection: directions without weight count 1e-8 of the largest") {
  support::Random random(19);
  for (int trial = 0; trial < 60; ++trial) {
    const Sizes sizes{2, 1 + random.index(4), 2, 1};
    const lcs::Lcs lcs = random_lcs(random, sizes, definite(random, sizes.n_lambda));
    VectorXd weights = random.vector(sizes.n_z()).array().exp();
    for (int i = 0; i < sizes.n_z(); ++i) {
      if (random.index(2) == 0) weights[i] = 0.0;
    }
    weights[0] = 3.0;
    const MatrixXd U = weights.asDiagonal(),
                   instead = weights.cwiseMax(1e-8 * weights.maxCoeff()).asDiagonal();
    const VectorXd v = 2.0 * random.vector(sizes.n_z());
    const auto projection = make_miqp_projection(sizes, 1000);
    projection->set_weights(weighted_by(U));
    projection->start(lcs);
    VectorXd delta(sizes.n_z());
    const ProjectionReport report = projection->project(v, delta, {});
    CAPTURE(trial, weights.transpose());
    CHECK(report.status == ProjectionStatus::kSolved);
    const double distance = (delta - v).dot(instead * (delta - v));
    CHECK(distance == Approx(enumerate(lcs, sizes, instead, v)).epsilon(1e-6).margin(1e-12));
    CHECK(report.objective == Approx((delta - v).dot(U * (delta - v))).margin(1e-12));
  }
}

TEST_CASE("MIQP projection: singular, indefinite and zero F, equal rows and constant gaps") {
  support::Random random(13);
  for (int trial = 0; trial < 200; ++trial) {
    const Sizes sizes{1 + random.index(3), 2 + random.index(4), 1 + random.index(2), 1};
    MatrixXd F = MatrixXd::Zero(sizes.n_lambda, sizes.n_lambda);
    if (trial % 4 == 1) F = random.matrix(sizes.n_lambda, 1) * random.matrix(1, sizes.n_lambda);
    if (trial % 4 == 2) F = random.matrix(sizes.n_lambda, sizes.n_lambda);
    if (trial % 4 == 3) {
      const MatrixXd half = random.matrix(sizes.n_lambda, 1);
      F = half * half.transpose();
    }
    lcs::Lcs lcs = random_lcs(random, sizes, F);
    if (trial % 3 == 0) {  // the same contact twice
      lcs.E.row(1) = lcs.E.row(0);
      lcs.F.row(1) = lcs.F.row(0);
      lcs.H.row(1) = lcs.H.row(0);
      lcs.c[1] = lcs.c[0];
    }
    if (trial % 5 == 0) {  // a gap that nothing moves: above zero, at zero or (no point) below
      lcs.E.row(0).setZero();
      lcs.F.row(0).setZero();
      lcs.H.row(0).setZero();
      lcs.c[0] = static_cast<double>(random.index(3) - 1);
    }
    VectorXd v = 2.0 * random.vector(sizes.n_z());
    if (trial % 7 == 0) sizes.lambda(v).setZero();
    CAPTURE(trial);
    compare(lcs, sizes, definite(random, sizes.n_z()), v);
  }
}

TEST_CASE("MIQP projection: a point of the set stays where it is") {
  const VectorXd x = rolling_ball::state(0.002);
  const lcs::Lcs lcs = rolling_ball::lcs(x);
  const Sizes sizes = rolling_ball::sizes();
  lcs::Lemke lemke(sizes.n_lambda);
  VectorXd v = VectorXd::Zero(sizes.n_z());
  sizes.x(v) = x;
  REQUIRE(lemke.solve(lcs.F, VectorXd(lcs.E * x + lcs.c), sizes.lambda(v)).status ==
          lcs::LcpStatus::kSolved);
  REQUIRE(sizes.lambda(v).maxCoeff() > 0.0);
  const auto projection = make_miqp_projection(sizes, 1000);
  projection->set_weights(rolling_ball::costs(rolling_ball::Phase::kRoll));
  projection->start(lcs);
  VectorXd delta(sizes.n_z());
  const ProjectionReport report = projection->project(v, delta, {});
  REQUIRE(report.status == ProjectionStatus::kSolved);
  REQUIRE((delta - v).norm() < 1e-8 * v.norm());
}

TEST_CASE("MIQP projection: coordinates without weight move as far as they like") {
  // λ has no weight at all: [C3, V-B.3.b] the projection is then the LCP of the unchanged x and u
  support::Random random(14);
  for (int trial = 0; trial < 50; ++trial) {
    const Sizes sizes{3, 3, 2, 1};
    const lcs::Lcs lcs = random_lcs(random, sizes, definite(random, 3));
    MatrixXd U = MatrixXd::Identity(sizes.n_z(), sizes.n_z());
    U.block(3, 3, 3, 3).setZero();
    const auto miqp = make_miqp_projection(sizes, 1000), lcp = make_lcp_projection(sizes);
    VectorXd by_miqp(sizes.n_z()), by_lcp(sizes.n_z());
    const VectorXd v = random.vector(sizes.n_z());
    for (const auto& [projection, delta] :
         {std::pair{miqp.get(), &by_miqp}, {lcp.get(), &by_lcp}}) {
      projection->set_weights(weighted_by(U));
      projection->start(lcs);
      REQUIRE(projection->project(v, *delta, {}).status == ProjectionStatus::kSolved);
    }
    CAPTURE(trial);
    // the 1e-8 that stands in for no weight shows
    CHECK((by_miqp - by_lcp).norm() < 1e-5 * (1.0 + by_lcp.norm()));
  }
}

TEST_CASE("MIQP projection: a bound on nodes is reported and leaves a point of the set, if any") {
  support::Random random(15);
  const Sizes sizes{3, 8, 2, 1};
  int ended_early = 0, without_point = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const lcs::Lcs lcs = random_lcs(random, sizes, definite(random, 8));
    const MatrixXd U = definite(random, sizes.n_z());
    const VectorXd v = VectorXd::Constant(sizes.n_z(), 1.0) + random.vector(sizes.n_z());
    VectorXd delta(sizes.n_z());
    for (const int max_nodes : {1, 8, 12}) {
      const auto projection = make_miqp_projection(sizes, max_nodes);
      projection->set_weights(weighted_by(U));
      projection->start(lcs);
      const ProjectionReport report = projection->project(v, delta, {});
      CHECK(report.nodes <= max_nodes);
      if (!has_point(report.status)) {
        CHECK(report.status == ProjectionStatus::kNotFound);
        ++without_point;
        CHECK(delta == v);
        continue;
      }
      ended_early += report.status == ProjectionStatus::kNodeLimit;
      CHECK(gap(lcs, sizes, delta).cwiseMin(sizes.lambda(delta)).cwiseAbs().maxCoeff() < 1e-8);
    }
  }
  REQUIRE(ended_early > 0);
  REQUIRE(without_point > 0);
}

TEST_CASE("LCP projection: state and input stay, the force is the LCP's") {
  const VectorXd x = rolling_ball::state(0.001);
  const lcs::Lcs lcs = rolling_ball::lcs(x);
  const Sizes sizes = rolling_ball::sizes();
  const auto projection = make_lcp_projection(sizes);
  projection->set_weights(rolling_ball::costs(rolling_ball::Phase::kRoll));
  projection->start(lcs);
  support::Random random(16);
  VectorXd v = 0.1 * random.vector(sizes.n_z()), delta(sizes.n_z());
  sizes.x(v) = x;
  REQUIRE(projection->project(v, delta, {}).status == ProjectionStatus::kSolved);
  REQUIRE(sizes.x(delta) == sizes.x(v));
  REQUIRE(sizes.u(delta) == sizes.u(v));
  REQUIRE(gap(lcs, sizes, delta).cwiseMin(sizes.lambda(delta)).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("LCP projection: only the LCP's own answer is one, not that of F + ε I") {
  // each gap is opened by the other force alone; λ = [1e12, 0] leaves one at −1
  lcs::Lcs lcs;
  lcs.A = MatrixXd::Identity(1, 1);
  lcs.B = lcs.d = MatrixXd::Zero(1, 1);
  lcs.D = MatrixXd::Zero(1, 2);
  lcs.E = lcs.H = MatrixXd::Zero(2, 1);
  const Sizes sizes{1, 2, 1, 1};
  const auto projection = make_lcp_projection(sizes);
  projection->set_weights(weighted_by(MatrixXd::Identity(4, 4)));
  const VectorXd v = VectorXd::Zero(4);
  VectorXd delta(4);
  for (const double weak : {1.0, 0.1, 1e-3}) {
    lcs.F = (MatrixXd(2, 2) << 0, 1, weak, 0).finished();
    lcs.c = Eigen::Vector2d(-1, -weak);
    projection->start(lcs);
    REQUIRE(projection->project(v, delta, {}).status == ProjectionStatus::kSolved);
    CHECK((sizes.lambda(delta) - Eigen::Vector2d(1, 1)).norm() < 1e-14);
  }
  // two rows that ask for opposite signs: no point, whatever ε has
  lcs.F = (MatrixXd(2, 2) << 1, -1, -1, 1).finished();
  lcs.c = Eigen::Vector2d(-1, 0.5);
  projection->start(lcs);
  CHECK(projection->project(v, delta, {}).status == ProjectionStatus::kNotFound);
  CHECK(delta == v);
}

TEST_CASE("projections: NaN is a status, and delta is v then") {
  const Sizes sizes = rolling_ball::sizes();
  const lcs::Lcs lcs = rolling_ball::lcs(rolling_ball::state());
  const MatrixXd U = rolling_ball::costs(rolling_ball::Phase::kRoll).U;
  VectorXd v = VectorXd::Zero(sizes.n_z()), delta(sizes.n_z());
  v[20] = std::numeric_limits<double>::quiet_NaN();
  for (const auto& projection : {make_miqp_projection(sizes, 10), make_lcp_projection(sizes)}) {
    projection->set_weights(weighted_by(U));
    projection->start(lcs);
    REQUIRE(projection->project(v, delta, {}).status == ProjectionStatus::kNotFinite);
  }
}
