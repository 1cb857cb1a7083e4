#pragma once
// Processes that are left out at start (--without) and played by a client.
#include <set>
#include <string>
#include <vector>

#include "cli/launch.hpp"
#include "cli/recorder.hpp"
#include "cli/report/guests.hpp"
#include "cli/supervisor.hpp"

namespace c3rt::cli {

/// Process ids of those who say on the bus that they are one of these processes.
/// @param seconds how long it listens
std::set<int> guests_on(wire::Bus& bus, const std::vector<std::string>& names, double seconds);

/// Waits until a client says of each process that was left out that it is in service.
/// @return false if a person ended the waiting
/// @throws ProcessFailure where one of our own processes ends, or nobody has come for a minute
bool await_guests(const Launch& launch, Supervisor& supervisor);

/// "planner: yours, on domain 0, profile loopback"
std::string guests_text(const Launch& launch);

/// What each of them did in the run that was recorded.
std::vector<Guest> look_at_guests(const Launch& launch, const Series& series, const Live& live);

}  // namespace c3rt::cli
