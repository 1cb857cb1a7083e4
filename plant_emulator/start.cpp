#include "plant_emulator/start.hpp"

#include <cmath>
#include <random>

namespace c3rt::plant {

Parameters drawn_start(Parameters parameters, std::uint64_t seed) {
  // the distributions of <random> differ between standard libraries
  std::mt19937_64 engine(seed);
  const auto uniform = [&engine] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  constexpr double kTwoPi = 6.283185307179586476925;
  for (BallParameters& ball : parameters.world.balls) {
    const double distance = ball.start_spread * std::sqrt(uniform());
    const double angle = kTwoPi * uniform();
    ball.position += distance * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  return parameters;
}

}  // namespace c3rt::plant
