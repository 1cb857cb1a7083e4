#pragma once
// What the plant promises on the bus, for a robot that promises part of it: modes, lost commands,
// limits, brake. No bus, no clock, no thread.
#include <optional>

#include "examples/real_robot/arm.hpp"
#include "plant_emulator/node.hpp"

namespace c3rt::real_robot {

/// One cycle: see() what the robot tells, step() with the command that has come, then torque() if
/// it is commanded. RT, all of it but the constructor: no heap, no lock, no throw.
class Door final : public plant::RobotNode {
 public:
  /// @param parameters limits, safety and walls are those of the scenario's robot; recovers_alone
  explicit Door(const plant::Parameters& parameters);

  /// @param commanded the robot takes torque() in this cycle; else its own controller holds it
  void see(const plant::State& arm, bool commanded) noexcept;
  void obey(const plant::Order& order) noexcept override;
  const Output& step(std::int64_t now_ns, const wire::RobotCommand* command,
                     const wire::RobotMotion* motion) noexcept override;
  /// Without gravity, within the limits of torque and of its rate [N m].
  const Vector7d& torque() const noexcept { return torque_; }

  /// The robot has to take torques: commands move it, or the brake has not yet brought it to rest.
  bool wants_control() const noexcept;
  /// Somebody asked to recover, and the robot itself has to be asked: then recovered().
  bool wants_recovery() const noexcept { return recovery_wanted_; }

  /// Thresholds that a client has ordered, which the robot takes between two loops alone; nullptr:
  /// none. Then settled().
  const plant::CollisionBehavior* wanted_behavior() const noexcept {
    return ordered_ ? &ordered_->behavior : nullptr;
  }

  // between two loops of the arm
  /// The robot has stopped by itself.
  void stopped_by_robot(plant::Errors errors) noexcept;
  /// @param worked false: it stays as it is
  void recovered(bool worked) noexcept;
  /// @param worked false: they are as they were
  void settled(bool worked) noexcept;

  const plant::State& state() const noexcept override { return state_; }
  std::string refusal(plant::OrderKind kind) const override;
  std::string refusal_of_motions() const override;
  bool waits_for_commands() const noexcept override;

 private:
  void take(const wire::RobotCommand& command) noexcept;
  void judge() noexcept;
  void enter(plant::ModeState next) noexcept;
  Vector7d brake() noexcept;
  Vector7d limited(const Vector7d& wanted) noexcept;

  plant::Parameters parameters_;
  plant::ModeState mode_{plant::Mode::kIdle, 0};
  plant::Events events_{};
  plant::CommandWatch watch_;
  plant::ContactReport contact_;
  plant::State arm_{}, state_{};  // what the robot tells, what the door does
  bool commanded_ = false;
  bool failed_ = false;  // the robot stopped by itself and has not been recovered
  bool recovery_wanted_ = false;
  std::optional<plant::Order> ordered_;  // thresholds
  int standing_ = 0;                     // cycles in a row
  double drop_until_ = 0.0;
  Vector7d command_ = Vector7d::Zero(), torque_ = Vector7d::Zero();
  Output output_;
};

}  // namespace c3rt::real_robot
