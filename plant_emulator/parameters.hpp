#pragma once
// What the plant needs to know; the numbers stand in the scenario.
#include <vector>

#include <Eigen/Core>

#include "plant_emulator/pushes.hpp"
#include "plant_emulator/scene.hpp"

namespace c3rt::plant {

using Vector7d = Eigen::Matrix<double, kJoints, 1>;

struct Parameters {
  World world;
  Vector7d initial_q;     // [rad]
  PushParameters pushes;  // of a hand; none if count is 0
  // from a reflex that lost commands alone have brought about, once they come steadily again
  bool recovers_alone = false;
};

}  // namespace c3rt::plant
