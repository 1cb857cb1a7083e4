#include "vision/emulated.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

using namespace c3rt::vision;

TEST_CASE("emulated: noise has the wanted spread on x and y, none on z, and no bias") {
  constexpr int kSamples = 20000;
  const double sigma = 0.001;
  EmulatedSensor sensor({sigma, 0.01}, 7);
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
  EmulatedSensor a({0.001, 0.01}, 3), b({0.001, 0.01}, 3), c({0.001, 0.01}, 4);
  bool different = false;
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d p_a = a.measure({0.5, 0, 0});
    REQUIRE(p_a == b.measure({0.5, 0, 0}));
    different = different || p_a != c.measure({0.5, 0, 0});
  }
  REQUIRE(different);
}

TEST_CASE("emulated: noise is clipped, and without noise the truth passes through") {
  EmulatedSensor wide({0.05, 0.01}, 1), quiet({0.0, 0.01}, 1);
  double largest = 0.0;
  for (int k = 0; k < 1000; ++k) {
    largest = std::max(largest, wide.measure(Eigen::Vector3d::Zero()).cwiseAbs().maxCoeff());
    REQUIRE(quiet.measure({0.5, 0.1, 0.03}) == Eigen::Vector3d(0.5, 0.1, 0.03));
  }
  REQUIRE(largest == 0.01);
}

TEST_CASE("emulated: an orientation is turned about z, with the wanted spread") {
  constexpr int kSamples = 20000;
  EmulatedParameters parameters{0.001, 0.01};
  parameters.angle_noise = 0.02;
  EmulatedSensor sensor(parameters, 7);
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
