#pragma once
// A real Panda or FR3 by libfranka. Compiled with -DWITH_LIBFRANKA=ON alone.
#include <string>

#include <franka/robot.h>

#include "config/robot.hpp"
#include "examples/real_robot/arm.hpp"

namespace c3rt::real_robot {

class LibfrankaArm final : public Arm {
 public:
  /// Sets the collision thresholds of the scenario's robot, where it has some.
  /// @throws ArmError where nobody answers, or the end effector that is set in Desk is another one
  /// than that of the robot's description
  LibfrankaArm(const std::string& address, const config::Robot& robot,
               const plant::CollisionBehavior& behavior);
  void observe(const Watch& watch) override;
  End control(const Control& control) override;
  std::string set_collision_behavior(const plant::CollisionBehavior& behavior) override;
  std::string recover() override;

 private:
  void set(const plant::CollisionBehavior& behavior);
  void require_end_effector(const config::Robot::EndEffector& expected);

  franka::Robot robot_;
  plant::State state_{};
};

}  // namespace c3rt::real_robot
