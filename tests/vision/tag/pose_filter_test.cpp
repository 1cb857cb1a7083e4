#include "vision/tag/pose_filter.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "controller/base/random.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"

using namespace c3rt::vision;
using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::int64_t kPeriod = 25'000'000;  // [ns]
constexpr double kDt = 0.025;

PoseFilterParameters parameters() { return {0.1, 1.0, 0.2, 6.0, 3, 0.5}; }

Matrix6 covariance(double position, double angle) {
  Vector6 sigma;
  sigma << Vector3d::Constant(position), Vector3d::Constant(angle);
  return sigma.cwiseAbs2().asDiagonal();
}

Measurement seen(std::int64_t exposure_ns, const Vector3d& p, const Quaterniond& q,
                 const Matrix6& of = covariance(2e-4, 2e-3)) {
  return {exposure_ns, true, p, q, of};
}

Quaterniond about(const Vector3d& theta) {
  return Quaterniond(Eigen::AngleAxisd(theta.norm(), theta.normalized()));
}

struct State {
  Vector3d p, v, omega;
  Quaterniond q;
};

/// The equations of the class comment, by themselves.
State gone_on(const State& from, double dt, double memory) {
  const double s = memory * (1.0 - std::exp(-dt / memory));
  return {from.p + s * from.v, from.v * std::exp(-dt / memory), from.omega * std::exp(-dt / memory),
          about(s * from.omega) * from.q};
}

State moved(const State& from, const Vector12& by) {
  return {from.p + by.head<3>(), from.v + by.segment<3>(6), from.omega + by.tail<3>(),
          by.segment<3>(3).norm() > 0 ? about(by.segment<3>(3)) * from.q : from.q};
}

Vector12 difference(const State& a, const State& b) {
  const Eigen::AngleAxisd turn(a.q * b.q.conjugate());
  Vector12 e;
  e << a.p - b.p, turn.angle() * turn.axis(), a.v - b.v, a.omega - b.omega;
  return e;
}

}  // namespace

TEST_CASE("pose filter: the error goes on as finite differences of the motion say") {
  c3rt::support::Random random(3);
  for (const double speed : {0.0, 1e-4, 1.0, 20.0}) {
    const Vector3d axis = random.vector(3).normalized();
    const State at{random.vector(3), random.vector(3), speed * axis + Vector3d::Constant(1e-9),
                   about(random.vector(3))};
    const State next = gone_on(at, 0.05, parameters().memory);
    const auto F = PoseFilter::transition(parameters(), at.omega, 0.05);
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 12; ++i) {
      const Vector12 by = kStep * Vector12::Unit(i);
      const Vector12 column =
          (difference(gone_on(moved(at, by), 0.05, parameters().memory), next) -
           difference(gone_on(moved(at, -by), 0.05, parameters().memory), next)) /
          (2.0 * kStep);
      CAPTURE(speed, i);
      CHECK((column - F.col(i)).norm() < 1e-7);
    }
  }
}

TEST_CASE("pose filter: its noise is that of a velocity drawn anew in many small steps") {
  // the sum over steps of F Q_small Fᵀ, with Q_small = (2 σ² / τ) Δ on the velocity
  const PoseFilterParameters p = parameters();
  constexpr int kSteps = 20000;
  const double small = 0.1 / kSteps;
  PoseFilter::Matrix12 sum = PoseFilter::Matrix12::Zero(), each = PoseFilter::Matrix12::Zero();
  each.diagonal().segment<3>(6).setConstant(2.0 * p.speed * p.speed / p.memory * small);
  each.diagonal().tail<3>().setConstant(2.0 * p.angular_speed * p.angular_speed / p.memory * small);
  const auto F = PoseFilter::transition(p, Vector3d::Zero(), small);
  for (int i = 0; i < kSteps; ++i) sum = (F * sum * F.transpose() + each).eval();
  const auto Q = PoseFilter::process_noise(p, 0.1);
  for (int i = 0; i < 12; ++i) CHECK(Q(i, i) == Approx(sum(i, i)).epsilon(1e-3));
  CHECK(Q(0, 6) == Approx(sum(0, 6)).epsilon(1e-3));
  CHECK(Q(5, 11) == Approx(sum(5, 11)).epsilon(1e-3));
  // after long the velocity has its own spread
  CHECK(PoseFilter::process_noise(p, 100.0)(6, 6) == Approx(p.speed * p.speed));
}

TEST_CASE("pose filter: a turn through all yaws is followed without a jump") {
  PoseFilter filter(parameters());
  Quaterniond q = Quaterniond::Identity();
  for (int k = 1; k <= 400; ++k) {
    q = about(Vector3d(0, 0, 2.0 * kDt)) * q;
    if (k % 2 == 0) q.coeffs() = -q.coeffs();  // the same orientation
    const Estimate& estimate = filter.step(seen(k * kPeriod, {0.5, 0.001 * k, 0.02}, q));
    REQUIRE(estimate.measured);
    REQUIRE(estimate.q_WB.angularDistance(q) < 1e-2);
    if (k > 20) {
      // the memory of 0.2 s holds both back by less than a sixth
      CHECK(estimate.omega_WB.z() > 1.7);
      CHECK(estimate.omega_WB.z() < 2.05);
      CHECK(estimate.v_WB.y() == Approx(0.04).epsilon(0.15));
    }
  }
}

