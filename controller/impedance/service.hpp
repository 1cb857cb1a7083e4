#pragma once
// What c3rt-impedance does beside its cycle: requests, injected faults, status.
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "controller/impedance/servo.hpp"
#include "idl/process.hpp"
#include "idl/replies.hpp"

namespace c3rt::impedance {

/// One sentence for a person about what the servo does and why.
std::string describe(const Snapshot& snapshot);

/// For one thread that is not the servo's; in lockstep there is only one thread, and it polls after
/// each cycle.
class Service {
 public:
  Service(wire::Bus& bus, Servo& servo, wire::StatusReporter& status);

  /// Obeys new requests and faults, answers requests that the servo has seen, and updates the
  /// status.
  /// @return true if what there is to say has changed (see text())
  bool poll();
  const std::string& text() const { return text_; }
  void count_missed_cycles(std::uint64_t count) { missed_cycles_ = count; }
  /// Sleeps until a request arrives or the time is over.
  void wait(std::int64_t timeout_ns) { requests_.wait(timeout_ns); }

 private:
  struct Pending {
    wire::ServiceRequest request;
    std::uint64_t cycle;  // the servo's newest when the request was taken
  };
  void take_requests();
  void take_faults();
  void answer_requests();
  bool answered(const Pending& pending);
  void update_counters();

  Servo& servo_;
  wire::StatusReporter& status_;
  wire::Reader<wire::ServiceRequest> requests_;
  wire::Reader<wire::FaultInject> faults_;
  wire::Replies replies_;
  std::vector<Pending> pending_;
  Snapshot snapshot_;
  std::string text_;

  std::atomic<std::uint64_t>&missed_cycles_, &stale_plan_events_, &plans_other_session_,
      &plans_invalid_, &workspace_clamps_, &plan_clamps_, &torque_clamps_, &torque_rate_clamps_,
      &stops_, &states_lost_, &plans_lost_, &commands_failed_, &state_to_command_p50_,
      &state_to_command_p95_, &state_to_command_p99_;
};

}  // namespace c3rt::impedance
