#pragma once
// A first look at a recording: how long it is, and what processes were asked for.
#include <cstdint>
#include <filesystem>
#include <map>
#include <variant>
#include <vector>

#include "cli/recording/recording.hpp"

namespace c3rt::cli::replay {

/// What a client asked for.
struct Asked {
  std::int64_t place_ns = 0;  // of what stands before it in the file
  std::variant<wire::TaskTarget, wire::ServiceRequest, wire::FaultInject, wire::RobotOrder,
               wire::PlannerWeights>
      sample;

  std::uint64_t request_id() const;
  wire::Process process() const;  // that is asked
};

struct Overview {
  Contents contents;
  std::int64_t begin_ns = 0, end_ns = 0;  // first and last time of what keeps time
  std::uint64_t session = 0;              // the first
  std::uint64_t of_other_sessions = 0;    // samples
  std::uint64_t first_state = 0;          // its sequence number; 1: the run's own first one
  std::vector<Asked> asked;               // in the order of the file
  std::map<std::uint64_t, std::int64_t> answered_ns;  // by request_id

  double duration() const { return 1e-9 * static_cast<double>(end_ns - begin_ns); }  // [s]
};

/// @throws mcap::Error if it is no recording, UsageError if nothing in it keeps time
Overview look_over(const std::filesystem::path& file);

}  // namespace c3rt::cli::replay
