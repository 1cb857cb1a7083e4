#pragma once
// What the plant needs to know; the numbers stand in the scenario.
#include <vector>

#include <Eigen/Core>

#include "plant_emulator/pushes.hpp"
#include "plant_emulator/scene.hpp"

namespace c3rt::plant {

using Vector7d = Eigen::Matrix<double, kJoints, 1>;

/// What the robot enforces, whoever commands it.
struct JointLimits {
  Vector7d q_min, q_max;  // [rad]
  Vector7d dq_max;        // [rad/s]
  Vector7d tau_max;       // [N m]
  double tau_rate_max;    // [N m/s]
};

struct Parameters {
  World world;
  JointLimits limits;
  Vector7d initial_q;     // [rad]
  PushParameters pushes;  // of a hand; none if count is 0
  // from a reflex that lost commands alone have brought about, once they come steadily again
  bool recovers_alone = false;
};

}  // namespace c3rt::plant