TEST_CASE("pose filter: its errors have its covariance, and are smaller than the measurement's") {
  // a body that moves as the filter believes, with correlated noise on what is measured
  const PoseFilterParameters p = parameters();
  c3rt::base::Random random(5);
  const auto normal = [&](int n) {
    Eigen::VectorXd x(n);
    for (int i = 0; i < n; ++i) x[i] = random.normal();
    return x;
  };
  Matrix6 of = covariance(3e-3, 3e-2);
  of(0, 5) = of(5, 0) = 0.5 * 3e-3 * 3e-2;
  const Matrix6 root = of.llt().matrixL();
  const Eigen::MatrixXd noise_root =
      Eigen::LLT<Eigen::MatrixXd>(PoseFilter::process_noise(p, kDt)).matrixL();
  State truth{{0.5, 0, 0}, Vector3d::Zero(), Vector3d::Zero(), Quaterniond::Identity()};
  PoseFilter filter(p);
  double sum = 0.0, squares = 0.0, of_measurement = 0.0;
  int count = 0;
  for (int k = 1; k <= 4000; ++k) {
    truth = moved(gone_on(truth, kDt, p.memory), noise_root * normal(12));
    const Vector6 error = root * normal(6);
    Measurement measurement =
        seen(k * kPeriod, truth.p + error.head<3>(), about(error.tail<3>()) * truth.q, of);
    const Estimate& e = filter.step(measurement);
    if (k < 50) continue;
    const Vector12 off = difference(truth, {e.p_WB, e.v_WB, e.omega_WB, e.q_WB});
    sum += off.dot(c3rt::support::solve_definite(filter.covariance(), off).col(0));
    squares += off.head<3>().squaredNorm();
    of_measurement += error.head<3>().squaredNorm();
    ++count;
  }
  // mean 12 of a chi-squared with 12 degrees of freedom; consecutive errors are alike
  CHECK(sum / count == Approx(12.0).epsilon(0.1));
  CHECK(squares < 0.8 * of_measurement);
}

TEST_CASE("pose filter: a wild pose is left out, a body that was moved is taken up anew") {
  PoseFilter filter(parameters());
  const Quaterniond q = Quaterniond::Identity();
  std::int64_t t = 0;
  for (int k = 0; k < 40; ++k) filter.step(seen(t += kPeriod, {0.5, 0, 0}, q));
  const Estimate before = filter.estimate();
  CHECK_FALSE(filter.step(seen(t += kPeriod, {0.6, 0, 0}, q)).measured);
  CHECK(filter.estimate().valid);
  CHECK((filter.estimate().p_WB - before.p_WB).norm() < 1e-4);
  // turned, not moved
  CHECK_FALSE(filter.step(seen(t += kPeriod, {0.5, 0, 0}, about({0.5, 0, 0}))).measured);
  CHECK(filter.step(seen(t += kPeriod, {0.5, 0, 0}, q)).measured);
  for (int k = 0; k < 3; ++k)
    CHECK_FALSE(filter.step(seen(t += kPeriod, {0.6, 0, 0}, q)).restarted);
  CHECK(filter.step(seen(t += kPeriod, {0.6, 0, 0}, q)).restarted);
  CHECK(filter.estimate().p_WB.x() == 0.6);
}

TEST_CASE("pose filter: an unseen body slows down, stays valid for a while, then is lost") {
  PoseFilter filter(parameters());
  const Quaterniond q = Quaterniond::Identity();
  std::int64_t t = 0;
  for (int k = 0; k < 40; ++k) filter.step(seen(t += kPeriod, {0.002 * k, 0, 0}, q));
  const Estimate last = filter.estimate();
  double spread = filter.covariance()(0, 0);
  for (int k = 1; k <= 20; ++k) {
    const Isometry3d expected = filter.predict(t + kPeriod);
    const Estimate& estimate = filter.step({t += kPeriod, false});
    CHECK(estimate.valid);
    CHECK((estimate.p_WB - expected.translation()).norm() < 1e-12);
    CHECK(filter.covariance()(0, 0) > spread);
    spread = filter.covariance()(0, 0);
  }
  // v τ (1 − e^(−t/τ))
  CHECK(filter.estimate().p_WB.x() - last.p_WB.x() ==
        Approx(last.v_WB.x() * 0.2 * (1.0 - std::exp(-0.5 / 0.2))));
  CHECK_FALSE(filter.step({t += kPeriod, false}).valid);
  CHECK(filter.step(seen(t += kPeriod, {0.3, 0, 0}, q)).restarted);
  CHECK(filter.estimate().valid);
}

TEST_CASE("pose filter: what is no pose, or old, changes nothing") {
  PoseFilter filter(parameters());
  const Quaterniond q = Quaterniond::Identity();
  Measurement without = seen(kPeriod, {0, 0, 0}, q);
  without.covariance.reset();
  CHECK_FALSE(filter.step(without).seen);
  filter.step(seen(2 * kPeriod, {0, 0, 0}, q));
  Measurement broken = seen(3 * kPeriod, {0, 0, 0}, q);
  broken.p_WB.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(filter.step(broken).measured);
  CHECK(filter.estimate().p_WB.allFinite());
  CHECK(filter.step(seen(kPeriod, {1, 0, 0}, q)).p_WB.norm() < 1e-12);
  PoseFilterParameters bad = parameters();
  bad.memory = 0.0;
  CHECK_THROWS(PoseFilter(bad));
}

TEST_CASE("pose filter: step and predict do not allocate") {
  PoseFilter filter(parameters());
  std::int64_t heap_calls = 0;
  double sum = 0.0;
  {
    const c3rt::support::AllocationCounter heap;
    for (int k = 1; k <= 200; ++k) {
      Measurement measurement = seen(k * kPeriod, {0.001 * k, 0, 0}, Quaterniond::Identity());
      measurement.found = k % 7 != 0;
      sum += filter.predict(k * kPeriod).translation().x() + filter.step(measurement).p_WB.x();
    }
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
  CHECK(std::isfinite(sum));
}
