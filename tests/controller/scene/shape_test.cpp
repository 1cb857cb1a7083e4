#include "controller/scene/shape.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "controller/scene/scene.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"

using namespace c3rt::scene;
using Eigen::Vector3d;

namespace {

ConvexMesh box_mesh(const Vector3d& half) {
  ConvexMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d signs((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                         (corner & 4) != 0 ? 1 : -1);
    mesh.vertices.push_back(signs.cwiseProduct(half));
  }
  return mesh;
}

const Vector3d kHalf(0.05, 0.03, 0.02);

std::vector<Shape> shapes(const ConvexMesh& mesh) {
  return {Shape::sphere(0.0315), Shape::box(kHalf), Shape::capsule(0.02, 0.05),
          Shape::cylinder(0.03, 0.04), Shape::convex_mesh(mesh)};
}

}  // namespace

TEST_CASE("shape: the distance by hand, outside and inside") {
  CHECK(nearest(Shape::sphere(0.03), {0.0, 0.05, 0.0}).distance == Approx(0.02));
  CHECK(nearest(Shape::box(kHalf), {0.08, 0.07, 0.0}).distance == Approx(0.05));  // 30, 40 mm
  CHECK(nearest(Shape::box(kHalf), {0.0, 0.0, 0.015}).distance == Approx(-0.005));
  CHECK(nearest(Shape::box(kHalf), {0.0, 0.0, -0.015}).normal == -Vector3d::UnitZ());
  CHECK(nearest(Shape::capsule(0.02, 0.05), {0.0, 0.03, 0.09}).distance == Approx(0.03));
  CHECK(nearest(Shape::capsule(0.02, 0.05), {0.03, 0.0, 0.01}).distance == Approx(0.01));
  CHECK(nearest(Shape::cylinder(0.03, 0.04), {0.06, 0.0, 0.08}).distance == Approx(0.05));
  CHECK(nearest(Shape::cylinder(0.03, 0.04), {0.0, 0.0, 0.039}).distance == Approx(-0.001));
}

TEST_CASE("shape: the normal leads to the nearest point of the surface, whatever the shape") {
  c3rt::support::Random random(7);
  const ConvexMesh mesh = box_mesh(kHalf);
  for (const Shape& shape : shapes(mesh)) {
    CAPTURE(static_cast<int>(shape.kind));
    for (int i = 0; i < 2000; ++i) {
      const Vector3d p = 0.2 * random.vector(3);
      const Nearest found = nearest(shape, p);
      if (found.distance < 1e-3) continue;
      REQUIRE(found.normal.norm() == Approx(1.0));
      REQUIRE(std::abs(nearest(shape, p - found.distance * found.normal).distance) < 1e-9);
      REQUIRE(nearest(shape, p - 0.5 * found.distance * found.normal).distance ==
              Approx(0.5 * found.distance).epsilon(1e-9));
    }
  }
}

TEST_CASE("shape: a box as a mesh of its corners is as far away as the box") {
  c3rt::support::Random random(11);
  const ConvexMesh mesh = box_mesh(kHalf);
  for (int i = 0; i < 4000; ++i) {
    const Vector3d p = 0.1 * random.vector(3);
    const Nearest box = nearest(Shape::box(kHalf), p);
    const Nearest hull = nearest(Shape::convex_mesh(mesh), p);
    CAPTURE(i, p.transpose());
    REQUIRE(hull.distance == Approx(std::max(box.distance, 0.0)).margin(1e-9));
    if (box.distance > 1e-3) REQUIRE((hull.normal - box.normal).norm() < 1e-6);
  }
}

TEST_CASE("gap: between the surfaces of end effector and body, however the body is turned") {
  Effector effector;
  effector.radius = 0.02;
  effector.p_WE = {0.1, 0.3, 0.0};
  Body box;
  box.shape = Shape::box(kHalf);
  box.p_WB = {0.1, 0.2, 0.0};
  // a quarter turn: its long side is along y
  box.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitZ()));
  const Gap found = gap(effector, box);
  CHECK(found.distance == Approx(0.1 - 0.05 - 0.02));
  CHECK((found.normal - Vector3d::UnitY()).norm() < 1e-12);
  CHECK(yaw(box) == Approx(0.5 * M_PI));
}

TEST_CASE("gap: does not allocate, whatever the shape") {
  const ConvexMesh mesh = box_mesh(kHalf);
  Effector effector;
  effector.p_WE = {0.1, 0.07, 0.3};
  Body body;
  for (const Shape& shape : shapes(mesh)) {
    body.shape = shape;
    double distance = 0.0;
    std::int64_t heap_calls = 0;
    {
      const c3rt::support::AllocationCounter heap;
      distance = gap(effector, body).distance;
      heap_calls = heap.count();
    }
    CHECK(distance > 0.0);
    CHECK(heap_calls == 0);
  }
}

TEST_CASE("name: of fixed size, cut off where it is too long") {
  CHECK(std::string(Name("box").c_str()) == "box");
  CHECK(std::string(Name(std::string(100, 'x').c_str()).c_str()) == std::string(31, 'x'));
  CHECK(std::string(Name().c_str()).empty());
}
