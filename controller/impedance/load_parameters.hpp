#pragma once
#include "config/section.hpp"
#include "controller/impedance/parameters.hpp"

namespace c3rt::impedance {

/// Reads the section `impedance:` of a scenario.
/// @throws config::ConfigError naming file, line, key and what is allowed
Parameters load_parameters(config::Section section);

}  // namespace c3rt::impedance
