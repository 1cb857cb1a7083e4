#include "controller/planner/strategy/free_motion.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;

namespace {

constexpr double kTip = 0.0195, kSafe = 0.095, kClear = 0.006, kPeriod = 0.02;
const FreeMotionParameters kParameters{0.3, 2.0, kClear, 0.02};

scene::Scene scene_of_box() {
  scene::Scene scene;
  scene.effector.radius = kTip;
  scene.body_count = 1;
  scene::Body& body = scene.body(0);
  body.shape = scene::Shape::box({0.05, 0.04, 0.03});
  body.p_WB = {0.5, 0.02, 0.03};
  body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()));
  return scene;
}

double gap_at(const scene::Scene& scene, const Vector3d& p_WE) {
  scene::Effector effector = scene.effector;
  effector.p_WE = p_WE;
  return scene::gap(effector, scene.body(0)).distance;
}

/// A place about the box at this gap.
Vector3d beside(const scene::Scene& scene, double angle, double gap) {
  Vector3d at = scene.body(0).p_WB + 0.2 * Vector3d(std::cos(angle), std::sin(angle), 0.0);
  for (int i = 0; i < 30; ++i) {
    const Vector3d in = (scene.body(0).p_WB - at).normalized();
    at += (gap_at(scene, at) - gap) * in;
  }
  return at;
}

}  // namespace

TEST_CASE("free motion: from any side of a body to any other, clear of it, without jumps") {
  const scene::Scene scene = scene_of_box();
  for (double from = 0.0; from < 6.2; from += 0.7) {
    for (double to = 0.3; to < 6.2; to += 0.9) {
      CAPTURE(from, to);
      const Vector3d start = beside(scene, from, 0.0), goal = beside(scene, to, 0.01);
      FreeMotion way(kParameters);
      way.begin(start, Vector3d::Zero());
      Vector3d velocity = Vector3d::Zero(), at = start;
      double came_away = 0.0;
      int periods = 0;
      for (; periods < 500 && !way.there(); ++periods) {
        way.step({periods * kPeriod, kPeriod, at, true}, scene, goal, kSafe);
        const Vector3d moved = way.reference() - at;
        CHECK(moved.norm() <= 0.3 * kPeriod + 1e-9);
        // 2 of the acceleration as it turns; the last step of a way is one to rest
        if (!way.velocity().isZero(0.0))
          CHECK((way.velocity() - velocity).norm() <= 2.0 * 2.0 * kPeriod + 1e-9);
        velocity = way.velocity();
        at = way.reference();
        const double gap = gap_at(scene, at);
        came_away = std::max(came_away, gap);
        CHECK(gap > std::min(kClear, came_away) - 2e-3);
        CHECK(at.z() < kSafe + 0.01);
      }
      CHECK(way.there());
      CHECK((at - goal).norm() < 1e-9);
      CHECK(periods * kPeriod < 3.0);
    }
  }
}

TEST_CASE("free motion: straight where that is clear, else off the body, up, over and down") {
  const scene::Scene scene = scene_of_box();
  const Vector3d near = beside(scene, 3.0, 0.01), far = beside(scene, 3.0, 0.1);
  CHECK(next_corner(scene, near, far, kSafe, kClear) == far);
  CHECK(next_corner(scene, far, near, kSafe, kClear) == near);
  // touching, with the goal behind the body: off it, and level
  const Vector3d touching = beside(scene, 3.0, 0.0), behind = beside(scene, 0.0, 0.01);
  const Vector3d off = next_corner(scene, touching, behind, kSafe, kClear);
  CHECK(off.z() == touching.z());
  CHECK(gap_at(scene, off) > kClear);
  CHECK(next_corner(scene, off, behind, kSafe, kClear) == Vector3d(off.x(), off.y(), kSafe));
  const Vector3d up(off.x(), off.y(), kSafe);
  CHECK(next_corner(scene, up, behind, kSafe, kClear) == Vector3d(behind.x(), behind.y(), kSafe));
  CHECK(next_corner(scene, {behind.x(), behind.y(), kSafe}, behind, kSafe, kClear) == behind);
}

TEST_CASE("free motion: out of a slot whose two sides are nearer than it keeps clear of") {
  scene::Scene scene = scene_of_box();
  scene.body_count = 2;
  for (int i = 0; i < 2; ++i) {
    scene.body(i).shape = scene::Shape::box({0.05, 0.02, 0.03});
    scene.body(i).p_WB = {0.5, i == 0 ? 0.0425 : -0.0425, 0.03};  // 45 mm between them
    scene.body(i).q_WB = Eigen::Quaterniond::Identity();
  }
  for (const double beside : {0.0, 0.002, -0.0028}) {
    CAPTURE(beside);
    const Vector3d goal(0.5, 0.15, 0.03);
    FreeMotion way(kParameters);
    Vector3d at(0.5, beside, 0.03);
    way.begin(at, Vector3d::Zero());
    int periods = 0;
    for (; periods < 500 && !way.there(); ++periods) {
      way.step({periods * kPeriod, kPeriod, at, true}, scene, goal, kSafe);
      at = way.reference();
      CHECK(gap_at(scene, at) > 0.0);
    }
    CHECK(way.there());
    CHECK(periods * kPeriod < 4.0);
  }
}

