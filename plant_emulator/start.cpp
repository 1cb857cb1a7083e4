#include "plant_emulator/start.hpp"

#include <cmath>

#include "plant_emulator/draws.hpp"

namespace c3rt::plant {

namespace {

// the objects' places are drawn from the same seed and shall not be the same numbers
constexpr std::uint64_t kTableStream = 0xD1B54A32D192ED03, kYawStream = 0x8CB92BA72F3D8DD7;

}  // namespace

World drawn_table(World world, std::uint64_t seed) {
  base::Random random(seed ^ kTableStream);
  // drawn whether used or not: one draw does not change with whether the other is wanted
  const Eigen::Vector2d direction = draw_direction(random);
  if (world.tilt_drawn) world.table_tilt = world.table_tilt.norm() * direction;
  const double table = random.uniform(), end_effector = random.uniform();
  if (world.friction_drawn) {
    const double least = world.friction_drawn->x(), most = world.friction_drawn->y();
    for (ObjectParameters& object : world.objects) {
      object.friction_table = least + (most - least) * table;
      object.friction_end_effector = least + (most - least) * end_effector;
    }
  }
  return world;
}

Parameters drawn_start(Parameters parameters, std::uint64_t seed) {
  parameters.world = drawn_table(parameters.world, seed);
  base::Random random(seed), yaw(seed ^ kYawStream);
  for (ObjectParameters& object : parameters.world.objects) {
    if (object.start_spread_xy.isZero(0.0)) {
      const double distance = object.start_spread * std::sqrt(random.uniform());
      object.position += distance * draw_direction(random);
    } else {
      const double x = random.uniform(), y = random.uniform();
      object.position +=
          object.start_spread_xy.cwiseProduct(Eigen::Vector2d(2.0 * x - 1.0, 2.0 * y - 1.0));
    }
    object.yaw += object.yaw_spread * (2.0 * yaw.uniform() - 1.0);
  }
  return parameters;
}

}  // namespace c3rt::plant
