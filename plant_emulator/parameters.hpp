#pragma once
// What the plant needs to know; the numbers stand in the scenario and in the robot's description.
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "plant_emulator/pushes.hpp"
#include "plant_emulator/scene.hpp"

namespace c3rt::plant {

constexpr double kCycle = 1e-3;  // of the robot [s]

using Vector7d = Eigen::Matrix<double, kJoints, 1>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// What the robot enforces, whoever commands it.
struct JointLimits {
  Vector7d q_min, q_max;  // [rad]
  Vector7d dq_max;        // [rad/s]
  Vector7d tau_max;       // [N m]
  double tau_rate_max;    // [N m/s]
};

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// From which torque or force on a contact is told, and from which on a collision stops the robot.
struct Thresholds {
  Vector7d contact_torque = Vector7d::Constant(kNoLimit);    // of each joint [N m]
  Vector7d collision_torque = Vector7d::Constant(kNoLimit);  // [N m]
  // along and about the axes of the end effector
  Vector6d contact_force = Vector6d::Constant(kNoLimit);    // [N, N m]
  Vector6d collision_force = Vector6d::Constant(kNoLimit);  // [N, N m]
};

/// libfranka's setCollisionBehavior: while the arm accelerates, and else.
struct CollisionBehavior {
  Thresholds acceleration, nominal;
};

/// Along and about which axes of W a person's hand leads the arm: libfranka's setGuidingMode.
struct GuidingAxes {
  std::uint32_t free = 63;  // bits x, y, z, roll, pitch, yaw
  bool elbow = true;        // joint 3
};

/// What a motion generator may command, beside the limits of position and velocity.
struct MotionLimits {
  Vector7d joint_acceleration = Vector7d::Constant(kNoLimit);  // [rad/s²]
  Vector7d joint_jerk = Vector7d::Constant(kNoLimit);          // [rad/s³]
  double acceleration = kNoLimit;                              // of the end effector [m/s²]
  double angular_acceleration = kNoLimit;                      // [rad/s²]
  double jerk = kNoLimit;                                      // [m/s³]
  double angular_jerk = kNoLimit;                              // [rad/s³]
};

/// Limits of the end effector, of the whole arm and of contact; without a number there is none.
struct Safety {
  double velocity_max = kNoLimit;                          // of the end effector [m/s]
  double angular_velocity_max = kNoLimit;                  // [rad/s]
  double power_max = kNoLimit;                             // mechanical, of all joints together [W]
  Vector7d tau_sensor_max = Vector7d::Constant(kNoLimit);  // gravity included [N m]
  double clearance_min = -kNoLimit;  // between forearm or wrist and base or shoulder [m]
  CollisionBehavior collision;
  MotionLimits motion;
};

/// The end effector shall stay within; ours are boxes.
struct VirtualWalls {
  Eigen::Vector3d min, max;  // in W [m]
};

struct Parameters {
  World world;
  JointLimits limits;
  Safety safety;
  Vector7d initial_q;     // [rad]
  PushParameters pushes;  // of a hand; none if count is 0
  std::optional<VirtualWalls> walls;
  // a jump of the commanded torque stops the robot, as FCI does; else it is cut to the rate limit
  bool torque_jump_stops = false;
  // from a reflex that lost commands alone have brought about, once they come steadily again
  bool recovers_alone = false;
};

}  // namespace c3rt::plant
