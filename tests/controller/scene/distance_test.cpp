#include "controller/scene/distance.hpp"

#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"

using namespace c3rt::scene;
using c3rt::support::Random;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Matrix3d anyhow(Random& random) {
  return Eigen::AngleAxisd(3.0 * random.uniform(), random.vector(3).normalized())
      .toRotationMatrix();
}

/// From where it is seen by a point of W.
double distance_of(const Shape& shape, const Place& place, const Vector3d& p_W) {
  return nearest(shape, place.R.transpose() * (p_W - place.p)).distance;
}

/// The distance of two convex shapes by descent from many places: that of a point to the first is
/// convex, and so is that to the second.
double brute_force(const Shape& first, const Place& a, const Shape& second, const Place& b) {
  // alternating projections onto the two bodies converge to a nearest pair
  Vector3d p = b.p;
  double between = 0.0;
  for (int i = 0; i < 20000; ++i) {
    for (const auto& [shape, place] : {std::pair{&first, &a}, std::pair{&second, &b}}) {
      const Nearest found = nearest(*shape, place->R.transpose() * (p - place->p));
      if (found.distance > 0.0) {
        between = found.distance;
        p -= found.distance * (place->R * found.normal);
      }
    }
  }
  return between;
}

const ConvexMesh& wedge() {
  static const ConvexMesh mesh({{-0.04, -0.03, -0.02},
                                {0.04, -0.03, -0.02},
                                {-0.04, 0.03, -0.02},
                                {0.04, 0.03, -0.02},
                                {-0.04, -0.03, 0.02},
                                {0.04, -0.03, 0.02}});
  return mesh;
}

std::vector<Shape> shapes() {
  return {Shape::sphere(0.03), Shape::box({0.05, 0.03, 0.02}), Shape::capsule(0.02, 0.04),
          Shape::cylinder(0.03, 0.02), Shape::convex_mesh(wedge())};
}

}  // namespace

TEST_CASE("separation: by hand") {
  const Shape box = Shape::box({0.05, 0.03, 0.02});
  const Place here{Vector3d::Zero(), Matrix3d::Identity()},
      beside{Vector3d(0.13, 0.01, 0.0), Matrix3d::Identity()};
  const Separation apart = separation(box, beside, box, here);
  CHECK(apart.distance == Approx(0.03));
  CHECK((apart.normal - Vector3d::UnitX()).norm() < 1e-9);
  CHECK(apart.p_first.x() == Approx(0.08));
  CHECK(std::abs(apart.p_first.y()) <= 0.03 + 1e-9);
  // corners at 30 and 40 mm
  const Place diagonal{Vector3d(0.13, 0.10, 0.0), Matrix3d::Identity()};
  CHECK(separation(box, diagonal, box, here).distance == Approx(0.05));
  // overlapping by a little
  const Place into{Vector3d(0.098, 0.01, 0.0), Matrix3d::Identity()};
  const Separation overlap = separation(box, into, box, here);
  CHECK(overlap.distance == Approx(-0.002));
  CHECK((overlap.normal - Vector3d::UnitX()).norm() < 1e-9);
  const Separation spheres = separation(Shape::sphere(0.02), beside, Shape::sphere(0.03), here);
  CHECK(spheres.distance == Approx(beside.p.norm() - 0.05));
}

TEST_CASE("separation: of a sphere it is that of its centre") {
  Random random(1);
  const Shape sphere = Shape::sphere(0.02);
  for (const Shape& shape : shapes()) {
    for (int i = 0; i < 300; ++i) {
      const Place a{0.15 * random.vector(3), Matrix3d::Identity()},
          b{0.02 * random.vector(3), anyhow(random)};
      const double truth = distance_of(shape, b, a.p) - 0.02;
      if (truth < -0.015) continue;
      CAPTURE(static_cast<int>(shape.kind), i);
      // a cylinder's rim is round
      REQUIRE(separation(sphere, a, shape, b).distance == Approx(truth).margin(1e-6));
    }
  }
}

TEST_CASE("separation: no point of either body is nearer to the other") {
  Random random(2);
  int apart = 0;
  for (const Shape& first : shapes()) {
    for (const Shape& second : shapes()) {
      for (int i = 0; i < 6; ++i) {
        const Place a{0.2 * random.vector(3), anyhow(random)},
            b{0.02 * random.vector(3), anyhow(random)};
        const Separation found = separation(first, a, second, b);
        CAPTURE(static_cast<int>(first.kind), static_cast<int>(second.kind), i);
        const Separation other_way = separation(second, b, first, a);
        REQUIRE(other_way.distance == Approx(found.distance).margin(2e-6));
        if (found.distance < 1e-3) continue;
        ++apart;
        // its two points are on the surfaces, and so far apart
        REQUIRE(std::abs(distance_of(first, a, found.p_first)) < 2e-6);
        REQUIRE(std::abs(distance_of(second, b, found.p_first - found.distance * found.normal)) <
                2e-6);
        REQUIRE(brute_force(first, a, second, b) == Approx(found.distance).margin(2e-5));
      }
    }
  }
  CHECK(apart > 60);
}

TEST_CASE("separation: of several parts the nearest two count, without the heap") {
  Union tee;
  tee.parts.push_back({Shape::box({0.08, 0.02, 0.02}), {0.0, 0.02, 0.0}});
  tee.parts.push_back({Shape::box({0.02, 0.05, 0.02}), {0.0, -0.05, 0.0}});
  const Shape shape = Shape::all_of(tee);
  const Place here{Vector3d::Zero(), Matrix3d::Identity()},
      below{Vector3d(0.0, -0.2, 0.0), Matrix3d::Identity()};
  Separation found{};
  std::int64_t heap_calls = 0;
  {
    const c3rt::support::AllocationCounter heap;
    found = separation(shape, here, shape, below);
    heap_calls = heap.count();
  }
  CHECK(found.distance == Approx(0.2 - 0.1 - 0.04));
  CHECK((found.normal - Vector3d::UnitY()).norm() < 1e-9);
  CHECK(heap_calls == 0);
}
