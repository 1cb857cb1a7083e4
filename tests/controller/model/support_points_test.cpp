#include "controller/model/support_points.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::SupportPoints;

namespace {

Matrix3d turned(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

scene::Object object(std::vector<scene::Part> parts) {
  scene::Union all;
  all.parts = std::move(parts);
  return scene::make_object("thing", 1.0, Matrix3d::Identity(), 0.5, all);
}

scene::Object jack() {
  const scene::Shape bar = scene::Shape::capsule(0.015, 0.05);
  return object({{bar, Vector3d::Zero()},
                 {bar, Vector3d::Zero(), turned(0.5 * M_PI, Vector3d::UnitX())},
                 {bar, Vector3d::Zero(), turned(0.5 * M_PI, Vector3d::UnitY())}});
}

/// How low each point's surface is.
std::vector<double> heights(const SupportPoints& support, const Matrix3d& R_WB) {
  std::vector<double> result;
  for (const SupportPoints::Point& point : support.below(R_WB))
    result.push_back((R_WB * point.p_B).z() - point.radius);
  return result;
}

}  // namespace

TEST_CASE("support points: a round object has as many as it has ends") {
  const SupportPoints ball(object({{scene::Shape::sphere(0.03)}}), 4);
  CHECK(ball.size() == 1);
  const SupportPoints rod(object({{scene::Shape::capsule(0.02, 0.05)}}), 4);
  CHECK(rod.size() == 2);
  support::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d R = turned(3.0 * random.uniform(), random.vector(3).normalized());
    CHECK(heights(ball, R)[0] == Approx(-0.03));
    // both ends, however it lies
    const std::vector<double> ends = heights(rod, R);
    CHECK(*std::min_element(ends.begin(), ends.end()) == Approx(-0.02 - 0.05 * std::abs(R(2, 2))));
  }
}

TEST_CASE("support points: a jack stands on the three ends that are below, whichever they are") {
  const SupportPoints support(jack(), 3);
  CHECK(support.size() == 3);
  support::Random random(2);
  for (int i = 0; i < 100; ++i) {
    // one of its eight faces down, then any turn about z
    const Vector3d down = Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1).normalized();
    const Matrix3d R = turned(6.0 * random.uniform(), Vector3d::UnitZ()) *
                       support::turn(down, -Vector3d::UnitZ()).toRotationMatrix();
    for (const double height : heights(support, R))
      CHECK(height == Approx(-0.05 / std::sqrt(3.0) - 0.015));
  }
}

TEST_CASE("support points: a cylinder stands on its rim, and lies on its side") {
  const SupportPoints support(object({{scene::Shape::cylinder(0.03, 0.04)}}), 4);
  CHECK(support.size() == 4);
  Vector3d sum = Vector3d::Zero();
  for (const SupportPoints::Point& point : support.below(Matrix3d::Identity())) {
    CHECK(point.p_B.z() == Approx(-0.04));
    CHECK(point.p_B.head<2>().norm() == Approx(0.03));
    sum += point.p_B;
  }
  CHECK(sum.head<2>().norm() < 0.01);  // all around
  for (double roll = 0.0; roll < 6.3; roll += 0.3) {
    const Matrix3d R = turned(0.5 * M_PI, Vector3d::UnitX()) * turned(roll, Vector3d::UnitZ());
    std::vector<double> low = heights(support, R);
    std::sort(low.begin(), low.end());
    // a point of either end is at the bottom, to the chord of the rim between two points
    CHECK(low[0] >= -0.03 - 1e-9);
    CHECK(low[1] < -0.03 * std::cos(M_PI / 8.0) + 1e-9);
  }
}

TEST_CASE(
    "support points: nothing of a body that lies flat is below them, whatever it is made of") {
  support::Random random(3);
  for (int i = 0; i < 20; ++i) {
    // boxes in one plane, anyhow beside each other
    std::vector<scene::Part> parts;
    for (int part = 0; part < 3; ++part) {
      parts.push_back(
          {scene::Shape::box({random.uniform(0.02, 0.08), random.uniform(0.02, 0.04), 0.02}),
           {0.04 * random.uniform(), 0.04 * random.uniform(), 0.0},
           turned(random.uniform(), Vector3d::UnitZ())});
    }
    for (const int count : {3, 4}) {
      const SupportPoints support(object(parts), count);
      CHECK(support.size() == count);
      for (const Matrix3d& R : {Matrix3d(Matrix3d::Identity()), turned(M_PI, Vector3d::UnitX())})
        for (const double height : heights(support, R)) CHECK(height == Approx(-0.02));
    }
  }
}

TEST_CASE("support points: another number than three or four is refused") {
  for (const int count : {0, 2, 5})
    CHECK_THROWS_WITH(SupportPoints(jack(), count), Catch::Contains("expected 3 or 4"));
}
