#pragma once
#include "config/robot.hpp"
#include "config/section.hpp"
#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

EndEffector end_effector_of(const config::Robot& robot);
JointLimits limits_of(const config::Robot& robot);
Safety safety_of(const config::Robot& robot);

/// Reads the section `plant` of a scenario with this robot. @throws config::ConfigError
Parameters load_parameters(config::Section section, const config::Robot& robot);

}  // namespace c3rt::plant
