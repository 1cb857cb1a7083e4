#pragma once
// The invariants' numbers as a scenario has them.
#include "cli/invariants/samples.hpp"
#include "config/scenario.hpp"

namespace c3rt::cli::invariants {

Limits load_limits(const config::Scenario& scenario, bool realtime);

}  // namespace c3rt::cli::invariants
