#include "controller/impedance/service.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace c3rt::impedance {

namespace {

constexpr std::uint64_t kPollsPerQuantiles = 5;

c3rt_v2_ServiceState state_of(const Snapshot& snapshot) {
  switch (snapshot.mode) {
    case Mode::kWait:
      return c3rt_v2_SERVICE_STARTING;
    case Mode::kTrack:
      return c3rt_v2_SERVICE_RUNNING;
    case Mode::kHold:
      return snapshot.plan == PlanVerdict::kNone ? c3rt_v2_SERVICE_RUNNING
                                                 : c3rt_v2_SERVICE_DEGRADED;
    case Mode::kStop:
      break;
  }
  return c3rt_v2_SERVICE_DEGRADED;
}

const char* why_it_holds(PlanVerdict plan) {
  switch (plan) {
    case PlanVerdict::kGood:
      return "the robot takes no commands";
    case PlanVerdict::kNone:
      return "no plan has arrived";
    case PlanVerdict::kOtherSession:
      return "the plan is of another session";
    case PlanVerdict::kInvalid:
      return "the plan is not usable (not finite or of unknown status)";
    case PlanVerdict::kStale:
      return "the plan is too old";
  }
  return "";
}

}  // namespace

std::string describe(const Snapshot& snapshot) {
  switch (snapshot.mode) {
    case Mode::kWait:
      return "waits for the robot's state";
    case Mode::kTrack:
      return "tracks the plan";
    case Mode::kHold:
      return std::string("holds its position: ") + why_it_holds(snapshot.plan);
    case Mode::kStop:
      break;
  }
  return std::string("stopped: ") + to_text(snapshot.stop_reason) +
         (snapshot.ends_alone ? "; damps until it comes steadily again"
                              : "; damps until a recovery is requested");
}

Service::Service(Servo& servo, wire::Endpoint& endpoint)
    : servo_(servo),
      endpoint_(endpoint),
      missed_cycles_(endpoint.status().counter("missed_cycles")),
      stale_plan_events_(endpoint.status().counter("stale_plan_events")),
      plans_other_session_(endpoint.status().counter("plans_other_session")),
      plans_invalid_(endpoint.status().counter("plans_invalid")),
      workspace_clamps_(endpoint.status().counter("workspace_clamps")),
      plan_clamps_(endpoint.status().counter("plan_clamps")),
      torque_clamps_(endpoint.status().counter("torque_clamps")),
      torque_rate_clamps_(endpoint.status().counter("torque_rate_clamps")),
      late_loops_(endpoint.status().counter("late_loops")),
      stops_(endpoint.status().counter("stops")),
      states_lost_(endpoint.status().counter("states_lost")),
      plans_lost_(endpoint.status().counter("plans_lost")),
      commands_failed_(endpoint.status().counter("commands_failed")),
      state_to_command_p50_(endpoint.status().counter("state_to_command_p50_ns")),
      state_to_command_p95_(endpoint.status().counter("state_to_command_p95_ns")),
      state_to_command_p99_(endpoint.status().counter("state_to_command_p99_ns")) {}

bool Service::poll(std::int64_t now_ns) {
  servo_.take_snapshot(snapshot_);
  endpoint_.answer_pending(now_ns, snapshot_.cycle, [this](c3rt_v2_RequestVerb verb, bool late) {
    return verb == c3rt_v2_REQUEST_STOP ? stopped(late) : recovered(late);
  });
  endpoint_.serve_requests(
      now_ns,
      [this](c3rt_v2_RequestVerb verb) -> std::optional<wire::Answer> {
        if (verb == c3rt_v2_REQUEST_STOP) servo_.stop();
        if (verb == c3rt_v2_REQUEST_RECOVER) servo_.recover();
        return {};
      },
      snapshot_.cycle);
  endpoint_.serve_faults(now_ns, [this, now_ns](const wire::FaultInject& fault) {
    servo_.faults().begin(fault, now_ns);
    return std::string();
  });
  update_counters();

  text_ = describe(snapshot_);
  return endpoint_.say(state_of(snapshot_), text_);
}

std::optional<wire::Answer> Service::stopped(bool late) const {
  const bool stands = snapshot_.mode == Mode::kStop && snapshot_.standing;
  if (stands) return wire::Answer{true, describe(snapshot_)};
  if (late) return wire::Answer{false, describe(snapshot_) + "; the arm does not stand yet"};
  return {};
}

std::optional<wire::Answer> Service::recovered(bool late) const {
  if (snapshot_.steady_cycles >= wire::kSteadyCycles)
    return wire::Answer{true, describe(snapshot_)};
  // whether the robot goes on after another stop is its own word; ours is final where a person must
  // help
  const bool final = snapshot_.mode == Mode::kStop && !snapshot_.ends_alone;
  if (!final && !late) return {};
  return wire::Answer{
      false, describe(snapshot_) + (snapshot_.robot_moves ? "" : "; the robot does not move")};
}

void Service::update_counters() {
  const Counters& counters = snapshot_.counters;
  stale_plan_events_ = counters.stale_plan_events;
  plans_other_session_ = counters.plans_other_session;
  plans_invalid_ = counters.plans_invalid;
  workspace_clamps_ = counters.workspace_clamps;
  plan_clamps_ = counters.plan_clamps;
  torque_clamps_ = counters.torque_clamps;
  torque_rate_clamps_ = counters.torque_rate_clamps;
  late_loops_ = counters.late_loops;
  stops_ = counters.stops;
  states_lost_ = servo_.states_lost();
  plans_lost_ = servo_.plans_lost();
  commands_failed_ = servo_.commands_failed();
  // they cost more than a cycle, and a status goes out ten times a second
  if (polls_++ % kPollsPerQuantiles != 0) return;
  const rt::Quantiles age = servo_.state_to_command().snapshot();
  state_to_command_p50_ = static_cast<std::uint64_t>(std::max(age.p50_s, 0.0) * 1e9);
  state_to_command_p95_ = static_cast<std::uint64_t>(std::max(age.p95_s, 0.0) * 1e9);
  state_to_command_p99_ = static_cast<std::uint64_t>(std::max(age.p99_s, 0.0) * 1e9);
}

}  // namespace c3rt::impedance
