#include "vision/track/estimator.hpp"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"

using namespace c3rt::vision;

namespace {

constexpr double kRadius = 0.0315;
constexpr std::int64_t kPeriod = 12'500'000;  // 80 Hz [ns]
constexpr double kDt = 0.0125;

EstimatorParameters parameters() { return {0.8, 0.3, VelocityFilter::kTwoTap, 0.2, 0.03, 3}; }

Measurement seen(std::int64_t exposure_ns, const Eigen::Vector3d& p_WB) {
  return {exposure_ns, true, p_WB};
}

}  // namespace

TEST_CASE("estimator: the first measurement is taken over as it is, at rest") {
  Estimator estimator(parameters(), kRadius);
  REQUIRE_FALSE(estimator.estimate().valid);
  const Estimate& estimate = estimator.step(seen(kPeriod, {0.55, 0.1, kRadius}));
  REQUIRE(estimate.valid);
  REQUIRE(estimate.restarted);
  REQUIRE(estimate.p_WB == Eigen::Vector3d(0.55, 0.1, kRadius));
  REQUIRE(estimate.v_WB.isZero());
  REQUIRE(estimate.q_WB.isApprox(Eigen::Quaterniond::Identity()));
}

TEST_CASE("estimator: the taps of position and velocity are those of the paper's implementation") {
  // p1 = 0.2 * 0 + 0.8 * 1 = 0.8 mm, d1 = 0.8 mm / dt; p2 = 0.2 * 1 + 0.8 * 3 = 2.6 mm, d2 = 1.8 mm
  // / dt
  for (const double b : {0.3, 0.9}) {
    EstimatorParameters with = parameters();
    with.velocity_weight = b;
    Estimator estimator(with, kRadius);
    estimator.step(seen(0 * kPeriod + 1, {0, 0, 0}));
    Estimate estimate = estimator.step(seen(1 * kPeriod + 1, {0.001, 0, 0}));
    REQUIRE(estimate.p_WB.x() == Approx(0.0008).epsilon(1e-12));
    REQUIRE(estimate.v_WB.x() == Approx(b * 0.0008 / kDt).epsilon(1e-12));
    estimate = estimator.step(seen(2 * kPeriod + 1, {0.003, 0, 0}));
    REQUIRE(estimate.p_WB.x() == Approx(0.0026).epsilon(1e-12));
    REQUIRE(estimate.v_WB.x() == Approx((1 - b) * 0.0008 / kDt + b * 0.0018 / kDt).epsilon(1e-12));
  }
}

TEST_CASE(
    "estimator: the recursive velocity filter answers a step of velocity with a geometric series") {
  EstimatorParameters with = parameters();
  with.velocity_filter = VelocityFilter::kRecursive;
  with.position_weight = 1.0;
  Estimator estimator(with, kRadius);
  for (int k = 0; k <= 10; ++k) estimator.step(seen(1 + k * kPeriod, {0.1 * k * kDt, 0, 0}));
  REQUIRE(estimator.estimate().v_WB.x() == Approx(0.1 * (1 - std::pow(0.7, 10))).epsilon(1e-9));
}

TEST_CASE("estimator: a ball of constant velocity is known exactly but for the position's lag") {
  // the lag of the two taps is 0.2 samples
  const Eigen::Vector3d v(0.06, -0.08, 0.0);
  Estimator estimator(parameters(), kRadius);
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 20; ++k) {
    p = v * (k * kDt);
    estimator.step(seen(1 + k * kPeriod, p));
  }
  const Estimate& estimate = estimator.estimate();
  REQUIRE((estimate.v_WB - v).norm() < 1e-12);
  REQUIRE((estimate.p_WB - (p - 0.2 * kDt * v)).norm() < 1e-12);
  // rolling: the point that touches the table rests, v + ω × (−r) = 0
  const Eigen::Vector3d slip =
      estimate.v_WB + estimate.omega_WB.cross(Eigen::Vector3d(0, 0, -kRadius));
  REQUIRE(slip.norm() < 1e-12);
  REQUIRE(estimate.omega_WB.z() == 0.0);
}

