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

TEST_CASE("samples: a place is drawn the more often, the more a push from it does what is wanted") {
  // places beside the faces across x: how many from where a push goes along +x and along -x, and of
  // those near a face's end how many from where it turns the box to the left and to the right
  struct Counts {
    int forth = 0, back = 0, left = 0, right = 0;
  };
  const auto draw = [](const Vector3d& wanted) {
    base::Random random(3);
    const scene::Scene scene = scene_of(0.0);
    SampleRules drawn = rules();
    drawn.wanted = wanted;
    drawn.radian = 0.07;
    Counts counts;
    for (int i = 0; i < 4000; ++i) {
      const Vector3d at = *surface_sample(scene, 0, drawn, random) - scene.body(0).p_WB;
      if (std::abs(at.y()) > kHalf.y()) continue;
      ++(at.x() < 0.0 ? counts.forth : counts.back);
      if (std::abs(at.y()) > 0.02) ++(at.x() * at.y() > 0.0 ? counts.left : counts.right);
    }
    return counts;
  };
  const Counts alike = draw(Vector3d::Zero());
  CHECK(alike.forth == Approx(alike.back).epsilon(0.1));
  CHECK(alike.left == Approx(alike.right).epsilon(0.1));
  // at most twice as often, as a plan may know better
  const Counts forth = draw({0.1, 0.0, 0.0});
  CHECK(forth.forth > 1.5 * forth.back);
  CHECK(forth.forth < 2.0 * forth.back);
  CHECK(forth.left == Approx(forth.right).epsilon(0.15));
  const Counts back = draw({-0.1, 0.0, 0.0});
  CHECK(back.back > 1.5 * back.forth);
  const Counts left = draw({0.0, 0.0, 0.1});
  CHECK(left.forth == Approx(left.back).epsilon(0.1));
  CHECK(left.left > 1.2 * left.right);
  const Counts right = draw({0.0, 0.0, -0.1});
  CHECK(right.right > 1.2 * right.left);
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
