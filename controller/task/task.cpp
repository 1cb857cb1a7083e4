#include "controller/task/task.hpp"

#include <cmath>

namespace c3rt::task {
namespace {
// what is told as the limit is within it, whatever the rounding
constexpr double kRounding = 1e-9;
// an axis that stands nearer to upright than this does not point anywhere in the plane [rad]
constexpr double kUpright = 0.02;
}  // namespace

double Goal::turn_about_z(const scene::Body& body) const noexcept {
  if (axis) {
    const Eigen::Vector3d now = Eigen::Quaterniond(body.q_WB) * axis->of_body;
    const Eigen::Vector2d from = now.head<2>(), to = axis->to.head<2>();
    if (from.norm() < kUpright || to.norm() < kUpright) return 0.0;
    return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  }
  return yaw ? std::remainder(*yaw - scene::yaw(body), 2.0 * M_PI) : 0.0;
}

bool Limits::holds(const Eigen::Vector2d& at) const {
  // written so that NaN fails
  return (at.array() >= reach.min().array() - kRounding).all() &&
         (at.array() <= reach.max().array() + kRounding).all();
}

std::string Limits::words(double inside) const {
  return task::words("x in [%g, %g] and y in [%g, %g] m", reach.min().x() + inside,
                     reach.max().x() - inside, reach.min().y() + inside, reach.max().y() - inside);
}

}  // namespace c3rt::task
