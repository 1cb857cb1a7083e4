#pragma once
// The robot, the table and what lies on it, on the types of the wire: a command or a motion in,
// state and scene out, once per cycle. No bus, no clock, no thread: service.hpp has those. What
// another robot would be in its place is a RobotNode, too: examples/real_robot.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "idl/topics.hpp"
#include "plant_emulator/orders.hpp"
#include "plant_emulator/plant.hpp"

namespace c3rt::plant {

constexpr std::int64_t kCycleNs = 1'000'000;

/// Due instants of a period: true once for each that has passed.
class Schedule {
 public:
  explicit Schedule(std::int64_t period_ns) : period_ns_(period_ns) {}
  bool due(std::int64_t now_ns) noexcept {
    if (now_ns < next_ns_) return false;
    next_ns_ += ((now_ns - next_ns_) / period_ns_ + 1) * period_ns_;
    return true;
  }

 private:
  std::int64_t period_ns_;
  std::int64_t next_ns_ = 0;
};

/// When robot/contact is due: every 10 ms, and when something began or ended.
class ContactReport {
 public:
  /// @return whether it is, with the sample filled. RT: no heap, no lock, no throw.
  bool due(std::int64_t now_ns, const State& state, wire::RobotContact& sample) noexcept;

 private:
  Schedule schedule_{10'000'000};
};

/// A robot, with or without a world around it.
class RobotNode {
 public:
  struct Output {
    wire::RobotState state{};
    bool scene_due = false;  // at an exposure, or for the recorder
    wire::Scene scene{};
    bool contact_due = false;  // every 10 ms, and when it changes
    wire::RobotContact contact{};
  };
  struct Counters {
    std::uint64_t reflexes = 0, exposures = 0, faults = 0;
    std::uint64_t refused_motions = 0;  // something else moved the robot, or stopped it
    int moving_cycles = 0;              // in a row
  };

  RobotNode() = default;
  virtual ~RobotNode() = default;
  RobotNode(const RobotNode&) = delete;
  RobotNode& operator=(const RobotNode&) = delete;

  // all of them RT: no heap, no throw

  /// What a client asked for, from the next step on. A stall is the process's affair. What has
  /// become of an order that is_answered() is told by answered(), now or later.
  virtual void obey(const Order& order) noexcept = 0;
  /// One cycle of the robot, which ends at now_ns. Valid until the next one.
  /// @param command, motion that have come since; nullptr: none
  virtual const Output& step(std::int64_t now_ns, const wire::RobotCommand* command,
                             const wire::RobotMotion* motion) noexcept = 0;

  virtual const State& state() const noexcept = 0;
  /// It stopped because commands were missing, and moves by itself once they come again.
  virtual bool waits_for_commands() const noexcept = 0;
  /// Why it has not this fault or order; empty: it has. From any thread.
  virtual std::string refusal(OrderKind) const { return ""; }
  /// Why it follows no motions; empty: it does. From any thread.
  virtual std::string refusal_of_motions() const { return ""; }
  /// What has become of orders. Taken by one thread.
  Queue<Answered>& answered() noexcept { return answered_; }
  const Counters& counters() const noexcept { return counters_; }

 protected:
  /// Of a cycle that has ended in this mode.
  void count(Mode mode) noexcept;
  void answer(const Order& order, Outcome outcome) noexcept {
    // who orders leaves room for the answers
    (void)answered_.put({order.request_id, order.kind, outcome});
  }
  Counters counters_;

 private:
  Mode mode_ = Mode::kIdle;
  Queue<Answered> answered_;
};

/// The emulated one.
class Node final : public RobotNode {
 public:
  /// @param exposure_rate of the cameras [1/s]
  /// @throws as Plant
  Node(const Parameters& parameters, double exposure_rate, std::uint64_t seed);

  void obey(const Order& order) noexcept override;
  /// What is now, before the first step. RT: no heap, no throw.
  const Output& start(std::int64_t now_ns) noexcept { return observe(now_ns); }
  const Output& step(std::int64_t now_ns, const wire::RobotCommand* command,
                     const wire::RobotMotion* motion) noexcept override;
  const State& state() const noexcept override { return plant_.state(); }
  bool waits_for_commands() const noexcept override { return plant_.waits_for_commands(); }

  const Plant& plant() const noexcept { return plant_; }

 private:
  const Output& observe(std::int64_t now_ns) noexcept;
  Outcome outcome_of(const Order& order) noexcept;

  Plant plant_;
  Schedule exposure_, scene_;
  ContactReport contact_;
  std::vector<Push> pushes_;  // of the scenario
  std::size_t pushed_ = 0;
  double nan_until_ = 0.0;  // [s]
  MotionCommand motion_;
  Output output_;
};

}  // namespace c3rt::plant
