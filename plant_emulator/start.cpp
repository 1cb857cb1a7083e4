#include "plant_emulator/start.hpp"

#include <cmath>

#include "plant_emulator/draws.hpp"

namespace c3rt::plant {

Parameters drawn_start(Parameters parameters, std::uint64_t seed) {
  Draws draws(seed);
  for (BallParameters& ball : parameters.world.balls) {
    const double distance = ball.start_spread * std::sqrt(draws.uniform());
    ball.position += distance * draws.direction();
  }
  return parameters;
}

}  // namespace c3rt::plant
