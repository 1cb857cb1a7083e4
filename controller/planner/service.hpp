#pragma once
// The planner's node on a bus: its mailboxes, its clients, its status.
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "controller/planner/adjustable_weights.hpp"
#include "controller/planner/node.hpp"
#include "controller/rt/worker_pool.hpp"
#include "idl/endpoint.hpp"

namespace c3rt::planner {

class Service {
 public:
  /// @param clock of the node; its solves take solve_time in simulated time
  Service(wire::Bus& bus, wire::Endpoint& endpoint, const Parameters& parameters, model::Arm arm,
          double solve_time);

  /// One period: what is in effect at now_ns is taken, and a plan is sent.
  void step(std::int64_t now_ns);
  std::string summary() const;  // for the log
  const Node& node() const noexcept { return node_; }

 private:
  void take(std::int64_t now_ns);
  /// What clients asked for on a topic: each is taken or refused, answered, and told in the log.
  template <typename T, typename Take>
  void take_asked(wire::Reader<T>& reader, const char* what, std::int64_t now_ns, Take&& take);
  wire::Answer take_target(const wire::TaskTarget& sample);
  wire::Answer take_weights(const wire::PlannerWeights& sample);
  void serve_clients(std::int64_t now_ns);
  void tell(double now);

  wire::Endpoint& endpoint_;
  const Parameters parameters_;
  const task::Limits limits_;
  const std::vector<AdjustableWeight> adjustable_;
  NamedWeights weights_;  // that a client has changed
  rt::WorkerPool pool_;
  Node node_;
  wire::Reader<wire::RobotState> states_;
  wire::Reader<wire::RobotCommand> commands_;
  wire::Reader<wire::ObjectEstimate> estimates_;
  wire::Reader<wire::TaskTarget> targets_;
  wire::Reader<wire::PlannerWeights> weighed_;
  wire::Writer<wire::Plan> plans_;
  wire::Writer<wire::PlannerDebug> debug_;
  Node::Input in_;
  wire::FaultWindows faults_;
  Activity told_;
  std::atomic<std::uint64_t>&sent_, &overruns_, &truncated_, &fallbacks_, &object_lost_, &failures_;
  std::string failure_;  // that was told last
};

}  // namespace c3rt::planner
