#pragma once
// The robot's named errors: bit i of RobotState.errors is Error i. The names are libfranka's, but
// for command_not_finite, which is ours. docs/reliability.md says which of libfranka's 41 are
// missing, and why.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>

namespace c3rt::plant {

enum class Error : int {
  kJointPositionLimitsViolation,       // a joint left its range while commanded
  kJointVelocityViolation,             // a joint was faster than its limit while commanded
  kCommunicationConstraintsViolation,  // too many commands in a row were lost
  kCommandNotFinite,                   // a command held NaN or Inf
  kInstabilityDetected,                // the simulation lost its numbers
  kCartesianPositionLimitsViolation,   // the end effector left the virtual walls
  kSelfCollisionAvoidanceViolation,    // the wrist came too near to base or shoulder
  kCartesianVelocityViolation,         // the end effector was faster than its limit
  kJointReflex,                        // a joint felt more torque than a collision's
  kCartesianReflex,                    // the end effector felt more force than a collision's
  kControllerTorqueDiscontinuity,      // commanded torque jumped, where that is an error
  kPowerLimitViolation,                // the joints gave more power than they may
  kTauJRangeViolation,                 // a torque sensor was out of its range
  kJointMoveInWrongDirection,          // a person guided a joint farther out of its range
  // what a motion generator commanded, of the joints
  kJointPositionMotionGeneratorStartPoseInvalid,  // it begins away from the arm
  kJointMotionGeneratorPositionLimitsViolation,   // out of the joint's range
  kJointMotionGeneratorVelocityLimitsViolation,
  kJointMotionGeneratorVelocityDiscontinuity,      // more acceleration than a joint has
  kJointMotionGeneratorAccelerationDiscontinuity,  // more jerk
  // of the end effector
  kCartesianPositionMotionGeneratorStartPoseInvalid,
  kCartesianPositionMotionGeneratorInvalidFrame,  // no rotation
  kCartesianMotionGeneratorVelocityLimitsViolation,
  kCartesianMotionGeneratorVelocityDiscontinuity,
  kCartesianMotionGeneratorAccelerationDiscontinuity,
  kCartesianMotionGeneratorElbowLimitViolation,
  kCartesianMotionGeneratorElbowSignInconsistent,
  kCartesianMotionGeneratorStartElbowInvalid,
  // of the joints that this would take
  kCartesianMotionGeneratorJointPositionLimitsViolation,
  kCartesianMotionGeneratorJointVelocityLimitsViolation,
  kCartesianMotionGeneratorJointVelocityDiscontinuity,
  kCartesianMotionGeneratorJointAccelerationDiscontinuity,
};
constexpr int kErrorCount = 31;

using Errors = std::uint64_t;

constexpr Errors bit(Error error) noexcept { return Errors{1} << static_cast<int>(error); }

constexpr std::array<const char*, kErrorCount> kErrorNames{
    "joint_position_limits_violation",
    "joint_velocity_violation",
    "communication_constraints_violation",
    "command_not_finite",
    "instability_detected",
    "cartesian_position_limits_violation",
    "self_collision_avoidance_violation",
    "cartesian_velocity_violation",
    "joint_reflex",
    "cartesian_reflex",
    "controller_torque_discontinuity",
    "power_limit_violation",
    "tau_j_range_violation",
    "joint_move_in_wrong_direction",
    "joint_position_motion_generator_start_pose_invalid",
    "joint_motion_generator_position_limits_violation",
    "joint_motion_generator_velocity_limits_violation",
    "joint_motion_generator_velocity_discontinuity",
    "joint_motion_generator_acceleration_discontinuity",
    "cartesian_position_motion_generator_start_pose_invalid",
    "cartesian_position_motion_generator_invalid_frame",
    "cartesian_motion_generator_velocity_limits_violation",
    "cartesian_motion_generator_velocity_discontinuity",
    "cartesian_motion_generator_acceleration_discontinuity",
    "cartesian_motion_generator_elbow_limit_violation",
    "cartesian_motion_generator_elbow_sign_inconsistent",
    "cartesian_motion_generator_start_elbow_invalid",
    "cartesian_motion_generator_joint_position_limits_violation",
    "cartesian_motion_generator_joint_velocity_limits_violation",
    "cartesian_motion_generator_joint_velocity_discontinuity",
    "cartesian_motion_generator_joint_acceleration_discontinuity"};

constexpr const char* name(Error error) noexcept {
  return kErrorNames[static_cast<std::size_t>(error)];
}

/// "joint_velocity_violation, command_not_finite"; empty for no errors.
inline std::string names(Errors errors) {
  std::string text;
  for (std::size_t i = 0; i < kErrorNames.size(); ++i) {
    if ((errors >> i & 1U) != 0) text += (text.empty() ? "" : ", ") + std::string(kErrorNames[i]);
  }
  return text;
}

/// What an error is about: the first one that was found.
struct Cause {
  Error error{};
  int axis = 0;           // joint 1 to 7, or x, y, z, roll, pitch, yaw as 1 to 6; 0: of none
  double value = 0.0;     // measured or commanded, in the unit of the limit
  double limit = 0.0;     // that it passed
  const char* unit = "";  // empty: there is no cause
};

/// Of the end effector, or of W.
constexpr std::array<const char*, 6> kAxisNames{"x", "y", "z", "roll", "pitch", "yaw"};

/// "joint 7: 2.64 rad/s, limit 2.61"; empty without a cause.
inline std::string text(const Cause& cause) {
  if (*cause.unit == '\0') return "";
  const bool cartesian = cause.error == Error::kCartesianReflex ||
                         cause.error == Error::kCartesianPositionLimitsViolation;
  std::string of;
  if (cause.axis > 0 && !cartesian) of = "joint " + std::to_string(cause.axis) + ": ";
  if (cause.axis > 0 && cause.axis <= 6 && cartesian)
    of = std::string(kAxisNames[static_cast<std::size_t>(cause.axis) - 1]) + ": ";
  std::array<char, 96> numbers{};
  std::snprintf(numbers.data(), numbers.size(), "%.4g %s, limit %.4g", cause.value, cause.unit,
                cause.limit);
  return of + numbers.data();
}

/// What one cycle has brought to light.
struct Findings {
  Errors errors = 0;
  Cause first;

  void add(const Cause& cause) noexcept {
    if (errors == 0) first = cause;
    errors |= bit(cause.error);
  }
};

}  // namespace c3rt::plant
