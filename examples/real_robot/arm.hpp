#pragma once
// The robot behind the door: what has to be written for another one.
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "plant_emulator/plant.hpp"

namespace c3rt::real_robot {

using plant::Vector7d;

/// The connection to the robot is lost, or was never there.
class ArmError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Of a state the door reads q, dq, tau, p_WE, q_WE, mode, errors, external, contacts and
/// command_success_rate (of the link to the robot). mode is the robot's own: kReflex where it has
/// stopped by itself, kUserStopped and kGuiding where a person has it, else anything.
class Arm {
 public:
  /// RT: no heap, no lock, no throw, and an answer within 0.3 ms.
  using Watch = std::function<bool(const plant::State&)>;
  using Control = std::function<std::optional<Vector7d>(const plant::State&)>;

  Arm() = default;
  virtual ~Arm() = default;
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  /// Hands over each of the robot's states, 1000 a second, while the robot's own controller holds
  /// it; until the answer is false. @throws ArmError
  virtual void observe(const Watch& watch) = 0;

  /// How control ended.
  struct End {
    bool by_robot = false;     // it stopped by itself; else the last answer was none
    plant::Errors errors = 0;  // those that have a name in plant_emulator/errors.hpp
    std::string text;          // the robot's own words
  };
  /// The same with a torque for each state [N m], without gravity, until there is none: then the
  /// robot's own controller holds the arm, which is at rest. @throws ArmError
  virtual End control(const Control& control) = 0;

  /// Between two of these loops. @return why the robot does not take them; empty: it has.
  /// @throws ArmError
  virtual std::string set_collision_behavior(const plant::CollisionBehavior& behavior) = 0;

  /// Asks the robot to end its errors. @return why it does not; empty: it has. @throws ArmError
  virtual std::string recover() = 0;
};

}  // namespace c3rt::real_robot
