#pragma once
// What c3rt-impedance does beside its cycle: requests, injected faults, status.
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "controller/impedance/servo.hpp"
#include "idl/endpoint.hpp"

namespace c3rt::impedance {

/// One sentence for a person about what the servo does and why.
std::string describe(const Snapshot& snapshot);

/// For one thread that is not the servo's; in lockstep there is only one thread, and it polls after
/// each cycle.
class Service {
 public:
  Service(Servo& servo, wire::Endpoint& endpoint);

  /// Obeys new requests and faults, answers requests that the servo has seen, and updates the
  /// status.
  /// @return true if what there is to say has changed (see text())
  bool poll(std::int64_t now_ns);
  const std::string& text() const { return text_; }
  void count_missed_cycles(std::uint64_t count) { missed_cycles_ = count; }

 private:
  std::optional<wire::Answer> stopped(bool late) const;
  std::optional<wire::Answer> recovered(bool late) const;
  void update_counters();

  Servo& servo_;
  wire::Endpoint& endpoint_;
  Snapshot snapshot_;
  std::string text_;
  std::uint64_t polls_ = 0;

  std::atomic<std::uint64_t>&missed_cycles_, &stale_plan_events_, &plans_other_session_,
      &plans_invalid_, &workspace_clamps_, &plan_clamps_, &torque_clamps_, &torque_rate_clamps_,
      &late_loops_, &stops_, &states_lost_, &plans_lost_, &commands_failed_, &state_to_command_p50_,
      &state_to_command_p95_, &state_to_command_p99_;
};

}  // namespace c3rt::impedance
