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

double yaw(const Body& body) noexcept {
  const auto& q = body.q_WB;
  return std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()),
                    1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z()));
}

}  // namespace c3rt::scene
