#pragma once
// The emulated robot in the place of a real one, in real time: to try everything but libfranka.
#include "controller/rt/periodic_clock.hpp"
#include "examples/real_robot/arm.hpp"

namespace c3rt::real_robot {

class StandInArm final : public Arm {
 public:
  /// @throws as plant::Plant
  explicit StandInArm(const plant::Parameters& parameters);
  void observe(const Watch& watch) override;
  End control(const Control& control) override;
  std::string set_collision_behavior(const plant::CollisionBehavior& behavior) override;
  std::string recover() override;

 private:
  void cycle(const Vector7d* tau) noexcept;

  plant::Plant plant_;
  rt::PeriodicClock clock_;
  std::uint64_t commands_ = 0;
};

}  // namespace c3rt::real_robot
