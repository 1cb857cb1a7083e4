#pragma once
#include "config/section.hpp"
#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// Reads the scenario's section `planner`; the task comes from the section `task`.
/// @throws config::ConfigError naming file, line, key and the allowed range
Parameters load_parameters(config::Section section, const Task& task);

}  // namespace c3rt::planner
