#pragma once
// The cross product as a matrix, for bodies that turn.
#include <Eigen/Core>

namespace c3rt::scene {

/// [a]: [a] b = a × b.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d result;
  result << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return result;
}

}  // namespace c3rt::scene
