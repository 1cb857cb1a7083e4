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
  std::vector<Vector3d> corners;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d signs((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                         (corner & 4) != 0 ? 1 : -1);
    corners.push_back(signs.cwiseProduct(half));
  }
  return ConvexMesh(std::move(corners));
}

const Vector3d kHalf(0.05, 0.03, 0.02);

/// A T of two boxes that touch, its top along x.
Union tee() {
  Union result;
  result.parts.push_back({Shape::box({0.08, 0.02, 0.02}), {0.0, 0.02, 0.0}});
  result.parts.push_back({Shape::box({0.02, 0.05, 0.02}), {0.0, -0.05, 0.0}});
  return result;
}

Part turned(const Shape& shape, const Vector3d& p_BP, double angle, const Vector3d& axis) {
  return {shape, p_BP, Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix()};
}

std::vector<Shape> shapes(const ConvexMesh& mesh, const Union& parts) {
  return {Shape::sphere(0.0315),       Shape::box(kHalf),        Shape::capsule(0.02, 0.05),
          Shape::cylinder(0.03, 0.04), Shape::convex_mesh(mesh), Shape::all_of(parts)};
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
  const Union parts = tee();
  for (const Shape& shape : shapes(mesh, parts)) {
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
    REQUIRE(hull.distance == Approx(box.distance).margin(1e-9));
    if (box.distance > 1e-3) REQUIRE((hull.normal - box.normal).norm() < 1e-6);
  }
}

TEST_CASE("shape: the faces of a hull are those of its corners, and points within it add none") {
  std::vector<Vector3d> points = box_mesh(kHalf).vertices();
  points.insert(points.end(), {Vector3d::Zero(), {0.01, 0.02, -0.01}, {kHalf.x(), 0.0, 0.0}});
  CHECK(ConvexMesh(points).faces().size() == 6);

  // every face of a hull of random points holds them all, and every outermost point lies on some
  c3rt::support::Random random(5);
  points.clear();
  for (int i = 0; i < 60; ++i) points.push_back(0.1 * random.vector(3));
  const ConvexMesh mesh(points);
  for (const Plane& face : mesh.faces()) {
    double most = -1.0;
    for (const Vector3d& point : points) most = std::max(most, face.normal.dot(point));
    CHECK(most == Approx(face.offset).margin(1e-12));
  }
  for (int i = 0; i < 500; ++i) {
    const Vector3d way = random.vector(3).normalized();
    const Vector3d* outermost = &points[0];
    for (const Vector3d& point : points)
      if (way.dot(point) > way.dot(*outermost)) outermost = &point;
    const double distance = nearest(Shape::convex_mesh(mesh), *outermost).distance;
    CHECK(std::abs(distance) < 1e-9);
  }
}

TEST_CASE("shape: a hull without volume is refused") {
  CHECK_THROWS_WITH(ConvexMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}),
                    Catch::Contains("enclose a volume"));
  CHECK_THROWS_WITH(ConvexMesh({}), Catch::Contains("enclose a volume"));
  CHECK_THROWS_WITH(ConvexMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {NAN, 1, 1}}),
                    Catch::Contains("finite"));
}

TEST_CASE("shape: of several parts the nearest one counts, wherever and however they are") {
  c3rt::support::Random random(3);
  const ConvexMesh mesh = box_mesh({0.01, 0.03, 0.02});
  Union parts;
  parts.parts = {turned(Shape::box({0.03, 0.01, 0.02}), {0.05, 0.0, 0.01}, 0.7, {1, 2, 3}),
                 turned(Shape::capsule(0.015, 0.04), {-0.04, 0.02, 0.0}, 1.3, {0, 1, 1}),
                 turned(Shape::cylinder(0.02, 0.01), {0.0, -0.05, 0.02}, 2.1, {1, 0, 1}),
                 turned(Shape::convex_mesh(mesh), {0.0, 0.05, -0.03}, 0.2, {1, 1, 0}),
                 {Shape::sphere(0.01), {0.0, 0.0, 0.06}}};
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = 0.2 * random.vector(3);
    double distance = 1.0;
    for (const Part& part : parts.parts) {
      const Vector3d p_P = part.R_BP.transpose() * (p - part.p_BP);
      distance = std::min(distance, nearest(part.shape, p_P).distance);
    }
    if (distance < 1e-6) continue;
    const Nearest found = nearest(Shape::all_of(parts), p);
    REQUIRE(found.distance == Approx(distance));
    REQUIRE(found.normal.norm() == Approx(1.0));
  }
}

