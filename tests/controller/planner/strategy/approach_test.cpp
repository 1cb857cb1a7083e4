#include "controller/planner/strategy/approach.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace c3rt::planner;
using Catch::Detail::Approx;
using Eigen::Vector3d;

namespace {

constexpr double kTable = -0.0245, kPeriod = 0.005;
const Vector3d kBall(0.55, 0.1, 0.007);
const Vector3d kBegin(0.55, -0.1, 0.04);

ApproachParameters parameters() {
  ApproachParameters p{};
  p.speed = 0.1;
  p.safe_height = 0.13;
  p.start_height = 0.063;
  p.tolerance = 0.003;
  p.leash = 0.02;
  p.settle_time = 0.3;
  return p;
}

/// An arm that is where the reference is, one period later.
struct Follower {
  Approach approach{parameters(), kTable};
  Vector3d p_WE = kBegin;
  double now = 0.0;

  Follower() { approach.begin(p_WE); }
  void to_body(const Vector3d& p_WB) {
    approach.to_body({now += kPeriod, kPeriod, p_WE}, p_WB);
    p_WE = approach.reference();
  }
};

}  // namespace

TEST_CASE("approach: it goes up, across and down, and nothing moves sideways below safe height") {
  Follower follower;
  const double safe = kTable + parameters().safe_height;
  double highest = 0.0;
  Vector3d previous = follower.p_WE;
  while (!follower.approach.settled(follower.now)) {
    follower.to_body(kBall);
    REQUIRE(follower.now < 10.0);
    const Vector3d moved = follower.p_WE - previous;
    CHECK(moved.norm() <= parameters().speed * kPeriod + 1e-12);
    if (previous.z() < safe - 2.0 * parameters().tolerance) {
      CHECK(moved.head<2>().norm() <= parameters().tolerance);
    }
    previous = follower.p_WE;
    highest = std::max(highest, previous.z());
  }
  CHECK(highest == Approx(safe).margin(parameters().tolerance));
  CHECK((previous - kBall - Vector3d(0.0, 0.0, parameters().start_height)).norm() <
        parameters().tolerance);
}

TEST_CASE("approach: it is settled once it has been above the ball for the settling time") {
  Follower follower;
  const Vector3d start = kBall + Vector3d(0.0, 0.0, parameters().start_height);
  follower.approach.begin(start);
  follower.p_WE = start;
  CHECK_FALSE(follower.approach.settled(1e9));
  follower.to_body(kBall);
  const double since = follower.now;
  CHECK_FALSE(follower.approach.settled(since + 0.29));
  CHECK(follower.approach.settled(since + 0.31));
  follower.to_body(kBall + Vector3d(0.01, 0.0, 0.0));
  CHECK_FALSE(follower.approach.settled(since + 0.31));
}

TEST_CASE("approach: it is gentle and ends, also with an estimate that jumps every time") {
  Follower follower;
  Vector3d velocity = Vector3d::Zero();
  for (int i = 0; !follower.approach.settled(follower.now); ++i) {
    REQUIRE(follower.now < 6.0);
    const Vector3d noise(std::sin(12.9898 * i), std::sin(78.233 * i), 0.0);
    follower.to_body(kBall + 0.002 * noise);
    // twice 1 m/s² over one period
    CHECK((follower.approach.velocity() - velocity).norm() <= 2.0 * kPeriod + 1e-9);
    velocity = follower.approach.velocity();
  }
}

TEST_CASE("approach: it waits for an arm that does not follow, and goes on when it does") {
  const ApproachParameters p = parameters();
  Approach approach(p, kTable);
  approach.begin(kBegin);
  double now = 0.0;
  for (int i = 0; i < 500; ++i) approach.to_body({now += kPeriod, kPeriod, kBegin}, kBall);
  const Vector3d waiting = approach.reference();
  CHECK((waiting - kBegin).norm() == Approx(p.leash).margin(p.speed * kPeriod));
  CHECK(approach.velocity().norm() <= 2.0 * kPeriod);  // of one period
  for (int i = 0; i < 2; ++i) approach.to_body({now += kPeriod, kPeriod, waiting}, kBall);
  CHECK(approach.reference().z() > waiting.z());
}

TEST_CASE("approach: it comes to an arm that is kept back, and takes it to the ball") {
  // the arm stands at the border of its workspace, the reference is beyond: both would wait for
  // ever
  Approach approach(parameters(), kTable);
  const double border = 0.65;
  approach.begin({0.70, 0.1, 0.12});
  Vector3d p_WE(border, 0.1, 0.12);
  double now = 0.0;
  for (int i = 0; i < 2000; ++i) {
    approach.to_body({now += kPeriod, kPeriod, p_WE}, kBall);
    p_WE = approach.reference();
    p_WE.x() = std::min(p_WE.x(), border);
  }
  CHECK((p_WE - kBall - Vector3d(0.0, 0.0, parameters().start_height)).norm() <
        parameters().tolerance);
  CHECK(approach.settled(now));
}

TEST_CASE(
    "approach: while the robot does not follow it rests where the arm is, wherever that is moved") {
  Approach approach(parameters(), kTable);
  approach.begin(kBegin);
  double now = 0.0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d moved = kBegin + Vector3d(0.0, 0.0002 * i, 0.0);
    approach.to_body({now += kPeriod, kPeriod, moved, false}, kBall);
    REQUIRE(approach.reference() == moved);
    REQUIRE(approach.velocity().isZero());
  }
  // not even above the ball does it settle
  const Vector3d start = kBall + Vector3d(0.0, 0.0, parameters().start_height);
  for (int i = 0; i < 200; ++i) approach.to_body({now += kPeriod, kPeriod, start, false}, kBall);
  CHECK_FALSE(approach.settled(now));
}

TEST_CASE("approach: out of the way is straight up to safe height, never down") {
  const double safe = kTable + parameters().safe_height;
  for (const double height : {0.04, 0.2}) {
    Approach approach(parameters(), kTable);
    const Vector3d begin(0.5, 0.05, height);
    approach.begin(begin);
    for (int i = 0; i < 500; ++i)
      approach.out_of_the_way({i * kPeriod, kPeriod, approach.reference()});
    CHECK(approach.reference().head<2>() == begin.head<2>());
    CHECK(approach.reference().z() == Approx(std::max(height, safe)));
    CHECK(approach.velocity().isZero());
  }
}
