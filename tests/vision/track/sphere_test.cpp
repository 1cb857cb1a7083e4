#include "vision/track/sphere.hpp"

#include <cmath>
#include <vector>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

using namespace c3rt::vision;

namespace {

constexpr double kRadius = 0.0315;
const std::vector<Eigen::Vector3d> kPlaces = {
    {0, 0, 0.5}, {0.1, -0.2, 0.6}, {-0.4, 0.3, 0.8}, {0.03, 0.02, 0.1}, {0.5, 0.5, 0.4}};

/// Points of the sphere where the line of sight touches it: (p − c)·p = 0 with |p − c| = r. Built
/// from geometry alone, as the circle in which the sphere meets the sphere that has camera and
/// centre as its poles.
std::vector<Eigen::Vector3d> touching_points(const Eigen::Vector3d& c) {
  const double L = c.norm();
  const Eigen::Vector3d axis = c / L;
  const Eigen::Vector3d across = axis.unitOrthogonal();
  const Eigen::Vector3d third = axis.cross(across);
  const double along = L - kRadius * kRadius / L;
  const double ring = kRadius * std::sqrt(1 - kRadius * kRadius / (L * L));
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 360; ++k) {
    const double angle = k * M_PI / 180;
    points.push_back(along * axis + ring * (std::cos(angle) * across + std::sin(angle) * third));
  }
  return points;
}

}  // namespace

TEST_CASE(
    "sphere: every projected point of the sphere lies in the outline and the touching ones on it") {
  for (const Eigen::Vector3d& c : kPlaces) {
    const Outline outline = sphere_outline(c, kRadius);
    const Eigen::Vector2d minor(-outline.major_axis.y(), outline.major_axis.x());
    const auto level = [&](const Eigen::Vector3d& p) {
      const Eigen::Vector2d e = p.head<2>() / p.z() - outline.centre;
      return std::hypot(e.dot(outline.major_axis) / outline.semi_major,
                        e.dot(minor) / outline.semi_minor);
    };
    for (const Eigen::Vector3d& p : touching_points(c)) {
      REQUIRE((p - c).norm() == Approx(kRadius).epsilon(1e-12));  // on the sphere
      REQUIRE(std::abs((p - c).dot(p)) < 1e-12);                  // and touched by the ray
      REQUIRE(level(p) == Approx(1.0).epsilon(1e-9));
    }
    double largest = 0.0;
    for (int a = 0; a < 180; ++a) {
      for (int b = 0; b < 360; ++b) {
        const double polar = a * M_PI / 180, azimuth = b * M_PI / 180;
        const Eigen::Vector3d p =
            c + kRadius * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                          std::sin(polar) * std::sin(azimuth), std::cos(polar));
        largest = std::max(largest, level(p));
      }
    }
    REQUIRE(largest <= 1.0 + 1e-9);
    REQUIRE(largest > 0.999);
  }
}

TEST_CASE(
    "sphere: the centre of the outline is farther from the image's middle than the sphere's "
    "centre") {
  const Eigen::Vector3d c(0.3, 0.0, 0.5);
  const Outline outline = sphere_outline(c, kRadius);
  const double bias = outline.centre.x() - c.x() / c.z();
  REQUIRE(bias > 0.0);
  REQUIRE(bias ==
          Approx(0.3 / 0.5 * kRadius * kRadius / (0.25 - kRadius * kRadius)).epsilon(1e-12));
}

TEST_CASE("sphere: the centre follows from the outline, both ways and through the cone") {
  for (const Eigen::Vector3d& c : kPlaces) {
    const Outline outline = sphere_outline(c, kRadius);
    REQUIRE((sphere_from_outline(outline.centre, outline.semi_minor, kRadius) - c).norm() < 1e-12);
    const Cone cone = sphere_cone(c, kRadius);
    REQUIRE((cone_distance(cone, kRadius) * cone.direction - c).norm() < 1e-12);
    for (const Eigen::Vector3d& p : touching_points(c)) {
      REQUIRE(p.normalized().dot(cone.direction) == Approx(cone.cos_half_angle).epsilon(1e-12));
    }
  }
}

TEST_CASE(
    "camera: looks where it is told, upright, and its rays hit the table where the point is") {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.translation() = Eigen::Vector3d(1.2, 0.5, 0.8);
  const Eigen::Vector3d target(0.55, 0.0, 0.03);
  X_WC.linear() = look_at(X_WC.translation(), target);
  REQUIRE(X_WC.linear().determinant() == Approx(1.0));
  const CameraModel camera = centred_camera(640, 480, 0.8, X_WC);
  REQUIRE((project(camera, X_WC.inverse() * target) - Eigen::Vector2d(319.5, 239.5)).norm() < 1e-9);
  const Eigen::Vector2d above =
      project(camera, X_WC.inverse() * (target + Eigen::Vector3d(0, 0, 0.1)));
  REQUIRE(above.x() == Approx(319.5));
  REQUIRE(above.y() < 239.5);

  const Eigen::Vector3d p_WB(0.47, 0.11, 0.0315);
  const Eigen::Vector2d pixel = project(camera, X_WC.inverse() * p_WB);
  REQUIRE((*intersect_plane(camera, unproject(camera, pixel), 0.0315) - p_WB).norm() < 1e-12);
  // a plane behind the camera is not in the picture
  REQUIRE_FALSE(intersect_plane(camera, unproject(camera, pixel), 1.0));
  REQUIRE_THROWS_AS(look_at({0.5, 0, 1}, {0.5, 0, 0}), std::invalid_argument);
}
