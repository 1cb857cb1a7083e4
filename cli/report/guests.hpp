#pragma once
// What a client did that played one of the processes (c3rt run --without): its stream as the
// recorder saw it.
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/report/metrics.hpp"
#include "cli/report/series.hpp"

namespace c3rt::cli {

/// What is asked of a stream.
struct GuestLimits {
  double longest_gap = 0.0;  // without a sample [s]
  std::string gap_key;       // the scenario's key of it
};

/// What readers of the stream refused.
struct GuestRefusals {
  std::string reader;  // "impedance", "the recorder"
  std::uint64_t count = 0;
  std::string reason, latest;
};

struct Guest {
  std::string process;  // "planner"
  std::string topic;    // that it writes
  std::uint64_t samples = 0;
  double rate = kNone;                // mean while it spoke, of the slowest object [Hz]
  Spread age;                         // of what a sample was made from, when it takes effect [s]
  std::vector<std::string> problems;  // a sentence each: gaps, lateness, stamps, refusals
};

/// @param process planner, vision or impedance
Guest look_at_guest(const std::string& process, const Series& series, const GuestLimits& limits,
                    const std::vector<GuestRefusals>& refused);

nlohmann::ordered_json to_json(const Guest& guest);

}  // namespace c3rt::cli
