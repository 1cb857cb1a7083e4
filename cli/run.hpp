#pragma once
// `c3rt run`: one run from start to report.
#include "cli/exit_status.hpp"
#include "cli/launch.hpp"

namespace c3rt::cli {

/// @return an exit status
int run(const LaunchSettings& settings);

}  // namespace c3rt::cli
