#include "vision/track/sphere.hpp"

#include <cmath>
#include <stdexcept>

namespace c3rt::vision {

CameraModel centred_camera(int width, int height, double fovy, const Eigen::Isometry3d& X_WC) {
  const double focal = 0.5 * height / std::tan(0.5 * fovy);
  return {focal, focal, 0.5 * (width - 1), 0.5 * (height - 1), width, height, X_WC};
}

Eigen::Matrix3d look_at(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& p_W) {
  constexpr double kSmallest = 1e-6;
  const Eigen::Vector3d forward = p_W - p_WC;
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ());
  if (right.norm() < kSmallest) {
    throw std::invalid_argument(
        "camera: looks straight up or down, so its image has no upright direction");
  }
  Eigen::Matrix3d R_WC;
  R_WC.col(2) = forward.normalized();
  R_WC.col(0) = right.normalized();
  R_WC.col(1) = R_WC.col(2).cross(R_WC.col(0));
  return R_WC;
}

Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& p_C) noexcept {
  return {camera.cx + camera.fx * p_C.x() / p_C.z(), camera.cy + camera.fy * p_C.y() / p_C.z()};
}

Eigen::Vector3d unproject(const CameraModel& camera, const Eigen::Vector2d& pixel) noexcept {
  return {(pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy, 1.0};
}

Outline sphere_outline(const Eigen::Vector3d& p_C, double radius) noexcept {
  const Eigen::Vector2d t = p_C.head<2>();
  const double z = p_C.z();
  const double depth = z * z - radius * radius;
  const double length = t.norm();
  Outline outline;
  outline.centre = t * z / depth;
  outline.major_axis = length > 0.0 ? Eigen::Vector2d(t / length) : Eigen::Vector2d::UnitX();
  outline.semi_minor = radius / std::sqrt(depth);
  outline.semi_major = radius * std::sqrt(p_C.squaredNorm() - radius * radius) / depth;
  return outline;
}

Eigen::Vector3d sphere_from_outline(const Eigen::Vector2d& centre, double semi_minor,
                                    double radius) noexcept {
  const double z = radius * std::sqrt(1.0 + 1.0 / (semi_minor * semi_minor));
  const Eigen::Vector2d t = centre * (z * z - radius * radius) / z;
  return {t.x(), t.y(), z};
}

Cone sphere_cone(const Eigen::Vector3d& p_C, double radius) noexcept {
  const double distance = p_C.norm();
  return {p_C / distance, std::sqrt(1.0 - radius * radius / (distance * distance))};
}

double cone_distance(const Cone& cone, double radius) noexcept {
  return radius / std::sqrt(1.0 - cone.cos_half_angle * cone.cos_half_angle);
}

std::optional<Eigen::Vector3d> intersect_plane(const CameraModel& camera,
                                               const Eigen::Vector3d& direction_C,
                                               double height) noexcept {
  const Eigen::Vector3d p_WC = camera.X_WC.translation();
  const Eigen::Vector3d direction = camera.X_WC.linear() * direction_C;
  const double along = (height - p_WC.z()) / direction.z();
  if (!(along > 0.0) || !std::isfinite(along)) return std::nullopt;
  return p_WC + along * direction;
}

}  // namespace c3rt::vision
