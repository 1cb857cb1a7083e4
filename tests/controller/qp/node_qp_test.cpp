#include "controller/qp/node_qp.hpp"

#include <algorithm>
#include <limits>

#include <catch2/catch.hpp>

#include "controller/c3/projection.hpp"
#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"
#include "tests/support/weighted_by.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using qp::NodeQp;

namespace {

using c3rt::test::weighted_by;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The node's problem of the ball: rows of unit length, many of them nearly or quite dependent.
struct Rows {
  MatrixXd C;
  VectorXd t;
  double tolerance;
};

Rows rows(const lcs::Lcs& lcs, const VectorXd& weight, const VectorXd& v) {
  MatrixXd J = MatrixXd::Zero(24, 34);
  J.block(0, 19, 12, 12).setIdentity();
  J.bottomRows(12) << lcs.E, lcs.F, lcs.H;
  Rows made{weight.cwiseSqrt().cwiseInverse().asDiagonal() * J.transpose(), J * v, 0.0};
  made.t.tail(12) += lcs.c;
  for (int i = 0; i < 24; ++i) {
    const double length = made.C.col(i).norm();
    made.C.col(i) /= length;
    made.t[i] /= length;
  }
  made.tolerance = 1e-11 * made.t.cwiseAbs().maxCoeff();
  return made;
}

}  // namespace

TEST_CASE("node QP: all pairs pinned at once or one by one is the same, and bounds the search") {
  support::Random random(17);
  const VectorXd weight = rolling_ball::costs(rolling_ball::Phase::kRoll).U.diagonal();
  const auto projection = make_miqp_projection(rolling_ball::sizes(), 1 << 20);
  projection->set_weights(weighted_by(weight.asDiagonal()));
  for (int trial = 0; trial < 2; ++trial) {
    const VectorXd x = rolling_ball::state(random.uniform(-0.002, 0.01), random.uniform(-0.3, 0.3));
    const lcs::Lcs lcs = rolling_ball::lcs(x);
    VectorXd v(34), delta(34);
    v << x + 0.02 * random.vector(19), 1000.0 * random.vector(12) + VectorXd::Constant(12, 500.0),
        random.vector(3);
    const Rows r = rows(lcs, weight, v);
    double best = kInfinity;
    NodeQp at_once(34, 24), one_by_one(34, 24);
    for (int mode = 0; mode < (1 << 12); ++mode) {
      at_once.start(r.t);
      one_by_one.start(r.t);
      NodeQp::Status step = one_by_one.solve(r.C, r.t, r.tolerance, kInfinity);
      for (int i = 0; i < 12; ++i) {
        const int side = mode & (1 << i) ? i : 12 + i;
        at_once.pin(side);
        one_by_one.pin(side);
        if (step == NodeQp::Status::kSolved) {
          step = one_by_one.solve(r.C, r.t, r.tolerance, kInfinity);
        }
      }
      const NodeQp::Status status = at_once.solve(r.C, r.t, r.tolerance, kInfinity);
      if (status != step) FAIL("trial " << trial << ", mode " << mode << ": the order decides");
      // x and u are free, so there is a point in every mode
      REQUIRE(status == NodeQp::Status::kSolved);
      REQUIRE(at_once.objective() == Approx(one_by_one.objective()).epsilon(1e-9));
      const VectorXd s = r.t + r.C.transpose() * at_once.f();
      REQUIRE(s.minCoeff() > -10.0 * r.tolerance);
      best = std::min(best, 2.0 * at_once.objective());
    }
    projection->start(lcs);
    const ProjectionReport report = projection->project(v, delta, {});
    CAPTURE(trial, report.nodes);
    CHECK(report.status == ProjectionStatus::kSolved);
    CHECK(report.objective == Approx(best).epsilon(1e-9));
  }
}

TEST_CASE("node QP: by hand, nearest point of a corner, a contradiction and a bound") {
  // f ∈ R², s = t + Cᵀ f with rows f_x, f_y and −f_x
  MatrixXd C(2, 3);
  C << 1, 0, -1, 0, 1, 0;
  VectorXd t(3);
  t << -3.0, -4.0, 10.0;  // f_x ≥ 3, f_y ≥ 4, f_x ≤ 10
  NodeQp qp(2, 3);
  qp.start(t);
  REQUIRE(qp.solve(C, t, 1e-12, kInfinity) == NodeQp::Status::kSolved);
  REQUIRE(qp.objective() == Approx(12.5));
  qp.pin(2);  // f_x = 10
  REQUIRE(qp.solve(C, t, 1e-12, kInfinity) == NodeQp::Status::kSolved);
  REQUIRE(qp.f()[0] == Approx(10.0));
  REQUIRE(qp.objective() == Approx(58.0));
  qp.pin(0);  // and f_x = 3
  REQUIRE(qp.solve(C, t, 1e-12, kInfinity) == NodeQp::Status::kInfeasible);
  qp.start(t);
  REQUIRE(qp.solve(C, t, 1e-12, 5.0) == NodeQp::Status::kAboveBound);
}
