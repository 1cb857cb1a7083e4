#pragma once
// What a seed decides in the plant.
#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Core>

namespace c3rt::plant {

/// The same numbers with every standard library, whose distributions differ.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  /// In [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// A unit vector in the plane of the table.
  Eigen::Vector2d direction() {
    constexpr double kTwoPi = 6.283185307179586476925;
    const double angle = kTwoPi * uniform();
    return {std::cos(angle), std::sin(angle)};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace c3rt::plant
