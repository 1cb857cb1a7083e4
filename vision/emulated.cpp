#include "vision/emulated.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::vision {

double NormalSequence::uniform() noexcept {
  return static_cast<double>((engine_() >> 11) + 1) * 0x1p-53;
}

double NormalSequence::next() noexcept {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  constexpr double kTwoPi = 6.283185307179586476925;
  const double length = std::sqrt(-2.0 * std::log(uniform()));
  const double angle = kTwoPi * uniform();
  spare_ = length * std::sin(angle);
  has_spare_ = true;
  return length * std::cos(angle);
}

Eigen::Vector3d EmulatedSensor::measure(const Eigen::Vector3d& p_WB) noexcept {
  Eigen::Vector3d p_measured = p_WB;
  // drawn also without noise, so that the sequence of a seed never depends on sigma
  for (int axis = 0; axis < 2; ++axis) {
    p_measured[axis] +=
        std::clamp(parameters_.noise * normal_.next(), -parameters_.clip, parameters_.clip);
  }
  return p_measured;
}

}  // namespace c3rt::vision
