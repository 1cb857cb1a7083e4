#pragma once
// `c3rt soak`: the task again and again, with every invariant looked at on every sample.
#include <cstdint>

#include "cli/exit_status.hpp"
#include "cli/launch.hpp"

namespace c3rt::cli::soak {

struct Settings {
  LaunchSettings launch;
  double duration = 600.0;   // of the session's clock [s]
  std::uint64_t passes = 0;  // ends after so many; 0: the duration alone
};

/// In simulated time each pass begins anew, with the next seed; in realtime the same processes go
/// on over all of them, and the task begins anew.
/// @return an exit status: 1 where something was violated, or a person ended it
/// @throws UsageError, config::ConfigError, wire::ProfileError
int run(const Settings& settings);

}  // namespace c3rt::cli::soak
