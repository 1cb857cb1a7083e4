#pragma once
// The plant that the tests of this room share.
#include <string>

#include "plant_emulator/load_parameters.hpp"

namespace c3rt::plant {

/// A sphere, as in the scenarios.
inline ObjectParameters ball(const Eigen::Vector2d& position, double radius, double mass,
                             int index = 0) {
  ObjectParameters result{};
  result.object = scene::solid("ball" + std::to_string(index), scene::Shape::sphere(radius), mass);
  result.position = position;
  return result;
}

inline World test_world() {
  World world{};
  world.table_height = -0.0245;
  world.table_tilt = Eigen::Vector2d::Zero();
  world.friction = {1.0, 1.0};
  world.rolling_friction = 0.0;
  world.step = 0.0005;
  world.end_effector = end_effector_of(config::load_robot("panda"));
  world.objects.push_back(ball({0.55, 0.1}, 0.0315, 0.132));
  return world;
}

inline SceneParameters test_scene() { return {test_world(), {}, 64, 64, 0, ""}; }

inline Parameters test_parameters() {
  Parameters parameters{};
  parameters.world = test_world();
  parameters.limits = limits_of(config::load_robot("panda"));
  parameters.safety = safety_of(config::load_robot("panda"));
  parameters.initial_q << 0, 0.275, 0, -2.222, 0, 2.497, 0;
  return parameters;
}

}  // namespace c3rt::plant
