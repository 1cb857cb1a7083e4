#include "controller/scene/object.hpp"

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::scene;

namespace {

/// Inertia of even density by summing points of a grid.
Eigen::Matrix3d summed(const Shape& shape, double mass) {
  constexpr int kCells = 60;
  const double half = 0.1;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  int inside = 0;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      for (int k = 0; k < kCells; ++k) {
        const Eigen::Vector3d p =
            half *
            (Eigen::Vector3d(2 * i + 1, 2 * j + 1, 2 * k + 1) / kCells - Eigen::Vector3d::Ones());
        if (nearest(shape, p).distance > 0.0) continue;
        ++inside;
        inertia += p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose();
      }
    }
  }
  return mass / inside * inertia;
}

TEST_CASE("solid: the inertia of a shape of even density is that of its volume") {
  for (const Shape& shape : {Shape::sphere(0.08), Shape::box({0.09, 0.05, 0.03}),
                             Shape::capsule(0.03, 0.06), Shape::cylinder(0.05, 0.08)}) {
    const Object object = solid("one", shape, 0.7);
    CAPTURE(static_cast<int>(shape.kind));
    CHECK(object.inertia.isApprox(summed(shape, 0.7), 0.02));
    CHECK(object.mass == 0.7);
    CHECK(object.shape().kind == shape.kind);
  }
}

TEST_CASE("solid: a shape whose inertia is not known is refused") {
  const ConvexMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  CHECK_THROWS_WITH(solid("one", Shape::convex_mesh(mesh), 1.0), Catch::Contains("mesh"));
}

}  // namespace
