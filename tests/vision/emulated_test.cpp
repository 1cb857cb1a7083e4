#include "vision/emulated.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

using namespace c3rt::vision;

namespace {

constexpr std::int64_t kPeriod_ns = 12'500'000;

const Eigen::Quaterniond kLevel = Eigen::Quaterniond::Identity();

/// What a sensor says of the only body at its next exposure, where it stands still.
class Camera {
 public:
  Camera(const EmulatedParameters& parameters, std::uint64_t seed) : sensor_(parameters, seed) {}
  BodyPose measure(const BodyPose& truth, bool turned) {
    time_ns_ += kPeriod_ns;
    sensor_.see(time_ns_, {truth});
    return sensor_.measure(0, time_ns_, turned);
  }
  Eigen::Vector3d measure(const Eigen::Vector3d& p_WB) {
    return measure({p_WB, kLevel}, false).p_WB;
  }
  Eigen::Quaterniond measure(const Eigen::Quaterniond& q_WB) {
    return measure({Eigen::Vector3d::Zero(), q_WB}, true).q_WB;
  }

 private:
  EmulatedSensor sensor_;
  std::int64_t time_ns_ = 0;
};

}  // namespace

TEST_CASE("emulated: noise has the wanted spread on x and y, none on z, and no bias") {
  constexpr int kSamples = 20000;
  const double sigma = 0.001;
  Camera sensor({sigma, 0.01}, 7);
  const Eigen::Vector3d truth(0.55, 0.1, 0.0315);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
  double product = 0.0;
  int within_one_sigma = 0;
  for (int k = 0; k < kSamples; ++k) {
    const Eigen::Vector3d e = sensor.measure(truth) - truth;
    sum += e;
    squares += e.cwiseProduct(e);
    product += e.x() * e.y();
    within_one_sigma += std::abs(e.x()) < sigma ? 1 : 0;
  }
  REQUIRE(sum.z() == 0.0);
  for (int axis = 0; axis < 2; ++axis) {
    // four standard errors: sigma / sqrt(n) of the mean, sigma / sqrt(2 n) of the deviation
    REQUIRE(std::abs(sum[axis] / kSamples) < 4 * sigma / std::sqrt(kSamples));
    REQUIRE(std::sqrt(squares[axis] / kSamples) ==
            Approx(sigma).margin(4 * sigma / std::sqrt(2.0 * kSamples)));
  }
  REQUIRE(std::abs(product / kSamples) < 4 * sigma * sigma / std::sqrt(kSamples));
  REQUIRE(within_one_sigma / double(kSamples) == Approx(0.6827).margin(0.014));
}

TEST_CASE("emulated: the same seed gives the same bits, another seed others") {
  Camera a({0.001, 0.01}, 3), b({0.001, 0.01}, 3), c({0.001, 0.01}, 4);
  bool different = false;
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d p_a = a.measure(Eigen::Vector3d(0.5, 0, 0));
    REQUIRE(p_a == b.measure(Eigen::Vector3d(0.5, 0, 0)));
    different = different || p_a != c.measure(Eigen::Vector3d(0.5, 0, 0));
  }
  REQUIRE(different);
}

TEST_CASE("emulated: noise is clipped, and without noise the truth passes through") {
  Camera wide({0.05, 0.01}, 1), quiet({0.0, 0.01}, 1);
  double largest = 0.0;
  for (int k = 0; k < 1000; ++k) {
    largest = std::max(largest, wide.measure(Eigen::Vector3d::Zero().eval()).cwiseAbs().maxCoeff());
    REQUIRE(quiet.measure(Eigen::Vector3d(0.5, 0.1, 0.03)) == Eigen::Vector3d(0.5, 0.1, 0.03));
  }
  REQUIRE(largest == 0.01);
}

TEST_CASE("emulated: an orientation is turned about z, with the wanted spread") {
  constexpr int kSamples = 20000;
  EmulatedParameters parameters{0.001, 0.01};
  parameters.angle_noise = 0.02;
  Camera sensor(parameters, 7);
  const Eigen::Quaterniond truth =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ())) *
      Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  double sum = 0.0, squares = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    const Eigen::AngleAxisd turn(sensor.measure(truth) * truth.conjugate());
    const double angle = turn.angle() * turn.axis().z();
    REQUIRE(turn.axis().head<2>().norm() < 1e-6);
    sum += angle;
    squares += angle * angle;
  }
  // four standard errors
  CHECK(std::abs(sum / kSamples) < 4 * 0.02 / std::sqrt(kSamples));
  CHECK(std::sqrt(squares / kSamples) == Approx(0.02).margin(4 * 0.02 / std::sqrt(2.0 * kSamples)));
}

