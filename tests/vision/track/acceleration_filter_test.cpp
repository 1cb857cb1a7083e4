#include "vision/track/acceleration_filter.hpp"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::vision;

namespace {

constexpr double kPeriod = 1.0 / 80.0;
const AccelerationFilterParameters kParameters{0.0005, 5.0, 0.3, 0.003, 0.05};
const Eigen::Vector2d kSlope(0.1, -0.06);  // of a table tilted by a degree [m/s²]

/// A ball that rolls freely and is thrown anew once a second, seen at 80 Hz; in the last 0.4 s of
/// each second the end effector holds it.
class Course {
 public:
  explicit Course(double noise) : noise_(noise) {}
  void run(AccelerationFilter& filter, double seconds, const Eigen::Vector2d& slope) {
    for (const double end = time_ + seconds; time_ < end; time_ += kPeriod) {
      const double in_second = std::fmod(time_, 1.0);
      const bool held = in_second > 0.6;
      if (in_second < kPeriod) v_ = Eigen::Vector2d(0.05, 0.03) * normal();
      // what a hand does to the ball has nothing to do with the table
      const Eigen::Vector2d a = held ? Eigen::Vector2d(-0.8, 0.5) : slope;
      p_ += kPeriod * v_ + 0.5 * kPeriod * kPeriod * a;
      v_ += kPeriod * a;
      const Eigen::Vector2d seen = p_ + noise_ * Eigen::Vector2d(normal(), normal());
      filter.observe(time_, seen, held || in_second < 2.0 * kPeriod);
    }
  }

 private:
  // of variance 1, nearly Gaussian: the sum of twelve uniform numbers
  double normal() { return random_.vector(12).sum() / 2.0; }

  support::Random random_{7};
  double noise_, time_ = 0.0;
  Eigen::Vector2d p_{0.55, 0.1}, v_{0.0, 0.0};
};

TEST_CASE("before anything was seen the ball's acceleration is nothing") {
  CHECK(AccelerationFilter(kParameters).acceleration().isZero(0.0));
}

TEST_CASE("a slope is found within one stretch of free rolling where there is no noise") {
  AccelerationFilter filter(kParameters);
  for (double t = 0.0; t < 0.5; t += kPeriod) {
    const Eigen::Vector2d p = 0.07 * t * Eigen::Vector2d::UnitY() + 0.5 * t * t * kSlope;
    filter.observe(t, p, false);
  }
  CHECK((filter.acceleration() - kSlope).norm() < 0.1 * kSlope.norm());
}

TEST_CASE("a slope is found within ten seconds through noise and whatever a contact does") {
  AccelerationFilter filter(kParameters);
  Course course(0.0003);
  course.run(filter, 10.0, kSlope);
  CHECK((filter.acceleration() - kSlope).norm() < 0.1 * kSlope.norm());
}

TEST_CASE("a level table stays level through noise and whatever a contact does") {
  AccelerationFilter filter(kParameters);
  Course course(0.0003);
  course.run(filter, 10.0, Eigen::Vector2d::Zero());
  CHECK(filter.acceleration().norm() < 0.01);
}

TEST_CASE("a table that is tilted another way is followed within three memories") {
  AccelerationFilter filter(kParameters);
  Course course(0.0003);
  course.run(filter, 20.0, kSlope);
  course.run(filter, 3.0 * kParameters.memory / 0.6, -kSlope);  // 0.6 of it rolls freely
  CHECK((filter.acceleration() + kSlope).norm() < 0.2 * kSlope.norm());
}

TEST_CASE("a hand's push between two positions is no slope") {
  AccelerationFilter filter(kParameters);
  Course course(0.0003);
  course.run(filter, 10.0, kSlope);
  const Eigen::Vector2d before = filter.acceleration();
  for (int i = 0; i < 40; ++i) {  // at 10 s the ball is thrown off at 1 m/s
    const double t = 20.0 + i * kPeriod;
    const double since_push = std::max(0.0, t - 20.2);
    const Eigen::Vector2d p =
        0.5 * (t - 20.0) * (t - 20.0) * kSlope + since_push * Eigen::Vector2d::UnitX();
    filter.observe(t, p, i == 0);
  }
  CHECK((filter.acceleration() - before).norm() < 0.2 * kSlope.norm());
}

TEST_CASE("the acceleration is never longer than its limit, and then has the right direction") {
  AccelerationFilter filter(kParameters);
  const Eigen::Vector2d steep(1.2, 1.6);
  for (int i = 0; i < 80; ++i) {
    const double t = i * kPeriod;
    filter.observe(t, 0.5 * t * t * steep, false);
    REQUIRE(filter.acceleration().norm() <= kParameters.limit * (1.0 + 1e-12));
  }
  CHECK((filter.acceleration() - kParameters.limit * steep.normalized()).norm() < 0.02);
}

TEST_CASE("what is not finite, old or long ago leaves the acceleration as it is") {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  AccelerationFilter filter(kParameters), undisturbed(kParameters);
  Course course(0.0003), same(0.0003);
  course.run(filter, 10.0, kSlope);
  same.run(undisturbed, 10.0, kSlope);
  filter.observe(10.5, {kNaN, 0.0}, false);
  filter.observe(10.5, {0.0, kInfinite}, false);
  filter.observe(kNaN, {0.0, 0.0}, false);
  filter.observe(3.0, {0.0, 0.0}, false);
  CHECK(filter.acceleration() == undisturbed.acceleration());
  filter.observe(1000.0, {5.0, 5.0}, false);  // nothing was seen in between
  CHECK(filter.acceleration() == undisturbed.acceleration());
  course.run(filter, 1.0, kSlope);
  CHECK(filter.acceleration().allFinite());
}

TEST_CASE("observing does not allocate") {
  AccelerationFilter filter(kParameters);
  const support::AllocationCounter heap;
  for (int i = 0; i < 100; ++i) filter.observe(i * kPeriod, {0.5 + 0.001 * i, 0.1}, i % 20 == 0);
  const auto calls = heap.count();
  CHECK(calls == 0);
}

}  // namespace
