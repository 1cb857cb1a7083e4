#pragma once
// What a seed decides in the plant.
#include <cmath>

#include <Eigen/Core>

#include "controller/base/random.hpp"

namespace c3rt::plant {

/// A unit vector in the plane of the table, every direction as likely as another.
inline Eigen::Vector2d draw_direction(base::Random& random) {
  constexpr double kTwoPi = 6.283185307179586476925;
  const double angle = kTwoPi * random.uniform();
  return {std::cos(angle), std::sin(angle)};
}

}  // namespace c3rt::plant