TEST_CASE("free motion: it rests where an arm is that does not follow, and waits for a slow one") {
  const scene::Scene scene = scene_of_box();
  FreeMotion way(kParameters);
  const Vector3d arm(0.3, -0.2, 0.1), goal(0.7, -0.2, 0.1);
  way.begin(arm, Vector3d::Zero());
  way.step({0.0, kPeriod, arm, false}, scene, goal, kSafe);
  CHECK(way.reference() == arm);
  for (int i = 1; i < 100; ++i) way.step({i * kPeriod, kPeriod, arm, true}, scene, goal, kSafe);
  CHECK((way.reference() - arm).norm() < 0.02 + 0.3 * kPeriod);
  CHECK_FALSE(way.there());
}

TEST_CASE("free motion: a place that a body carries along is reached, and kept") {
  scene::Scene scene = scene_of_box();
  Vector3d goal = beside(scene, 2.0, 0.01), at = beside(scene, 0.5, 0.01);
  FreeMotion way(kParameters);
  way.begin(at, Vector3d::Zero());
  const Vector3d moved(0.05 * kPeriod, -0.02 * kPeriod, 0.0);
  int there = 0;
  for (int i = 0; i < 200; ++i) {
    scene.body(0).p_WB += moved;
    goal += moved;
    way.carry(moved);
    way.step({i * kPeriod, kPeriod, way.reference(), true}, scene, goal, kSafe);
    if (way.there()) {
      ++there;
      CHECK((way.reference() - goal).norm() < 1e-9);
    } else {
      CHECK(there == 0);
    }
  }
  CHECK(there > 100);
}

TEST_CASE("free motion: beside a body it stays on its height, clear of it, by a short way") {
  const scene::Scene scene = scene_of_box();
  FreeMotionParameters parameters = kParameters;
  parameters.over = false;
  for (const double period : {kPeriod, 0.1}) {
    for (double from = 0.0; from < 6.2; from += 0.7) {
      for (double to = 0.3; to < 6.2; to += 0.9) {
        CAPTURE(period, from, to);
        const Vector3d start = beside(scene, from, 0.0), goal = beside(scene, to, 0.01);
        FreeMotion way(parameters);
        way.begin(start, Vector3d::Zero());
        double came_away = 0.0, length = 0.0;
        Vector3d at = start;
        int periods = 0;
        for (; periods < 500 && !way.there(); ++periods) {
          way.step({periods * period, period, at, true}, scene, goal, kSafe);
          length += (way.reference() - at).norm();
          CHECK((way.reference() - at).norm() <= 0.3 * period + 1e-9);
          at = way.reference();
          came_away = std::max(came_away, gap_at(scene, at));
          CHECK(gap_at(scene, at) > std::min(kClear, came_away) - 2e-3);
          CHECK(at.z() == Approx(goal.z()));
          CHECK_FALSE(way.blocked());
        }
        CHECK(way.there());
        CHECK((at - goal).norm() < 1e-9);
        // half round the rounded box is 2 (0.05 + 0.04) + pi (radius + clear) at most
        CHECK(length < 2.0 * 0.09 + M_PI * (kTip + kClear) + 0.02);
        CHECK(periods * period < 2.0);
      }
    }
  }
}

TEST_CASE("free motion: beside a body it never leaves its reach, however fast it comes") {
  const scene::Scene scene = scene_of_box();
  FreeMotionParameters parameters = kParameters;
  parameters.over = false;
  parameters.reach = {Eigen::Vector2d(0.3, -0.13), Eigen::Vector2d(0.7, 0.13)};
  const Vector3d start(0.5, 0.128, 0.03), goal = beside(scene, 3.0, 0.01);
  FreeMotion way(parameters);
  way.begin(start, Vector3d(-0.1, 0.28, 0.0));
  Vector3d at = start;
  int periods = 0;
  for (; periods < 500 && !way.there(); ++periods) {
    way.step({periods * kPeriod, kPeriod, at, true}, scene, goal, kSafe);
    at = way.reference();
    CAPTURE(at.transpose());
    CHECK(parameters.reach.contains(at.head<2>()));
  }
  CHECK(way.there());
}

TEST_CASE("free motion: beside two bodies between them where there is room, else round both") {
  scene::Scene scene = scene_of_box();
  scene.body_count = 2;
  FreeMotionParameters parameters = kParameters;
  parameters.over = false;
  const Vector3d from(0.4, 0.0, 0.03), to(0.6, 0.0, 0.03);
  for (const double room : {0.06, 0.03}) {  // the end effector needs 0.051
    CAPTURE(room);
    for (int i = 0; i < 2; ++i) {
      scene.body(i).shape = scene::Shape::box({0.02, 0.05, 0.03});
      scene.body(i).p_WB = {0.5, (i == 0 ? 1.0 : -1.0) * (0.05 + 0.5 * room), 0.03};
      scene.body(i).q_WB = Eigen::Quaterniond::Identity();
    }
    const bool through = room > 0.051;
    const Leg leg = next_leg_beside(scene, from, to, parameters);
    CHECK(leg.left < (through ? 0.2001 : 0.4));
    CHECK(leg.left > (through ? 0.1999 : 0.3));
    // with no room beside them either there is no way, and it says so
    parameters.reach = {Eigen::Vector2d(0.3, -0.1), Eigen::Vector2d(0.7, 0.1)};
    FreeMotion way(parameters);
    way.begin(from, Vector3d::Zero());
    way.step({0.0, kPeriod, from, true}, scene, to, kSafe);
    CHECK(way.blocked() == !through);
    CHECK((way.reference() == from) == !through);
    parameters.reach = FreeMotionParameters{}.reach;
  }
}
