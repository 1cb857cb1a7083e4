#pragma once
// The command line that the four processes share.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace c3rt::config {

/// How a process ends. A supervisor reads it; c3rt's own exit status is another matter.
constexpr int kStopped = 0;             // by a signal or a request
constexpr int kFailedWhileRunning = 1;  // a sentence on stderr or in the log says why
constexpr int kCouldNotStart = 2;       // usage, scenario, model or bus; a sentence on stderr

enum class Clock { kRealtime, kLockstep };

struct ProcessOptions {
  std::string scenario_path;
  std::vector<std::string> overrides;  // "planner.rate_hz=75"
  Clock clock = Clock::kRealtime;
  std::uint64_t seed = 1;
  std::uint64_t session = 0;  // 0: the plant draws one, the others adopt it
  std::uint32_t domain = 0;
  std::string dds_profile;  // empty: the environment's CYCLONEDDS_URI
  std::vector<std::string>
      expect;  // plant, lockstep: the processes that must join before time starts
};

/// @return nothing when the call is already answered (--help, or a usage error); exit_status says
/// how to exit.
std::optional<ProcessOptions> parse_process_options(int argc, char** argv, const std::string& name,
                                                    const std::string& description,
                                                    int& exit_status);

}  // namespace c3rt::config
