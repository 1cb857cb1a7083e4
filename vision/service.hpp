#pragma once
// Vision's node on a bus: its mailboxes, its clients, its status.
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "idl/endpoint.hpp"
#include "vision/node.hpp"

namespace c3rt::vision {

/// What a fault of vision can be about.
wire::FaultScope fault_scope(const Parameters& parameters);

class Service {
 public:
  /// @param source where images come from: the plant's scene (make_scene_source), or a camera of
  /// its own, which reads nothing of the bus and wakes it for each frame (Bus::wake)
  /// @param latency exposure to estimate, in simulated time [s]
  Service(wire::Bus& bus, wire::Endpoint& endpoint, const Parameters& parameters,
          const std::vector<ObjectStart>& objects, double latency, std::unique_ptr<Source> source);

  /// Works on the newest exposure that has come, if there is one.
  void step(std::int64_t now_ns);
  std::string summary() const;  // for the log

 private:
  void serve_clients(std::int64_t now_ns);
  void write(Node::Output& out);
  void tell(const Node::Output& out);

  wire::Endpoint& endpoint_;
  const bool realtime_;
  const std::int64_t latency_ns_;
  const std::unique_ptr<Source> source_;
  Node node_;
  std::optional<wire::Reader<wire::RobotState>> states_;  // where the node wants them
  wire::Writer<wire::ObjectDetection> detections_;
  wire::Writer<wire::ObjectEstimate> estimates_;
  std::atomic<std::uint64_t>&exposures_, &dropped_, &cameras_used_, &lost_events_, &restarts_;
};

}  // namespace c3rt::vision