TEST_CASE("emulated: a drifting error has the wanted spread and forgets itself as it should") {
  constexpr int kSamples = 200000;
  EmulatedParameters parameters{0.0, 0.01};
  parameters.drift = 0.002;
  parameters.angle_drift = 0.03;
  parameters.drift_time = 0.1;
  Camera sensor(parameters, 7);
  constexpr int kLag = 8;  // 0.1 s
  std::vector<double> x, angle;
  for (int k = 0; k < kSamples; ++k) {
    const BodyPose pose = sensor.measure({{0.5, 0.1, 0.03}, kLevel}, true);
    REQUIRE(pose.p_WB.z() == 0.03);
    x.push_back(pose.p_WB.x() - 0.5);
    angle.push_back(2.0 * std::atan2(pose.q_WB.z(), pose.q_WB.w()));
  }
  for (const auto& [errors, sigma] : {std::pair(x, 0.002), std::pair(angle, 0.03)}) {
    double squares = 0.0, products = 0.0;
    for (std::size_t k = kLag; k < errors.size(); ++k) {
      squares += errors[k] * errors[k];
      products += errors[k] * errors[k - kLag];
    }
    // about kSamples / 16 independent values
    CHECK(std::sqrt(squares / kSamples) == Approx(sigma).epsilon(0.03));
    CHECK(products / squares == Approx(std::exp(-1.0)).margin(0.03));
  }
}

TEST_CASE("emulated: drift is another one for each body, and leaves the white noise as it was") {
  EmulatedParameters parameters{0.001, 0.01};
  EmulatedSensor still(parameters, 3);
  parameters.drift = 1e-9;  // below what is compared
  EmulatedSensor drifting(parameters, 3);
  parameters = {0.0, 0.01};
  parameters.drift = 0.002;
  EmulatedSensor alone(parameters, 3);
  const std::vector<BodyPose> truth(2);
  for (int k = 1; k <= 20; ++k) {
    for (EmulatedSensor* sensor : {&still, &drifting, &alone}) sensor->see(k * kPeriod_ns, truth);
    for (std::size_t body = 0; body < 2; ++body) {
      const Eigen::Vector3d a = still.measure(body, k * kPeriod_ns, false).p_WB;
      const Eigen::Vector3d b = drifting.measure(body, k * kPeriod_ns, false).p_WB;
      CHECK((a - b).norm() < 1e-7);
    }
    CHECK((alone.measure(0, k * kPeriod_ns, false).p_WB -
           alone.measure(1, k * kPeriod_ns, false).p_WB)
              .norm() > 1e-6);
  }
}

TEST_CASE("emulated: a delayed pose is where the body was, whatever instants were seen") {
  EmulatedParameters parameters{0.0, 0.01};
  parameters.delay = 0.05;
  EmulatedSensor sensor(parameters, 1);
  // 0.2 m/s along x, 1 rad/s about z; instants 4 to 7 ms apart, of which every other is an exposure
  const auto truth = [](double t) {
    return BodyPose{{0.2 * t, 0.0, 0.03},
                    Eigen::Quaterniond(Eigen::AngleAxisd(t, Eigen::Vector3d::UnitZ()))};
  };
  std::int64_t time_ns = 0;
  for (int k = 0; k < 100; ++k) {
    time_ns += 4'000'000 + (k % 4) * 1'000'000;
    sensor.see(time_ns, {truth(1e-9 * static_cast<double>(time_ns))});
    if (k % 2 == 0) continue;
    const BodyPose measured = sensor.measure(0, time_ns, true);
    const double then = std::max(0.004, 1e-9 * static_cast<double>(time_ns) - 0.05);
    CHECK((measured.p_WB - truth(then).p_WB).norm() < 1e-12);
    CHECK(measured.q_WB.angularDistance(truth(then).q_WB) < 1e-9);
  }
}

TEST_CASE("emulated: an exposure that is measured after later instants were seen is its own") {
  EmulatedSensor sensor({0.0, 0.01}, 1);
  sensor.see(1'000'000, {{{0.1, 0.0, 0.0}, kLevel}});
  sensor.see(3'000'000, {{{0.3, 0.0, 0.0}, kLevel}});
  CHECK(sensor.measure(0, 1'000'000, false).p_WB.x() == 0.1);
}
