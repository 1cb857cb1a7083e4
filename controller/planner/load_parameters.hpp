#pragma once
#include "config/section.hpp"
#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// Reads the scenario's section `planner`; the task comes from the section `task`,
/// the number of bodies from `plant`. One body and several have contacts and weights of their own.
/// @throws config::ConfigError naming file, line, key and the allowed range
Parameters load_parameters(config::Section section, const task::Task& task, int bodies);

}  // namespace c3rt::planner
