#include "vision/service.hpp"

#include <optional>
#include <utility>

#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/convert.hpp"

namespace c3rt::vision {
wire::FaultScope fault_scope(const Parameters& parameters) {
  wire::FaultScope scope;
  const bool cameras = parameters.source == SourceKind::kCameras;
  scope.cameras = cameras ? static_cast<int>(parameters.cameras.size()) : 0;
  return scope;
}

Service::Service(wire::Bus& bus, wire::Endpoint& endpoint, const Parameters& parameters,
                 const std::vector<ObjectStart>& objects, double latency,
                 std::unique_ptr<Source> source)
    : endpoint_(endpoint),
      realtime_(bus.clock() == wire::ClockMode::kRealtime),
      latency_ns_(base::nanoseconds(latency)),
      source_(std::move(source)),
      node_(parameters, objects, *source_),
      detections_(bus),
      estimates_(bus),
      exposures_(endpoint.status().counter("exposures")),
      dropped_(endpoint.status().counter("dropped_frames")),
      cameras_used_(endpoint.status().counter("cameras_used")),
      lost_events_(endpoint.status().counter("lost_events")),
      restarts_(endpoint.status().counter("restarts")) {
  // an exposure wakes this process, not the 1 kHz of the robot
  if (parameters.acceleration_filter) states_.emplace(bus, 1, wire::Wakes::kItself);
  endpoint_.say(c3rt_v2_SERVICE_RUNNING, node_.text());
}

void Service::step(std::int64_t now_ns) {
  serve_clients(now_ns);
  wire::RobotState state{};
  while (states_ && states_->take(state))
    node_.see_effector(state.header.time_ns, wire::vector(state.p_WE_m));
  const std::int64_t began_ns = rt::now_ns();
  Node::Output out = node_.step(now_ns);
  if (out.exposure_ns == 0) return;
  write(out);
  tell(out);
  if (realtime_) endpoint_.status().wakeup_latency().add(base::seconds(began_ns - out.exposure_ns));
  endpoint_.status().compute().add(base::seconds(rt::now_ns() - began_ns));
}

void Service::serve_clients(std::int64_t now_ns) {
  endpoint_.serve_requests(now_ns, [](c3rt_v2_RequestVerb) -> std::optional<wire::Answer> {
    return wire::Answer{false, "vision knows only shutdown"};
  });
  endpoint_.serve_faults(now_ns, [this, now_ns](const wire::FaultInject& fault) {
    node_.inject(fault, now_ns);
    return std::string();
  });
}

void Service::write(Node::Output& out) {
  const auto published_ns = [&] {
    return realtime_ ? rt::now_ns() : out.exposure_ns + latency_ns_;
  };
  for (wire::ObjectEstimate& estimate : out.estimates) estimates_.write(estimate, published_ns());
  // after the estimates: nobody waits for these
  for (wire::ObjectDetection& detection : out.detections)
    detections_.write(detection, published_ns());
}

void Service::tell(const Node::Output& out) {
  const Node::Counters& counters = node_.counters();
  exposures_ = counters.exposures;
  dropped_ = counters.dropped_frames;
  cameras_used_ = counters.cameras_used;
  lost_events_ = counters.lost_events;
  restarts_ = counters.restarts;
  endpoint_.say(node_.degraded() ? c3rt_v2_SERVICE_DEGRADED : c3rt_v2_SERVICE_RUNNING,
                node_.text());
  for (const std::string& event : out.events) endpoint_.tell(false, event);
}

std::string Service::summary() const {
  return "exposures=" + std::to_string(exposures_) + " dropped_frames=" + std::to_string(dropped_) +
         " lost_events=" + std::to_string(lost_events_);
}

}  // namespace c3rt::vision