TEST_CASE("shape: inside several parts it is as far out as no part is") {
  // by hand, of the T: beneath its top's middle the stem goes on, and its inner corners are near
  const Union t = tee();
  CHECK(nearest(Shape::all_of(t), {0.0, 0.0, 0.0}).distance == Approx(-0.02));
  CHECK(nearest(Shape::all_of(t), {0.0, -0.005, 0.015}).distance == Approx(-0.005));
  CHECK(nearest(Shape::all_of(t), {0.0, -0.01, 0.0}).distance == Approx(-0.02));
  CHECK(nearest(Shape::all_of(t), {0.025, 0.003, 0.0}).distance == Approx(-0.003));
  const Nearest corner = nearest(Shape::all_of(t), {0.015, 0.005, 0.0});
  CHECK(corner.distance == Approx(-std::hypot(0.005, 0.005)));
  CHECK((corner.normal - Vector3d(1.0, -1.0, 0.0).normalized()).norm() < 1e-6);

  // against every way out: no point outside is nearer, and the end of the way is outside
  c3rt::support::Random random(9);
  const ConvexMesh mesh = box_mesh({0.02, 0.03, 0.025});
  std::vector<Union> unions(2, t);
  unions[1].parts = {turned(Shape::box({0.05, 0.02, 0.02}), {0.01, 0.0, 0.0}, 0.5, {0, 0, 1}),
                     turned(Shape::box({0.03, 0.03, 0.02}), {-0.03, 0.01, 0.01}, 0.4, {1, 2, 0}),
                     turned(Shape::convex_mesh(mesh), {0.0, 0.02, 0.0}, 0.3, {1, 1, 1})};
  for (const Union& whole : unions) {
    const Shape shape = Shape::all_of(whole);
    int inside = 0;
    for (int i = 0; inside < 60; ++i) {
      const Vector3d p = 0.08 * random.vector(3);
      const Nearest found = nearest(shape, p);
      if (found.distance > -1e-4) continue;
      ++inside;
      CAPTURE(p.transpose(), found.distance, found.normal.transpose());
      REQUIRE(std::abs(nearest(shape, p - found.distance * found.normal).distance) < 1e-7);
      for (int way = 0; way < 2000; ++way) {
        const Vector3d there = p + (1.0 - 1e-6) * -found.distance * random.vector(3).normalized();
        REQUIRE(nearest(shape, there).distance < 0.0);
      }
    }
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
  const Union parts = tee();
  Effector effector;
  Body body;
  for (const Shape& shape : shapes(mesh, parts)) {
    body.shape = shape;
    double outside = 0.0, inside = 0.0;
    std::int64_t heap_calls = 0;
    {
      const c3rt::support::AllocationCounter heap;
      effector.p_WE = {0.1, 0.07, 0.3};
      outside = gap(effector, body).distance;
      effector.p_WE = {0.001, 0.002, 0.003};
      inside = gap(effector, body).distance;
      heap_calls = heap.count();
    }
    CHECK(outside > 0.0);
    CHECK(inside < 0.0);
    CHECK(heap_calls == 0);
  }
}

TEST_CASE("name: of fixed size, cut off where it is too long") {
  CHECK(std::string(Name("box").c_str()) == "box");
  CHECK(std::string(Name(std::string(100, 'x').c_str()).c_str()) == std::string(31, 'x'));
  CHECK(std::string(Name().c_str()).empty());
}
