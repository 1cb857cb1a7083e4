#pragma once
// What a run of a scenario came to.
#include <cstdint>

#include "cli/report/metrics.hpp"
#include "config/scenario.hpp"

namespace c3rt::cli {

/// All figures, with the scenario's criteria and the pushes that its hand gave.
/// @param task the scenario's, with the run's seed
Figures judge(const Series& series, const config::Scenario& scenario, const task::Task& task,
              std::uint64_t seed);

}  // namespace c3rt::cli
