#include "examples/real_robot/libfranka_arm.hpp"

#include <array>
#include <cmath>
#include <sstream>

#include <franka/exception.h>
#include <franka/lowpass_filter.h>

namespace c3rt::real_robot {
namespace {

constexpr double kSameLength = 1e-3, kSameAxis = 1e-3;  // [m], of a rotation's entries
constexpr double kSameMass = 0.05;                      // [kg]

template <std::size_t n>
Eigen::Matrix<double, static_cast<int>(n), 1> vector(const std::array<double, n>& values) noexcept {
  return Eigen::Map<const Eigen::Matrix<double, static_cast<int>(n), 1>>(values.data());
}

template <std::size_t n>
std::array<double, n> array(const Eigen::Matrix<double, static_cast<int>(n), 1>& values) noexcept {
  std::array<double, n> out{};
  for (std::size_t i = 0; i < n; ++i) out[i] = values[static_cast<Eigen::Index>(i)];
  return out;
}

Eigen::Matrix4d pose(const std::array<double, 16>& columns) noexcept {
  return Eigen::Map<const Eigen::Matrix4d>(columns.data());
}

template <std::size_t n>
std::uint32_t bits(const std::array<double, n>& levels) noexcept {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < n; ++i) bits |= static_cast<std::uint32_t>(levels[i] > 0.0) << i;
  return bits;
}

plant::Mode mode(franka::RobotMode mode) noexcept {
  switch (mode) {
    case franka::RobotMode::kReflex:
      return plant::Mode::kReflex;
    case franka::RobotMode::kUserStopped:
      return plant::Mode::kUserStopped;
    case franka::RobotMode::kGuiding:
      return plant::Mode::kGuiding;
    default:
      return plant::Mode::kIdle;
  }
}

/// Our names are libfranka's. Not for the control loop.
plant::Errors errors(const franka::Errors& franka) {
  std::string text = static_cast<std::string>(franka);
  for (char& letter : text) {
    if (letter != '_' && (letter < 'a' || letter > 'z')) letter = ' ';
  }
  std::istringstream words(text);
  plant::Errors errors = 0;
  for (std::string word; words >> word;) {
    for (int i = 0; i < plant::kErrorCount; ++i) {
      const auto error = static_cast<plant::Error>(i);
      if (word == plant::name(error)) errors |= plant::bit(error);
    }
  }
  return errors;
}

/// RT: no heap, no lock, no throw.
void read(const franka::RobotState& from, plant::State& to) noexcept {
  to.q = vector(from.q);
  to.dq = vector(from.dq);
  to.tau = vector(from.tau_J_d);
  const Eigen::Matrix4d X_WE = pose(from.O_T_EE);
  to.p_WE = X_WE.topRightCorner<3, 1>();
  to.q_WE = Eigen::Quaterniond(Eigen::Matrix3d(X_WE.topLeftCorner<3, 3>())).normalized();
  to.mode = mode(from.robot_mode);
  to.command_success_rate = from.control_command_success_rate;
  // libfranka's are what the robot does to the world
  to.external.tau = -vector(from.tau_ext_hat_filtered);
  to.external.wrench_W = -vector(from.O_F_ext_hat_K);
  to.external.wrench_E = -vector(from.K_F_ext_hat_K);
  to.contacts.joint = bits(from.joint_contact);
  to.contacts.cartesian = bits(from.cartesian_contact);
  to.contacts.joint_collision = bits(from.joint_collision);
  to.contacts.cartesian_collision = bits(from.cartesian_collision);
}

bool has_limits(const plant::Thresholds& t) noexcept {
  return t.contact_torque.allFinite() && t.collision_torque.allFinite() &&
         t.contact_force.allFinite() && t.collision_force.allFinite();
}

}  // namespace

