#pragma once
// The robot's named errors: bit i of RobotState.errors is Error i.
#include <array>
#include <cstdint>
#include <string>

namespace c3rt::plant {

enum class Error : int {
  kJointPositionLimitsViolation,       // a joint left its range while commanded
  kJointVelocityViolation,             // a joint was faster than its limit while commanded
  kCommunicationConstraintsViolation,  // too many commands in a row were lost
  kCommandNotFinite,                   // a command held NaN or Inf
  kInstabilityDetected,                // the simulation lost its numbers
};
constexpr int kErrorCount = 5;

using Errors = std::uint64_t;

constexpr Errors bit(Error error) noexcept { return Errors{1} << static_cast<int>(error); }

constexpr std::array<const char*, kErrorCount> kErrorNames{
    "joint_position_limits_violation", "joint_velocity_violation",
    "communication_constraints_violation", "command_not_finite", "instability_detected"};

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

}  // namespace c3rt::plant
