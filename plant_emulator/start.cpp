#include "plant_emulator/start.hpp"

#include <cmath>

#include "plant_emulator/draws.hpp"

namespace c3rt::plant {

namespace {

// the balls' starts are drawn from the same seed and shall not be the same numbers
constexpr std::uint64_t kTableStream = 0xD1B54A32D192ED03;

}  // namespace

World drawn_table(World world, std::uint64_t seed) {
  base::Random random(seed ^ kTableStream);
  // drawn whether used or not: one draw does not change with whether the other is wanted
  const Eigen::Vector2d direction = draw_direction(random);
  if (world.tilt_drawn) world.table_tilt = world.table_tilt.norm() * direction;
  const double table = random.uniform(), end_effector = random.uniform();
  if (world.friction_drawn) {
    const double least = world.friction_drawn->x(), most = world.friction_drawn->y();
    world.friction.ball_table = least + (most - least) * table;
    world.friction.ball_end_effector = least + (most - least) * end_effector;
  }
  return world;
}

Parameters drawn_start(Parameters parameters, std::uint64_t seed) {
  parameters.world = drawn_table(parameters.world, seed);
  base::Random random(seed);
  for (BallParameters& ball : parameters.world.balls) {
    const double distance = ball.start_spread * std::sqrt(random.uniform());
    ball.position += distance * draw_direction(random);
  }
  return parameters;
}

}  // namespace c3rt::plant