LibfrankaArm::LibfrankaArm(const std::string& address, const config::Robot& robot,
                           const plant::CollisionBehavior& behavior) try
    : robot_(address, franka::RealtimeConfig::kEnforce) {
  if (has_limits(behavior.acceleration) && has_limits(behavior.nominal)) set(behavior);
  require_end_effector(robot.end_effector);
} catch (const franka::Exception& error) {
  throw ArmError(address + ": " + error.what());
}

void LibfrankaArm::set(const plant::CollisionBehavior& behavior) {
  const plant::Thresholds &fast = behavior.acceleration, &steady = behavior.nominal;
  robot_.setCollisionBehavior(array<7>(fast.contact_torque), array<7>(fast.collision_torque),
                              array<7>(steady.contact_torque), array<7>(steady.collision_torque),
                              array<6>(fast.contact_force), array<6>(fast.collision_force),
                              array<6>(steady.contact_force), array<6>(steady.collision_force));
}

void LibfrankaArm::require_end_effector(const config::Robot::EndEffector& expected) {
  const franka::RobotState state = robot_.readOnce();
  Eigen::Matrix4d X_FE = Eigen::Matrix4d::Identity();
  X_FE(2, 3) = expected.sphere_center;
  const Eigen::Matrix4d off = pose(state.F_T_EE) - X_FE;
  if (off.topLeftCorner<3, 3>().cwiseAbs().maxCoeff() > kSameAxis ||
      off.topRightCorner<3, 1>().norm() > kSameLength)
    throw ArmError("F_T_EE: expected the end effector's frame " +
                   std::to_string(expected.sphere_center) +
                   " m along z of the flange and not turned; set it in Desk");
  if (!pose(state.EE_T_K).isIdentity(kSameLength))
    throw ArmError("EE_T_K: expected identity, so that wrenches are those at the end effector");
  if (std::abs(state.m_ee - expected.mass) > kSameMass)
    throw ArmError("m_ee: expected " + std::to_string(expected.mass) + " kg, got " +
                   std::to_string(state.m_ee) + " kg; set it in Desk");
}

void LibfrankaArm::observe(const Watch& watch) try {
  robot_.read([this, &watch](const franka::RobotState& state) {
    const bool stood = state_.mode == plant::Mode::kReflex;
    read(state, state_);
    // what stopped it is read once: here no torque waits for the answer
    const bool stands = state_.mode == plant::Mode::kReflex;
    if (!stands) state_.errors = 0;
    if (stands && !stood) state_.errors = errors(state.current_errors);
    return watch(state_);
  });
} catch (const franka::Exception& error) {
  throw ArmError(error.what());
}

Arm::End LibfrankaArm::control(const Control& control) try {
  robot_.control(
      [this, &control](const franka::RobotState& state, franka::Duration) -> franka::Torques {
        read(state, state_);
        const std::optional<Vector7d> tau = control(state_);
        if (tau) return franka::Torques(array<7>(*tau));
        return franka::MotionFinished(franka::Torques(state.tau_J_d));
      },
      true, franka::kMaxCutoffFrequency);  // its rate limiter beside ours; a filter would be late
  return {};
} catch (const franka::ControlException& error) {
  const plant::Errors found =
      error.log.empty() ? 0 : errors(error.log.back().state.last_motion_errors);
  return {true, found, error.what()};
} catch (const franka::CommandException& error) {
  return {true, 0, error.what()};
} catch (const franka::Exception& error) {
  throw ArmError(error.what());
}

std::string LibfrankaArm::set_collision_behavior(const plant::CollisionBehavior& behavior) try {
  set(behavior);
  return "";
} catch (const franka::CommandException& error) {
  return error.what();
} catch (const franka::Exception& error) {
  throw ArmError(error.what());
}

std::string LibfrankaArm::recover() try {
  robot_.automaticErrorRecovery();
  return "";
} catch (const franka::CommandException& error) {
  return error.what();
} catch (const franka::Exception& error) {
  throw ArmError(error.what());
}

}  // namespace c3rt::real_robot
