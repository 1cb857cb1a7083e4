#include "controller/scene/mechanism.hpp"

#include <cmath>

#include "controller/scene/cross_matrix.hpp"

namespace c3rt::scene {
using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d rotation(const Vector3d& turn) noexcept {
  const double angle = turn.norm();
  if (!(angle > 0.0)) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

Vector3d rotation_vector(const Matrix3d& R) noexcept {
  // by the quaternion, which keeps its digits near no turn at all, as a trace does not
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (!(sine > 0.0)) return Vector3d::Zero();
  return 2.0 * std::atan2(sine, q.w()) / sine * q.vec();
}

Matrix3d left_jacobian(const Vector3d& turn) noexcept {
  const double angle = turn.norm();
  const Matrix3d by = cross_matrix(turn);
  // their series near 0, where the quotients lose their digits
  const bool small = angle < 1e-3;
  const double first =
      small ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  const double second = small ? 1.0 / 6.0 - angle * angle / 120.0
                              : (angle - std::sin(angle)) / (angle * angle * angle);
  return Matrix3d::Identity() + first * by + second * by * by;
}

void move(const std::vector<Coordinate>& coordinates, const Eigen::VectorXd& v, double time,
          Eigen::VectorXd& q) {
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (coordinates[i].kind != Coordinate::Kind::kRotation) {
      q[at] += time * v[at];
      continue;
    }
    const Vector3d turn = time * v.segment<3>(at);
    q.segment<3>(at) = rotation_vector(rotation(turn) * rotation(q.segment<3>(at)));
    i += 2;
  }
}

}  // namespace c3rt::scene
