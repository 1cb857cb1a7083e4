#pragma once
// `c3rt doctor`: what runs, what is missing, and what this machine lacks.
#include "cli/client.hpp"

namespace c3rt::cli::doctor {

struct Settings {
  Seat seat;
  bool json = false;
};

/// Prints the findings. @return kDone, kCriterionFailed where there is a problem
int run(const Settings& settings);

}  // namespace c3rt::cli::doctor
