#include "controller/impedance/servo.hpp"

#include <utility>

#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"

namespace c3rt::impedance {

using base::seconds;

Servo::Servo(wire::Bus& bus, const Parameters& parameters, model::Arm arm, rt::Statistics& compute)
    : realtime_(bus.clock() == wire::ClockMode::kRealtime),
      states_(bus, &state_arrival_),
      plans_(bus),
      commands_(bus),
      node_(parameters, std::move(arm)),
      compute_(compute) {}

void Servo::cycle(std::int64_t now_ns) noexcept {
  if (faults_.stalls(now_ns)) return;

  const std::int64_t begin_ns = rt::now_ns();
  const std::int64_t until_ns = realtime_ ? begin_ns : now_ns;
  Node::Input in;
  if (states_.take(until_ns, state_)) in.state = &state_;
  if (plans_.take(until_ns, plan_)) in.plan = &plan_;
  in.stop = stop_.exchange(false);
  in.recover = recover_.exchange(false);
  in.spoilt = faults_.spoils(now_ns);
  const Node::Output& out = node_.step(realtime_ ? rt::now_ns() : now_ns, in);
  if (out.commands) {
    const std::int64_t sent_ns = realtime_ ? rt::now_ns() : now_ns;
    commands_.put(out.command, sent_ns);
    state_to_command_.add(seconds(sent_ns - state_.header.time_ns));
  }
  compute_.add(seconds(rt::now_ns() - begin_ns));
  show(out);
}

void Servo::show(const Node::Output& out) noexcept {
  ++snapshot_.cycle;
  snapshot_.mode = out.control.mode;
  snapshot_.stop_reason = out.control.stop_reason;
  snapshot_.ends_alone = out.control.ends_alone;
  snapshot_.plan = out.control.plan;
  snapshot_.robot_moves = out.robot_moves;
  snapshot_.standing = out.standing;
  snapshot_.steady_cycles = out.control.steady_cycles;
  snapshot_.counters = out.control.counters;
  snapshots_.put(snapshot_);
}

}  // namespace c3rt::impedance
