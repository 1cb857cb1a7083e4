#pragma once
// The robot of the shipped scenarios, from its description.
#include "config/robot.hpp"
#include "controller/model/load_parameters.hpp"

namespace c3rt::test {

inline model::ArmDescription panda_arm() { return model::load_arm(config::load_robot("panda")); }

}  // namespace c3rt::test
