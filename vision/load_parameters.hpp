#pragma once
#include "config/section.hpp"
#include "vision/parameters.hpp"

namespace c3rt::vision {

/// Reads the scenario's section `vision`. @throws config::ConfigError
Parameters load_parameters(config::Section section);

}  // namespace c3rt::vision
