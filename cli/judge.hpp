#pragma once
// What a run of a scenario came to.
#include <cstdint>

#include "cli/recording/samples.hpp"
#include "cli/report/metrics.hpp"
#include "cli/report/report.hpp"
#include "config/scenario.hpp"

namespace c3rt::cli {

/// All figures, with the scenario's criteria and the pushes that its hand gave.
/// @param task the scenario's, with the run's seed
Figures judge(const Series& series, const config::Scenario& scenario, const task::Task& task,
              std::uint64_t seed);

/// The report, but for what the samples do not tell: clock, result, real-time factor.
Report judge(const Samples& samples, const config::Scenario& scenario, std::uint64_t seed);

/// "criteria not met", or that the robot stopped and why.
std::string result_of(const Report& report, bool robot_stopped);

}  // namespace c3rt::cli
