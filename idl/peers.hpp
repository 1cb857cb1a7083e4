#pragma once
// Who else is on our topics, and who of them can never be served.
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "idl/dds.hpp"
#include "idl/qos.hpp"

namespace c3rt::wire {

/// One of our own readers or writers.
struct Endpoint {
  const Topic* topic;
  std::int32_t handle;
  bool is_writer;
};

/// Compares what discovery tells of other participants with our own endpoints.
class Peers {
 public:
  explicit Peers(std::int32_t participant);
  std::vector<PeerProblem> problems(const std::vector<Endpoint>& ours);
  /// Whose writer it is: "python3 (pid 12)", with the host where that is another one. From any
  /// thread.
  std::string name_of_writer(std::int32_t reader, std::uint64_t writer) const;
  std::string name_of(const dds_guid_t& participant) const;

 private:
  std::int32_t participant_;
  Entity publications_, subscriptions_, participants_;
  // when a pair of endpoints was first seen compatible but unmatched: matching takes a moment
  std::map<std::pair<std::int32_t, std::uint64_t>, std::int64_t> unmatched_since_ns_;
};

}  // namespace c3rt::wire
