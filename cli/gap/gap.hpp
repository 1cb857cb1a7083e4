#pragma once
// `c3rt gap`: how far plans of C3 are from the optimum of the whole problem (15).
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/progress.hpp"

namespace c3rt::cli::gap {

struct Settings {
  // a problem file, a numerical example's name or file, or a recording
  std::string what;
  std::vector<std::string> overrides;  // of the example or the recording's scenario: "c3.rho=0.5"
  // of an example or a recording: scenarios whose planners answer for the same states, too
  std::vector<std::string> planners;
  std::optional<int> polish;   // c3.polish in place of what scenario or problem say
  std::uint64_t seed = 1;      // of the example
  int states = 40;             // control steps of it, or plans of the recording
  double limit_s = 60.0;       // for each exact search
  double relative_gap = 1e-3;  // that counts as the optimum
  bool first_input = false;    // also where a plan's first input is kept and no more
  std::string out;             // folder; empty: out/gap-NAME
};

/// Prints a table and writes gap.json and gap.png.
/// @return kDone where every optimum is proven, kUndecided where a search was ended by its limit
/// (the figures are then at most what is said), kCriterionFailed where it was interrupted or there
/// is no plan at all
/// @throws UsageError, config::ConfigError before any search
int run(const Settings& settings, const Stop& stop);

}  // namespace c3rt::cli::gap
