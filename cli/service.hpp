#pragma once
// `c3rt up`, `down`, `status`: the processes as a long-lived service.
#include <string>
#include <vector>

#include "cli/client.hpp"
#include "cli/launch.hpp"

namespace c3rt::cli {

/// Detaches a supervisor with these arguments of `c3rt serve` and waits until every process runs.
int up(const LaunchSettings& settings, const std::vector<std::string>& serve_arguments);

/// The supervisor itself: until SIGTERM or until a process fails.
int serve(const LaunchSettings& settings);

/// Ends the instance on this domain and waits for its end.
int down(const Seat& seat);

/// Prints what runs and how it is.
int status(const Seat& seat);

}  // namespace c3rt::cli
