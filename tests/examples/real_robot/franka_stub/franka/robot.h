#pragma once
// As much of libfranka as libfranka_arm.cpp names, without a body: it is compiled against this
// where libfranka is not installed, and never linked or run.
#include <array>
#include <cstdint>
#include <functional>
#include <string>

namespace franka {

class Duration {};

struct Errors {
  explicit operator std::string() const;
};

enum class RobotMode { kOther, kIdle, kMove, kGuiding, kReflex, kUserStopped };

struct RobotState {
  std::array<double, 16> O_T_EE, F_T_EE, EE_T_K;
  double m_ee;
  std::array<double, 7> q, dq, tau_J_d, tau_ext_hat_filtered, joint_contact, joint_collision;
  std::array<double, 6> O_F_ext_hat_K, K_F_ext_hat_K, cartesian_contact, cartesian_collision;
  Errors current_errors, last_motion_errors;
  double control_command_success_rate;
  RobotMode robot_mode;
};

struct Torques {
  Torques(const std::array<double, 7>& torques) noexcept;
};
Torques MotionFinished(Torques command) noexcept;

enum class RealtimeConfig { kEnforce, kIgnore };

class Robot {
 public:
  explicit Robot(const std::string& address, RealtimeConfig realtime = RealtimeConfig::kEnforce);
  ~Robot() noexcept;
  void control(std::function<Torques(const RobotState&, Duration)> callback, bool limit_rate,
               double cutoff_frequency);
  void read(std::function<bool(const RobotState&)> callback);
  RobotState readOnce();
  void setCollisionBehavior(const std::array<double, 7>&, const std::array<double, 7>&,
                            const std::array<double, 7>&, const std::array<double, 7>&,
                            const std::array<double, 6>&, const std::array<double, 6>&,
                            const std::array<double, 6>&, const std::array<double, 6>&);
  void automaticErrorRecovery();
};

}  // namespace franka
