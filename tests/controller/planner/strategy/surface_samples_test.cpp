#include "controller/planner/strategy/surface_samples.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kTip = 0.0195;
const Vector3d kHalf{0.05, 0.04, 0.03};

scene::Scene scene_of(double yaw) {
  scene::Scene scene;
  scene.effector.radius = kTip;
  scene.body_count = 1;
  scene::Body& body = scene.body(0);
  body.shape = scene::Shape::box(kHalf);
  body.p_WB = {0.5, 0.02, 0.03};
  body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return scene;
}

SampleRules rules() { return {0.03, 0.01, 2e-3, 0.09, {Vector2d(0.3, -0.3), Vector2d(0.8, 0.3)}}; }

}  // namespace

TEST_CASE("samples: each lies at its height, at the clearance of the surface, all the way round") {
  base::Random random(1);
  for (const double yaw : {0.0, 0.4, 2.0}) {
    const scene::Scene scene = scene_of(yaw);
    std::array<int, 4> faces{};
    int corners = 0;
    for (int i = 0; i < 400; ++i) {
      const auto place = surface_sample(scene, 0, rules(), random);
      REQUIRE(place);
      CHECK(place->z() == 0.03);
      scene::Effector effector = scene.effector;
      effector.p_WE = *place;
      CHECK(scene::gap(effector, scene.body(0)).distance == Approx(0.01).margin(1e-3));
      const Eigen::Quaterniond q_WB = scene.body(0).q_WB;
      const Vector3d at = q_WB.conjugate() * (*place - scene.body(0).p_WB);
      const bool beside_x = std::abs(at.x()) > kHalf.x(), beside_y = std::abs(at.y()) > kHalf.y();
      if (beside_x && beside_y) {
        ++corners;
      } else {
        ++faces[static_cast<std::size_t>((beside_x ? 0 : 2) + ((beside_x ? at.x() : at.y()) > 0))];
      }
    }
    for (const int count : faces) CHECK(count > 50);
    CHECK(corners < 100);
  }
}

TEST_CASE("samples: a seed decides them") {
  base::Random one(5), two(5), other(6);
  const scene::Scene scene = scene_of(0.2);
  const auto a = surface_sample(scene, 0, rules(), one), b = surface_sample(scene, 0, rules(), two),
             c = surface_sample(scene, 0, rules(), other);
  CHECK(*a == *b);
  CHECK(*a != *c);
}

TEST_CASE("samples: none out of reach, and none that the end effector cannot come down to") {
  base::Random random(2);
  scene::Scene scene = scene_of(0.0);
  SampleRules near = rules();
  near.reach = {Vector2d(0.3, -0.3), Vector2d(0.5, 0.3)};
  for (int i = 0; i < 100; ++i) {
    const auto place = surface_sample(scene, 0, near, random);
    REQUIRE(place);
    CHECK(place->x() <= 0.5);
  }
  // another body to one side, with no room between
  scene.body_count = 2;
  scene.body(1) = scene.body(0);
  scene.body(1).p_WB.x() += 0.12;
  for (int i = 0; i < 100; ++i) {
    const auto place = surface_sample(scene, 0, rules(), random);
    REQUIRE(place);
    scene::Effector effector = scene.effector;
    effector.p_WE = *place;
    CHECK(scene::gap(effector, scene.body(1)).distance > 1.9e-3);
  }
  near.reach = rules().reach;
  near.reach_radius = 0.5;
  for (int i = 0; i < 50; ++i) {
    const auto place = surface_sample(scene, 0, near, random);
    REQUIRE(place);
    CHECK(place->head<2>().norm() <= 0.5);
  }
  near.reach = {Vector2d(0.3, -0.3), Vector2d(0.31, -0.2)};
  CHECK_FALSE(surface_sample(scene, 0, near, random));
}

TEST_CASE("samples: the way down is free or not, and the top of what stands there is known") {
  const scene::Scene scene = scene_of(0.3);
  CHECK(top_of(scene) == Approx(0.06).margin(1e-9));
  CHECK(extent(scene_of(0.0).body(0), Vector3d::UnitX()) == Approx(0.05).margin(3e-3));
  CHECK_FALSE(column_is_free(scene, rules(), {0.5, 0.02, 0.03}));
  CHECK(column_is_free(scene, rules(), {0.65, 0.02, 0.03}));
}
