#include "controller/impedance/service.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "controller/rt/periodic_clock.hpp"
#include "idl/faults.hpp"

namespace c3rt::impedance {

namespace {

// a request is handed over during one cycle and surely obeyed in the next
constexpr std::uint64_t kCyclesToObey = 2;
// It is answered when it is known to have worked: recovered, the arm has been held or has tracked
// for so many cycles; stopped, it stands. If it has not by then, the answer says why not.
constexpr int kSteadyCycles = 400;
constexpr std::uint64_t kAnswerWithinCycles = 3000;

c3rt_v1_ServiceState state_of(const Snapshot& snapshot) {
  switch (snapshot.mode) {
    case Mode::kWait:
      return c3rt_v1_SERVICE_STARTING;
    case Mode::kTrack:
      return c3rt_v1_SERVICE_RUNNING;
    case Mode::kHold:
      return snapshot.plan == PlanVerdict::kNone ? c3rt_v1_SERVICE_RUNNING
                                                 : c3rt_v1_SERVICE_DEGRADED;
    case Mode::kStop:
      break;
  }
  return c3rt_v1_SERVICE_DEGRADED;
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

Service::Service(wire::Bus& bus, Servo& servo, wire::StatusReporter& status)
    : servo_(servo),
      status_(status),
      requests_(bus, 16, wire::Wakes::kItself),
      faults_(bus, 16, wire::Wakes::kItself),
      replies_(bus, c3rt_v1_PROCESS_IMPEDANCE),
      missed_cycles_(status.counter("missed_cycles")),
      stale_plan_events_(status.counter("stale_plan_events")),
      plans_other_session_(status.counter("plans_other_session")),
      plans_invalid_(status.counter("plans_invalid")),
      workspace_clamps_(status.counter("workspace_clamps")),
      plan_clamps_(status.counter("plan_clamps")),
      torque_clamps_(status.counter("torque_clamps")),
      torque_rate_clamps_(status.counter("torque_rate_clamps")),
      stops_(status.counter("stops")),
      states_lost_(status.counter("states_lost")),
      plans_lost_(status.counter("plans_lost")),
      commands_failed_(status.counter("commands_failed")),
      state_to_command_p50_(status.counter("state_to_command_p50_ns")),
      state_to_command_p95_(status.counter("state_to_command_p95_ns")),
      state_to_command_p99_(status.counter("state_to_command_p99_ns")) {}

bool Service::poll() {
  servo_.take_snapshot(snapshot_);
  answer_requests();
  take_requests();
  take_faults();
  update_counters();

  const std::string text = describe(snapshot_);
  if (text == text_) return false;
  text_ = text;
  status_.set_state(state_of(snapshot_), text_);
  return true;
}

void Service::take_requests() {
  replies_.answer_refused(requests_, rt::now_ns());
  wire::ServiceRequest request{};
  while (requests_.take(request)) {
    if (request.process != c3rt_v1_PROCESS_IMPEDANCE) continue;
    if (request.verb == c3rt_v1_REQUEST_STOP) servo_.stop();
    if (request.verb == c3rt_v1_REQUEST_RECOVER) servo_.recover();
    // wire::Loop obeys and answers REQUEST_SHUTDOWN
    if (request.verb != c3rt_v1_REQUEST_SHUTDOWN) pending_.push_back({request, snapshot_.cycle});
  }
}

void Service::answer_requests() {
  pending_.erase(std::remove_if(pending_.begin(), pending_.end(),
                                [this](const Pending& pending) { return answered(pending); }),
                 pending_.end());
}

bool Service::answered(const Pending& pending) {
  if (snapshot_.cycle < pending.cycle + kCyclesToObey) return false;
  const bool late = snapshot_.cycle >= pending.cycle + kAnswerWithinCycles;
  const bool stopped = snapshot_.mode == Mode::kStop;
  bool ok = false;
  std::string text = describe(snapshot_);
  if (pending.request.verb == c3rt_v1_REQUEST_STOP) {
    ok = stopped && snapshot_.standing;
    if (!ok && !late) return false;
    if (!ok) text += "; the arm does not stand yet";
  } else {
    ok = snapshot_.steady_cycles >= kSteadyCycles;
    // whether the robot goes on after another stop is its own word; ours is final where a person
    // must help
    const bool final = stopped && !snapshot_.ends_alone;
    if (!ok && !final && !late) return false;
    if (!ok && !snapshot_.robot_moves) text += "; the robot does not move";
  }
  replies_.answer(pending.request.request_id, ok, text, rt::now_ns());
  return true;
}

void Service::take_faults() {
  replies_.answer_refused(faults_, rt::now_ns());
  wire::FaultInject fault{};
  while (faults_.take(fault)) {
    if (fault.process != c3rt_v1_PROCESS_IMPEDANCE) continue;
    const std::string refused = wire::refusal(fault, {});
    replies_.answer(fault.request_id, refused.empty(),
                    refused.empty() ? wire::describe(fault) : "refused: " + refused, rt::now_ns());
    if (!refused.empty()) continue;
    if (fault.kind == c3rt_v1_FAULT_NONE) servo_.end_faults();
    const auto duration_ns = static_cast<std::int64_t>(fault.duration_s * 1e9);
    if (fault.kind == c3rt_v1_FAULT_STALL) servo_.stall(duration_ns);
    if (fault.kind == c3rt_v1_FAULT_NAN) servo_.spoil(duration_ns);
  }
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
  stops_ = counters.stops;
  states_lost_ = servo_.states_lost();
  plans_lost_ = servo_.plans_lost();
  commands_failed_ = servo_.commands_failed();
  const rt::Quantiles age = servo_.state_to_command().snapshot();
  state_to_command_p50_ = static_cast<std::uint64_t>(std::max(age.p50_s, 0.0) * 1e9);
  state_to_command_p95_ = static_cast<std::uint64_t>(std::max(age.p95_s, 0.0) * 1e9);
  state_to_command_p99_ = static_cast<std::uint64_t>(std::max(age.p99_s, 0.0) * 1e9);
}

}  // namespace c3rt::impedance