TEST_CASE(
    "estimator: rolling one circumference turns the ball once round, on uneven exposure stamps "
    "too") {
  EstimatorParameters with = parameters();
  with.position_weight = 1.0;
  with.velocity_weight = 1.0;
  Estimator estimator(with, kRadius);
  const double circumference = 2 * M_PI * kRadius;
  const std::int64_t total_ns = 2'000'000'000;
  std::int64_t t = 1;
  estimator.step(seen(t, {0, 0, 0}));
  for (int k = 0; t < total_ns / 4 + 1; ++k) {
    t = std::min<std::int64_t>(t + (k % 3 == 0 ? 2 : 1) * kPeriod, total_ns / 4 + 1);
    estimator.step(seen(t, {circumference * static_cast<double>(t - 1) / total_ns, 0, 0}));
  }
  // a quarter of the way along x: a quarter turn about +y
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitY()));
  REQUIRE(estimator.estimate().q_WB.angularDistance(quarter) < 1e-9);
  REQUIRE(estimator.estimate().q_WB.norm() == Approx(1.0).epsilon(1e-14));
}

TEST_CASE("estimator: the exponential map agrees with the rotation matrix of the same vector") {
  const Eigen::Vector3d omega(0.4, -2.0, 1.5);
  const Eigen::Quaterniond start(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  for (const double dt : {1e-9, 1e-3, 0.5}) {
    const Eigen::AngleAxisd turn(omega.norm() * dt, omega.normalized());
    const Eigen::Matrix3d expected = turn.toRotationMatrix() * start.toRotationMatrix();
    REQUIRE(integrate_rotation(start, omega, dt).toRotationMatrix().isApprox(expected, 1e-14));
  }
}

TEST_CASE(
    "estimator: a lost ball keeps its last good numbers and is found again without a jump of "
    "velocity") {
  Estimator estimator(parameters(), kRadius);
  std::int64_t t = 1;
  for (int k = 0; k < 10; ++k, t += kPeriod) estimator.step(seen(t, {0.001 * k, 0, 0}));
  const Estimate last = estimator.estimate();
  for (int k = 0; k < 15; ++k, t += kPeriod) {
    const Estimate& estimate = estimator.step({t, false, {}});
    REQUIRE(estimate.valid);  // 15 * 12.5 ms is not yet longer than 0.2 s
    REQUIRE_FALSE(estimate.measured);
  }
  for (int k = 0; k < 5; ++k, t += kPeriod) estimator.step({t, false, {}});
  REQUIRE_FALSE(estimator.estimate().valid);
  REQUIRE(estimator.estimate().p_WB == last.p_WB);
  REQUIRE(estimator.estimate().v_WB == last.v_WB);

  const Eigen::Vector3d elsewhere(0.3, 0.2, 0);
  REQUIRE(estimator.step(seen(t, elsewhere)).valid);
  REQUIRE(estimator.estimate().p_WB == elsewhere);
  REQUIRE(estimator.estimate().v_WB.isZero());
  t += kPeriod;
  REQUIRE(estimator.step(seen(t, elsewhere)).v_WB.norm() < 1e-12);
}

TEST_CASE("estimator: one wild measurement is ignored, a ball that stays elsewhere is followed") {
  Estimator estimator(parameters(), kRadius);
  std::int64_t t = 1;
  for (int k = 0; k < 5; ++k, t += kPeriod) estimator.step(seen(t, {0.5, 0, 0}));
  estimator.step(seen(t, {0.6, 0, 0}));
  REQUIRE(estimator.estimate().p_WB.x() == Approx(0.5));
  REQUIRE_FALSE(estimator.estimate().measured);
  t += kPeriod;
  REQUIRE(estimator.step(seen(t, {0.5, 0, 0})).measured);
  t += kPeriod;
  for (int k = 0; k < 3; ++k, t += kPeriod) {
    REQUIRE(estimator.step(seen(t, {0.6, 0, 0})).p_WB.x() == Approx(0.5));
  }
  REQUIRE(estimator.step(seen(t, {0.6, 0, 0})).restarted);
  REQUIRE(estimator.estimate().p_WB.x() == 0.6);
  REQUIRE(estimator.estimate().v_WB.isZero());
}

TEST_CASE("estimator: not-a-number counts as not found, an old exposure changes nothing") {
  Estimator estimator(parameters(), kRadius);
  estimator.step(seen(5 * kPeriod, {0.5, 0, 0}));
  estimator.step(seen(6 * kPeriod, {std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  REQUIRE(estimator.estimate().p_WB.x() == 0.5);
  REQUIRE_FALSE(estimator.estimate().measured);
  estimator.step(seen(4 * kPeriod, {0.51, 0, 0}));
  REQUIRE(estimator.estimate().p_WB.x() == 0.5);
  REQUIRE(estimator.estimate().exposure_ns == 6 * kPeriod);
}

TEST_CASE("estimator: weights outside (0, 1] and lengths that are not positive are refused") {
  EstimatorParameters wrong = parameters();
  wrong.position_weight = 0.0;
  REQUIRE_THROWS_WITH(Estimator(wrong, kRadius), Catch::Contains("position_weight"));
  wrong = parameters();
  wrong.velocity_weight = 1.1;
  REQUIRE_THROWS_WITH(Estimator(wrong, kRadius), Catch::Contains("velocity_weight"));
  REQUIRE_THROWS_WITH(Estimator(parameters(), 0.0), Catch::Contains("ball_radius"));
}

TEST_CASE("estimator: step and predict do not allocate") {
  Estimator estimator(parameters(), kRadius);
  std::int64_t heap_calls = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  {
    const c3rt::support::AllocationCounter heap;
    for (int k = 1; k <= 1000; ++k) {
      const std::int64_t t = k * kPeriod;
      sum += estimator.predict(t);
      sum += estimator.step({t, k % 7 != 0, {0.001 * (k % 100), 0, 0}}).v_WB;
    }
    heap_calls = heap.count();
  }
  REQUIRE(sum.allFinite());
  REQUIRE(heap_calls == 0);
}

TEST_CASE("rotation: the vector between two orientations turns one into the other, the short way") {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  const Eigen::Quaterniond from(
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.2, 0.9, -0.3).normalized()));
  for (const double angle : {0.0, 1e-12, 1e-4, 0.3, 3.0, -3.0}) {
    Eigen::Quaterniond to = Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)) * from;
    for (int sign = 0; sign < 2; ++sign) {
      CAPTURE(angle, sign);
      CHECK((rotation_between(from, to) - angle * axis).norm() < 1e-12);
      to.coeffs() = -to.coeffs();  // the same orientation
    }
  }
}

