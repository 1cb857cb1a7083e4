#pragma once
// `c3rt replay`: a recording for live processes, or for one fresh process whose answers are
// compared with the recorded ones.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/client.hpp"

namespace c3rt::cli::replay {

struct Settings {
  std::string file;
  std::vector<std::string> topics;  // empty: all but requests and faults, and what somebody writes
  double rate = 1.0;                // 0: as fast as it goes
  std::string compare;              // "planner", "vision", "impedance"; empty: for live processes
  // of a comparison
  std::string scenario;  // empty: that of the recording
  std::vector<std::string> overrides;
  std::optional<std::uint64_t> seed;  // none: that of the recording
};

/// @return kCriterionFailed where answers differ, or where it was interrupted or somebody else
/// began to write a topic
/// @throws UsageError for a file that is no recording or has nothing of the kind, a topic that has
/// a live writer, a bus that refuses a client's samples
int run(const Seat& seat, const Settings& settings);

}  // namespace c3rt::cli::replay
