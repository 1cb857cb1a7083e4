#pragma once
// The plant's state as samples.
#include "idl/topics.hpp"
#include "plant_emulator/plant.hpp"

namespace c3rt::plant {

/// RT: no heap, no throw.
wire::RobotState robot_state(const State& state) noexcept;
/// RT: no heap, no throw.
wire::Scene scene(const State& state, bool exposure) noexcept;

}  // namespace c3rt::plant
