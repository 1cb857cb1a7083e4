#include "cli/invariants/load_limits.hpp"

#include <algorithm>

#include "plant_emulator/plant.hpp"

namespace c3rt::cli::invariants {
namespace {

/// What criteria say of every instant; those of shares and sums are judged at the end of a pass.
double object_error(const std::vector<config::Criterion>& criteria) {
  double limit = std::numeric_limits<double>::infinity();
  for (const config::Criterion& criterion : criteria) {
    if (criterion.name == "in_band_2cm" && criterion.min >= 1.0) limit = std::min(limit, 0.02);
    if (criterion.name == "in_band_1cm" && criterion.min >= 1.0) limit = std::min(limit, 0.01);
    if (criterion.name == "path_error_max_m" && criterion.max)
      limit = std::min(limit, *criterion.max);
  }
  return limit;
}

}  // namespace

Limits load_limits(const config::Scenario& scenario, bool realtime) {
  Limits limits;
  limits.tau_max = scenario.plant.limits.tau_max;
  limits.tau_rate_max = scenario.plant.limits.tau_rate_max;
  limits.cycle = plant::kCycle;
  limits.workspace_min = scenario.impedance.limits.workspace_min;
  limits.workspace_max = scenario.impedance.limits.workspace_max;
  limits.object_error = object_error(scenario.criteria);
  limits.realtime = realtime;
  return limits;
}

}  // namespace c3rt::cli::invariants
