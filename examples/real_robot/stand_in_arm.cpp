#include "examples/real_robot/stand_in_arm.hpp"

namespace c3rt::real_robot {
namespace {

constexpr std::int64_t kCycleNs = 1'000'000;

}  // namespace

StandInArm::StandInArm(const plant::Parameters& parameters)
    : plant_(parameters), clock_(kCycleNs) {}

void StandInArm::cycle(const Vector7d* tau) noexcept {
  clock_.wait();
  if (tau != nullptr) plant_.set_command(*tau, ++commands_, 0);
  plant_.step_1ms();
}

void StandInArm::observe(const Watch& watch) {
  do cycle(nullptr);
  while (watch(plant_.state()));
}

Arm::End StandInArm::control(const Control& control) {
  std::optional<Vector7d> tau = Vector7d::Zero();
  do {
    cycle(&*tau);
    const plant::State& state = plant_.state();
    if (state.mode == plant::Mode::kReflex)
      return {true, state.errors, "stopped: " + plant::names(state.errors)};
    tau = control(state);
  } while (tau);
  // its own controller holds it: the emulated robot does so after a stop, until commands come
  plant_.request_stop();
  cycle(nullptr);
  plant_.request_recovery();
  return {};
}

std::string StandInArm::set_collision_behavior(const plant::CollisionBehavior& behavior) {
  return plant_.set_collision_behavior(behavior) ? "" : "it moves";
}

std::string StandInArm::recover() {
  plant_.request_recovery();
  cycle(nullptr);
  return plant_.state().errors == 0 ? "" : plant::names(plant_.state().errors);
}

}  // namespace c3rt::real_robot
