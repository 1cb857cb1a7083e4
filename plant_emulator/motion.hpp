#pragma once
// Motion generators: clients that say where the arm shall be in each cycle, as libfranka's
// JointPositions, JointVelocities, CartesianPose and CartesianVelocities. What they command is held
// against the limits that Franka publishes for commanded values, and the robot's own controller
// follows it. Pure functions.
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "plant_emulator/errors.hpp"
#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

enum class MotionKind { kJointPosition, kJointVelocity, kCartesianPose, kCartesianVelocity };

/// Where the redundant arm has its elbow: libfranka's elbow_c.
struct Elbow {
  double q3;    // of joint 3 [rad]
  double sign;  // of joint 4: -1 or 1
};

/// What shall be at the end of the next cycle; of the values those of its kind count.
struct MotionCommand {
  MotionKind kind = MotionKind::kJointPosition;
  Vector7d joints = Vector7d::Zero();              // [rad], of velocities [rad/s]
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector4d q_WE{1.0, 0.0, 0.0, 0.0};        // w x y z as it came: its norm is judged
  Vector6d V_WE = Vector6d::Zero();                // linear, angular, in W [m/s, rad/s]
  std::optional<Elbow> elbow;                      // of the Cartesian kinds; none: as it comes
  bool last = false;                               // the arm stops, and is idle again
};

/// Every value is a number.
bool is_finite(const MotionCommand& command) noexcept;

/// The end effector at some joint positions.
struct Reach {
  Eigen::Vector3d p_WE;  // [m]
  Eigen::Quaterniond q_WE;
  Eigen::Matrix<double, 6, kJoints> J_WE;  // linear rows first, in W
};

class Kinematics {
 public:
  Kinematics() = default;
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;
  virtual ~Kinematics() = default;
  /// RT: no heap, no lock, no throw.
  virtual Reach at(const Vector7d& q) noexcept = 0;
};

/// Makes joint positions of one client's commands, one cycle after the other. A command that does
/// not come is extrapolated with constant acceleration, as FCI does. RT: no heap, no lock, no
/// throw.
class MotionGenerator {
 public:
  /// From here, at rest.
  void begin(MotionKind kind, const Vector7d& q, Kinematics& kinematics) noexcept;
  /// One cycle. @param command nullptr: it was lost
  void step(const MotionCommand* command, const Parameters& parameters, Kinematics& kinematics,
            Findings& findings) noexcept;

  MotionKind kind() const noexcept { return kind_; }
  // what the arm shall do
  const Vector7d& q() const noexcept { return q_; }      // [rad]
  const Vector7d& dq() const noexcept { return dq_; }    // [rad/s]
  const Vector7d& ddq() const noexcept { return ddq_; }  // [rad/s²]

 private:
  struct JointErrors {
    Error position, velocity, velocity_step, acceleration_step;
  };
  void step_joints(const MotionCommand* command, const Parameters& parameters,
                   Findings& findings) noexcept;
  void step_pose(const MotionCommand* command, const Parameters& parameters, Kinematics& kinematics,
                 Findings& findings) noexcept;
  void judge_elbow(const MotionCommand& command, const Parameters& parameters,
                   Findings& findings) noexcept;
  void move_joints(const Vector7d& q, const JointErrors& errors, const Parameters& parameters,
                   Findings& findings) noexcept;
  void move_pose(const Eigen::Vector3d& p_WE, const Eigen::Quaterniond& q_WE,
                 const Parameters& parameters, Findings& findings) noexcept;
  Vector7d joints_of_pose(Kinematics& kinematics) const noexcept;

  MotionKind kind_ = MotionKind::kJointPosition;
  bool first_ = true;
  Vector7d q_ = Vector7d::Zero(), dq_ = Vector7d::Zero(), ddq_ = Vector7d::Zero();
  Eigen::Vector3d p_WE_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WE_ = Eigen::Quaterniond::Identity();
  Vector6d V_WE_ = Vector6d::Zero(), A_WE_ = Vector6d::Zero();  // and its change [m/s², rad/s²]
  std::optional<Elbow> elbow_;
};

}  // namespace c3rt::plant
