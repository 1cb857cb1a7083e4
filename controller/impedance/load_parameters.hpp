#pragma once
#include "config/robot.hpp"
#include "config/section.hpp"
#include "controller/impedance/parameters.hpp"

namespace c3rt::impedance {

/// Reads the section `impedance:` of a scenario with this robot.
/// @throws config::ConfigError naming file, line, key and what is allowed
Parameters load_parameters(config::Section section, const config::Robot& robot);

/// What c3rt-impedance needs of a whole scenario; it does not look at the sections of the others.
/// @throws config::ConfigError as load_parameters
Parameters load_from_scenario(config::Section& root);

}  // namespace c3rt::impedance
