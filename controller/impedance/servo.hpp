#pragma once
// The impedance node on a bus: newest samples from the network, one step, command to the network.
#include <atomic>
#include <cstdint>

#include "controller/impedance/node.hpp"
#include "controller/rt/latest.hpp"
#include "controller/rt/statistics.hpp"
#include "idl/endpoint.hpp"
#include "idl/process.hpp"

namespace c3rt::impedance {

/// What the servo thread tells the rest of the process, once per cycle.
struct Snapshot {
  std::uint64_t cycle = 0;  // since the start
  Mode mode = Mode::kWait;
  StopReason stop_reason = StopReason::kNone;
  bool ends_alone = false;  // the stop, once good states come steadily
  PlanVerdict plan = PlanVerdict::kNone;
  bool robot_moves = false;
  bool standing = false;  // every joint
  int steady_cycles = 0;  // in a row: the robot moves, and is held or tracks
  Counters counters;
};

class Servo {
 public:
  /// @param compute gets the duration of every cycle
  Servo(wire::Bus& bus, const Parameters& parameters, model::Arm arm, rt::Statistics& compute);

  /// Raised when a robot state has arrived (realtime): a cycle answers it.
  wire::Signal& state_arrival() noexcept { return state_arrival_; }

  /// One cycle. In realtime `now_ns` only paces; the step's time is read after the samples, so that
  /// none of them lies in its future. RT (realtime): no heap, no lock, no throw.
  void cycle(std::int64_t now_ns) noexcept;

  // from any thread; they act in the next cycle
  void stop() noexcept { stop_.store(true); }
  void recover() noexcept { recover_.store(true); }
  wire::FaultWindows& faults() noexcept { return faults_; }

  const Node& node() const noexcept { return node_; }  // for the servo's thread
  /// From one other thread. false: no cycle since the last call.
  bool take_snapshot(Snapshot& out) noexcept { return snapshots_.take(out); }
  /// Age of the state that a command answers when the command is handed over [s].
  const rt::Statistics& state_to_command() const noexcept { return state_to_command_; }
  std::uint64_t states_lost() const noexcept { return states_.counters().lost; }
  std::uint64_t plans_lost() const noexcept { return plans_.counters().lost; }
  std::uint64_t commands_failed() const noexcept { return commands_.failed(); }

 private:
  void show(const Node::Output& out) noexcept;

  const bool realtime_;
  wire::Signal state_arrival_;
  wire::Inlet<wire::RobotState> states_;
  wire::Inlet<wire::Plan> plans_;
  wire::Outlet<wire::RobotCommand> commands_;
  Node node_;

  wire::RobotState state_{};
  wire::Plan plan_{};
  Snapshot snapshot_;

  std::atomic<bool> stop_{false}, recover_{false};
  wire::FaultWindows faults_;
  rt::Latest<Snapshot> snapshots_;
  rt::Statistics state_to_command_;
  rt::Statistics& compute_;
};

}  // namespace c3rt::impedance
