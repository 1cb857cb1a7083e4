#pragma once
// One run of a process of one's own: its bus, clock, status and requests.
#include <atomic>
#include <optional>
#include <string>

#include "idl/client/process.hpp"
#include "idl/endpoint.hpp"

namespace c3rt::client {

class Process::Part {
 public:
  /// When its cycles are due.
  struct Pace {
    double rate;              // [Hz]
    bool by_arrival = false;  // realtime: whatever arrives, in place of the rate
  };

  Part(wire::Process process, const Place& place, const Pace& pace);
  virtual ~Part() = default;
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  void run();
  void say(c3rt_v2_ServiceState state, const std::string& text) { endpoint_.say(state, text); }
  bool began() const noexcept { return began_; }

  static constexpr int kQueue = 64;  // of its readers

 protected:
  bool lockstep() const noexcept { return place_.clock == wire::ClockMode::kLockstep; }
  wire::Bus& bus() noexcept { return bus_; }
  wire::Endpoint& endpoint() noexcept { return endpoint_; }
  void begin() noexcept { began_ = true; }

  /// One cycle.
  virtual void step(std::int64_t now_ns) = 0;
  /// Requests, in each cycle and before the first.
  virtual void serve(std::int64_t now_ns);
  /// What is done about a request; shutdown is none of these.
  virtual wire::Answer obey(c3rt_v2_RequestVerb verb) = 0;

 private:
  /// Until the plant's clock is known. @return false after a stop
  bool await_place();
  void require_nobody_else();
  bool wait(std::int64_t& now_ns);

  const wire::Process process_;
  const Place place_;
  const Pace pace_;
  wire::Bus bus_;
  wire::Endpoint endpoint_;
  wire::Reader<wire::ServiceStatus> statuses_{bus_, kQueue};
  // looked at, never taken from: who writes ticks is in lockstep
  wire::Reader<wire::Tick> ticks_;
  std::atomic<std::uint64_t>& overruns_ = endpoint_.status().counter("overruns");
  std::optional<wire::Loop> loop_;
  bool plant_heard_ = false;  // in service
  bool in_service_ = false;   // this one
  bool began_ = false;
};

}  // namespace c3rt::client
