#pragma once
// `c3rt chaos`: faults drawn from a seed, every invariant looked at on every sample, and how long
// the task takes to go on after each.
#include <cstdint>
#include <string>

#include "cli/exit_status.hpp"
#include "cli/launch.hpp"

namespace c3rt::cli::chaos {

struct Settings {
  LaunchSettings launch;
  std::string faults;       // "kill,stop:planner"; empty: every kind that is offered
  double rate = 6.0;        // faults in a minute of the time between them
  double duration = 600.0;  // of the session's clock [s]
};

/// In simulated time a pass of kPass begins anew with the next seed, which is that of its faults,
/// too; in realtime the same service goes on.
/// @return an exit status: 1 where something was violated, or a person ended it
/// @throws UsageError, config::ConfigError, wire::ProfileError
int run(const Settings& settings);

}  // namespace c3rt::cli::chaos
