#include "controller/scene/scene.hpp"

#include <catch2/catch.hpp>

using namespace c3rt;
using Eigen::Vector3d;

namespace {

constexpr double kRadius = 0.0315, kEndEffectorRadius = 0.0195;

/// A sphere on the table, and an end effector that touches nothing.
scene::Scene resting() {
  scene::Scene scene;
  scene.body_count = 1;
  scene.body(0).shape = scene::Shape::sphere(kRadius);
  scene.body(0).p_WB = Vector3d(0.5, 0.1, kRadius);
  scene.effector.radius = kEndEffectorRadius;
  scene.effector.p_WE = Vector3d(0.5, 0.1, 0.2);
  return scene;
}

}  // namespace

TEST_CASE("scene: separate moves an overlapping sphere sideways until they touch, and no other") {
  scene::Scene state = resting();
  state.effector.p_WE = state.body(0).p_WB + Vector3d(0.01, 0.0, 0.04);
  scene::separate(state.effector, Vector3d::UnitX(), state.body(0));
  CHECK((state.effector.p_WE - state.body(0).p_WB).norm() == Approx(kRadius + kEndEffectorRadius));
  CHECK(state.body(0).p_WB.z() == kRadius);
  CHECK(state.body(0).p_WB.x() < 0.5);
  CHECK(state.body(0).p_WB.y() == Approx(0.1));

  state = resting();
  state.effector.p_WE = state.body(0).p_WB + Vector3d(0.0, 0.0, 0.04);
  scene::separate(state.effector, Vector3d::UnitY(), state.body(0));
  CHECK(state.body(0).p_WB.y() > 0.1);

  state = resting();
  const Vector3d before = state.body(0).p_WB;
  scene::separate(state.effector, Vector3d::UnitX(), state.body(0));
  CHECK(state.body(0).p_WB == before);
}