TEST_CASE("estimator: the orientation of a body that does not roll follows its measurements") {
  EstimatorParameters p = parameters();
  p.velocity_filter = VelocityFilter::kPredicting;
  p.position_weight = 0.5;
  p.velocity_weight = 0.2;
  Estimator estimator(p, std::nullopt);
  // it turns at 0.8 rad/s about z while it slides along x
  const double omega = 0.8;
  const auto truth = [&](int k) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(0.3 + omega * k * kDt, Eigen::Vector3d::UnitZ()));
  };
  for (int k = 1; k <= 400; ++k) {
    Measurement measurement = seen(k * kPeriod, {0.5 + 0.05 * k * kDt, 0.0, 0.03});
    Eigen::Quaterniond measured = truth(k);
    if (k % 3 == 0) measured.coeffs() = -measured.coeffs();  // the same orientation
    measurement.q_WB = measured;
    estimator.step(measurement);
    if (k == 1) CHECK(estimator.estimate().q_WB.angularDistance(truth(1)) < 1e-9);
  }
  const Estimate& estimate = estimator.estimate();
  // a constant rate is learnt without lag, and rolling has no say in it
  CHECK(estimate.q_WB.angularDistance(truth(400)) < 1e-6);
  CHECK((estimate.omega_WB - Eigen::Vector3d(0.0, 0.0, omega)).norm() < 1e-6);
  CHECK((estimate.v_WB - Eigen::Vector3d(0.05, 0.0, 0.0)).norm() < 1e-6);
}

TEST_CASE(
    "estimator: noise of an orientation is smoothed, and one that is not finite is not taken") {
  EstimatorParameters p = parameters();
  p.velocity_filter = VelocityFilter::kPredicting;
  p.position_weight = 0.3;
  p.velocity_weight = 0.02;
  Estimator estimator(p, std::nullopt);
  double filtered = 0.0, raw = 0.0;
  for (int k = 1; k <= 4000; ++k) {
    // a saw-tooth of ±10 mrad with many frequencies stands for noise
    const double angle = 0.02 * (std::fmod(k * 0.6180339887, 1.0) - 0.5);
    Measurement measurement = seen(k * kPeriod, {0.5, 0.0, 0.03});
    measurement.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    const Estimate& estimate = estimator.step(measurement);
    if (k <= 1000) continue;
    raw += angle * angle;
    const double left = estimate.q_WB.angularDistance(Eigen::Quaterniond::Identity());
    filtered += left * left;
  }
  CHECK(filtered < 0.25 * raw);
  Measurement bad = seen(4001 * kPeriod, {0.5, 0.0, 0.03});
  bad.q_WB = Eigen::Quaterniond(std::numeric_limits<double>::quiet_NaN(), 0, 0, 0);
  CHECK_FALSE(estimator.step(bad).measured);
  CHECK(estimator.estimate().q_WB.coeffs().allFinite());
}
