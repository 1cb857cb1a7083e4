#include "controller/scene/scene.hpp"

#include <cmath>

namespace c3rt::scene {

Gap gap(const Effector& effector, const Body& body) noexcept {
  const Eigen::Vector3d apart = effector.p_WE - body.p_WB;
  if (body.shape.kind == ShapeKind::kSphere) {
    const Nearest of_sphere = nearest(body.shape, apart);
    return {of_sphere.distance - effector.radius, of_sphere.normal};
  }
  const Eigen::Quaterniond q_WB = body.q_WB;
  const Nearest found = nearest(body.shape, q_WB.conjugate() * apart);
  return {found.distance - effector.radius, q_WB * found.normal};
}

void separate(const Effector& effector, const Eigen::Vector3d& away, Body& sphere) noexcept {
  const double touching = sphere.shape.radius + effector.radius;
  const Eigen::Vector3d from_end_effector = sphere.p_WB - effector.p_WE;
  if (from_end_effector.norm() >= touching) return;
  Eigen::Vector3d direction(from_end_effector.x(), from_end_effector.y(), 0.0);
  if (direction.norm() < 1e-9) direction = Eigen::Vector3d(away.x(), away.y(), 0.0);
  if (direction.norm() < 1e-9) direction = Eigen::Vector3d::UnitX();
  const double height = from_end_effector.z();
  const double horizontal = std::sqrt(touching * touching - height * height);
  sphere.p_WB.head<2>() = effector.p_WE.head<2>() + horizontal * direction.normalized().head<2>();
}

double yaw(const Body& body) noexcept {
  const auto& q = body.q_WB;
  return std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()),
                    1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z()));
}

}  // namespace c3rt::scene
