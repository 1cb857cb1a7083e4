#include "controller/miqp/big_m_projection.hpp"

#include <limits>

#include <catch2/catch.hpp>

#include "tests/support/random.hpp"

using namespace c3rt;

TEST_CASE("the projection by big-M is the exact one, up to the solver's gap and leak") {
  support::Random random(7);
  for (int i = 0; i < 4; ++i) {
    const c3::Sizes sizes{3, 4, 2, 1};
    lcs::Lcs lcs{random.matrix(3, 3), random.matrix(3, 2), random.matrix(3, 4), random.vector(3),
                 random.matrix(4, 3), random.matrix(4, 4), random.matrix(4, 2), random.vector(4)};
    lcs.F += 2.0 * Eigen::MatrixXd::Identity(4, 4);
    const Eigen::MatrixXd root = random.matrix(9, 9);
    c3::Costs costs;
    costs.U = root * root.transpose() + Eigen::MatrixXd::Identity(9, 9);
    const Eigen::VectorXd v = 3.0 * random.vector(9);

    const auto exact = c3::make_miqp_projection(sizes, 1 << 12);
    const auto big_m = miqp::make_big_m_projection(sizes, 1000.0, {});
    Eigen::VectorXd expected(9), delta(9);
    for (auto* projection : {exact.get(), big_m.get()}) {
      projection->set_weights(costs);
      projection->start(lcs);
    }
    const auto reference = exact->project(v, expected, {});
    const auto report = big_m->project(v, delta, {});
    REQUIRE(reference.status == c3::ProjectionStatus::kSolved);
    REQUIRE(report.status == c3::ProjectionStatus::kSolved);
    CHECK(report.objective == Approx(reference.objective).epsilon(2e-4));
    CHECK(report.objective == Approx((delta - v).dot(costs.U * (delta - v))).epsilon(1e-6));
    const Eigen::VectorXd gap =
        lcs.E * delta.head(3) + lcs.F * delta.segment(3, 4) + lcs.H * delta.tail(2) + lcs.c;
    CHECK(delta.segment(3, 4).cwiseMin(gap).cwiseAbs().maxCoeff() < 2e-3);  // 1e-6 × M, twice
  }
}

TEST_CASE("a point that is not finite is not projected by big-M") {
  const c3::Sizes sizes{1, 1, 1, 1};
  const auto one = [](double value) { return Eigen::MatrixXd::Constant(1, 1, value); };
  const lcs::Lcs lcs{one(1), one(1), one(1), one(0), one(1), one(1), one(1), one(0)};
  const auto projection = miqp::make_big_m_projection(sizes, 1000.0, {});
  c3::Costs costs;
  costs.U = Eigen::MatrixXd::Identity(3, 3);
  projection->set_weights(costs);
  projection->start(lcs);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(3), delta(3);
  v[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK(projection->project(v, delta, {}).status == c3::ProjectionStatus::kNotFinite);
}
