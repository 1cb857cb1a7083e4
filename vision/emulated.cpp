#include "vision/emulated.hpp"

#include <algorithm>

namespace c3rt::vision {

Eigen::Vector3d EmulatedSensor::measure(const Eigen::Vector3d& p_WB) noexcept {
  Eigen::Vector3d p_measured = p_WB;
  // drawn also without noise, so that the sequence of a seed never depends on sigma
  for (int axis = 0; axis < 2; ++axis) {
    p_measured[axis] +=
        std::clamp(parameters_.noise * random_.normal(), -parameters_.clip, parameters_.clip);
  }
  return p_measured;
}

Eigen::Quaterniond EmulatedSensor::measure(const Eigen::Quaterniond& q_WB) noexcept {
  const double angle = parameters_.angle_noise * random_.normal();
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * q_WB;
}

}  // namespace c3rt::vision
