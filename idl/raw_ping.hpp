#pragma once
// Cyclone DDS with nothing of ours around it, as ddsperf's ping: the measure for what our layer
// costs.
#include <cstdint>
#include <memory>

#include "idl/dds.hpp"

namespace c3rt::wire {

/// Both topics, as permissions of a secure bus name them.
constexpr const char* kPingTopics = "latency/*";

/// Answers each sample of RawPing on another process's bus, from DDS's own thread.
class RawEcho {
 public:
  /// @throws WireError
  explicit RawEcho(Bus& bus);
  ~RawEcho();
  RawEcho(const RawEcho&) = delete;
  RawEcho& operator=(const RawEcho&) = delete;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// A sample of robot/state's type there and one of robot/command's back, on topics of their own,
/// best effort, keep last 1, checked by nobody.
class RawPing {
 public:
  /// @throws WireError
  explicit RawPing(Bus& bus);
  ~RawPing();
  RawPing(const RawPing&) = delete;
  RawPing& operator=(const RawPing&) = delete;

  /// From the write to the arrival of its answer in DDS's thread [ns]; -1 where none came in time.
  std::int64_t round_trip_ns(std::int64_t timeout_ns) noexcept;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace c3rt::wire
