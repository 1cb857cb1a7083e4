#pragma once
#include "config/section.hpp"
#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

/// Reads the scenario's section `plant`. @throws config::ConfigError
Parameters load_parameters(config::Section section);

}  // namespace c3rt::plant
