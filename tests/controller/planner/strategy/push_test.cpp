#include "controller/planner/strategy/push.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector2d;

namespace {

const Eigen::Vector3d kHalf{0.05, 0.04, 0.03};
constexpr double kTip = 0.0195, kGap = 0.012, kHeight = 0.03;

scene::Body box(double yaw) {
  scene::Body body;
  body.shape = scene::Shape::box(kHalf);
  body.p_WB = {0.5, 0.02, 0.03};
  body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return body;
}

PushParameters parameters() {
  PushParameters p{};
  p.height = kHeight;
  p.gap = kGap;
  p.look_ahead = 0.1;
  return p;
}

}  // namespace

TEST_CASE("push: it begins behind the body as seen from the goal, off its surface by the gap") {
  for (const double yaw : {0.0, 0.3, 1.0, 2.5, -1.2}) {
    for (double heading = -3.0; heading < 3.2; heading += 0.4) {
      CAPTURE(yaw, heading);
      const scene::Body body = box(yaw);
      const Vector2d way(std::cos(heading), std::sin(heading));
      const Vector2d goal = body.p_WB.head<2>() + 0.1 * way;
      const Eigen::Vector3d start = behind(body, goal, parameters(), kTip, kHeight);
      scene::Effector effector;
      effector.radius = kTip;
      effector.p_WE = start;
      CHECK(scene::gap(effector, body).distance == Approx(kGap));
      CHECK(start.z() == kHeight);
      const Vector2d to_body = (body.p_WB - start).head<2>();
      CHECK(way.dot(to_body) > 0.85 * to_body.norm());
    }
  }
}

TEST_CASE("push: straight behind a face it begins before the middle of that face") {
  const scene::Body body = box(0.0);
  const Eigen::Vector3d start =
      behind(body, body.p_WB.head<2>() + Vector2d(0.1, 0.0), parameters(), kTip, kHeight);
  CHECK((start - Eigen::Vector3d(0.5 - 0.05 - kTip - kGap, 0.02, kHeight)).norm() < 1e-12);
}

TEST_CASE("push: errors weigh more as the goal comes near, and no more than thirty times") {
  CHECK(near_goal_gain(0.3, 0.0) == 1.0);
  CHECK(near_goal_gain(0.1, 0.0) == Approx(1.0));
  CHECK(near_goal_gain(0.05, 0.0) == Approx(4.0));
  CHECK(near_goal_gain(0.0, 0.0) == 30.0);
  CHECK(near_goal_gain(0.0, 0.3) < near_goal_gain(0.0, 0.2));
  CHECK(near_goal_gain(0.02, 1.0) == 1.0);
}
