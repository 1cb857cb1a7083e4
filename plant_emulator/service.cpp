#include "plant_emulator/service.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "controller/base/words.hpp"
#include "idl/convert.hpp"
#include "plant_emulator/errors.hpp"

namespace c3rt::plant {
namespace {

constexpr double kStanding = 0.02;  // [rad/s]
constexpr int kMostOrders = 64;     // that may wait

/// Stands still, but not when it is asked to end.
void stall(double duration) noexcept {
  using std::chrono::steady_clock;
  const auto until = steady_clock::now() + std::chrono::duration<double>(duration);
  while (!wire::StopFlag::requested() && steady_clock::now() < until)
    std::this_thread::sleep_for(std::min<std::chrono::duration<double>>(
        until - steady_clock::now(), std::chrono::milliseconds(10)));
}

/// Of a fault that is not refused.
Order order_of(const wire::FaultInject& fault) {
  Order order{OrderKind::kEndFaults, static_cast<int>(fault.index), fault.duration_s,
              Eigen::Map<const Eigen::Vector3d>(fault.value)};
  if (fault.kind == c3rt_v2_FAULT_PUSH_OBJECT) order.kind = OrderKind::kPushObject;
  if (fault.kind == c3rt_v2_FAULT_DROP_COMMANDS) order.kind = OrderKind::kDropCommands;
  if (fault.kind == c3rt_v2_FAULT_STALL) order.kind = OrderKind::kStall;
  if (fault.kind == c3rt_v2_FAULT_NAN) order.kind = OrderKind::kNan;
  return order;
}

/// Of an order that was let in.
Order order_of(const wire::RobotOrder& sample) {
  Order order{};
  order.request_id = sample.request_id;
  switch (sample.kind) {
    case c3rt_v2_ORDER_GUIDING:
      order.kind = sample.engaged ? OrderKind::kGuide : OrderKind::kRelease;
      order.axes = {sample.free_axes, sample.free_elbow};
      break;
    case c3rt_v2_ORDER_USER_STOP:
      order.kind = sample.engaged ? OrderKind::kPressStop : OrderKind::kReleaseStop;
      break;
    case c3rt_v2_ORDER_THRESHOLDS:
      order.kind = OrderKind::kThresholds;
      wire::read_thresholds(sample.acceleration, order.behavior.acceleration);
      wire::read_thresholds(sample.nominal, order.behavior.nominal);
      break;
    case c3rt_v2_ORDER_PUSH:
      order.kind = OrderKind::kPushArm;
      order.value = Eigen::Map<const Eigen::Vector3d>(sample.force_W_n);
      order.duration = sample.duration_s;
      break;
  }
  return order;
}

/// "guiding along x, y, yaw, elbow"
std::string describe(const wire::RobotOrder& order) {
  switch (order.kind) {
    case c3rt_v2_ORDER_GUIDING: {
      if (!order.engaged) return "end of guiding";
      std::string free;
      for (std::size_t i = 0; i < kAxisNames.size(); ++i) {
        if ((order.free_axes >> i & 1U) != 0)
          free += (free.empty() ? "" : ", ") + std::string(kAxisNames[i]);
      }
      if (order.free_elbow) free += free.empty() ? "elbow" : ", elbow";
      return "guiding along " + free;
    }
    case c3rt_v2_ORDER_USER_STOP:
      return order.engaged ? "user stop pressed" : "user stop released";
    case c3rt_v2_ORDER_THRESHOLDS:
      return "thresholds of contact and collision";
    case c3rt_v2_ORDER_PUSH:
      break;
  }
  return base::words("push of the end effector by (%g, %g, %g) N for %g s", order.force_W_n[0],
                     order.force_W_n[1], order.force_W_n[2], order.duration_s);
}

/// What the robot does now.
const char* obeyed_text(OrderKind kind) {
  switch (kind) {
    case OrderKind::kGuide:
      return "the arm is led by the hand";
    case OrderKind::kRelease:
      return "nobody leads the arm";
    case OrderKind::kPressStop:
      return "the user stop is pressed: nothing moves the arm";
    case OrderKind::kReleaseStop:
      return "the user stop is released; recover ends the stop";
    case OrderKind::kThresholds:
      return "thresholds set";
    default:
      return "a hand pushes the end effector";
  }
}

}  // namespace

wire::FaultScope fault_scope(const Parameters& parameters) {
  wire::FaultScope scope;
  for (const ObjectParameters& object : parameters.world.objects)
    scope.object_masses.push_back(object.object.mass);
  return scope;
}

Service::Service(wire::Bus& bus, wire::Endpoint& endpoint, RobotNode& node)
    : endpoint_(endpoint),
      realtime_(bus.clock() == wire::ClockMode::kRealtime),
      node_(node),
      commands_(bus),
      motions_(bus),
      ordered_(bus, kMostOrders),
      states_(bus),
      scenes_(bus),
      contacts_(bus),
      cycles_(endpoint.status().counter("cycles")),
      lost_commands_(endpoint.status().counter("lost_commands")),
      saturated_(endpoint.status().counter("saturated_cycles")),
      reflexes_(endpoint.status().counter("reflexes")),
      success_(endpoint.status().counter("success_rate_1e3")),
      success_min_(endpoint.status().counter("success_rate_min_1e3")),
      exposures_(endpoint.status().counter("exposures")),
      faults_(endpoint.status().counter("faults")),
      refused_motions_(endpoint.status().counter("refused_motions")) {
  success_min_ = 1000;
}

void Service::step(std::int64_t at_ns, std::int64_t now_ns) noexcept {
  Order order{};
  while (orders_.take(order)) obey(order);
  // a robot follows what has reached it, in simulated time what is in effect
  const bool came = realtime_ ? commands_.take(command_) : commands_.take(at_ns, command_);
  const bool moved = realtime_ ? motions_.take(motion_) : motions_.take(at_ns, motion_);
  const RobotNode::Output& out =
      node_.step(now_ns, came ? &command_ : nullptr, moved ? &motion_ : nullptr);
  show();
  send(out, now_ns);
}

void Service::obey(const Order& order) noexcept {
  node_.obey(order);
  if (order.kind == OrderKind::kStall) stall(order.duration);
}

void Service::send(const RobotNode::Output& out, std::int64_t now_ns) noexcept {
  states_.put(out.state, now_ns);
  if (out.scene_due) scenes_.put(out.scene, now_ns);
  if (out.contact_due) contacts_.put(out.contact, now_ns);
}

void Service::show() noexcept {
  const State& s = node_.state();
  const RobotNode::Counters& counters = node_.counters();
  const auto set = [](std::atomic<std::uint64_t>& counter, std::uint64_t value) {
    counter.store(value, std::memory_order_relaxed);
  };
  set(cycles_, ++count_);
  set(lost_commands_, s.lost_commands);
  set(saturated_, s.saturated_cycles);
  set(reflexes_, counters.reflexes);
  set(exposures_, counters.exposures);
  set(faults_, counters.faults);
  set(refused_motions_, counters.refused_motions);
  const auto success = static_cast<std::uint64_t>(std::lround(1000 * s.command_success_rate));
  set(success_, success);
  // the window must be full, or one early loss would read as a bad connection
  if (counters.moving_cycles >= kSuccessWindow && success < success_min_)
    set(success_min_, success);
  shown_moving_.store(counters.moving_cycles, std::memory_order_relaxed);
  shown_standing_.store(s.dq.cwiseAbs().maxCoeff() < kStanding, std::memory_order_relaxed);
  shown_cause_.error.store(s.cause.error, std::memory_order_relaxed);
  shown_cause_.axis.store(s.cause.axis, std::memory_order_relaxed);
  shown_cause_.value.store(s.cause.value, std::memory_order_relaxed);
  shown_cause_.limit.store(s.cause.limit, std::memory_order_relaxed);
  shown_cause_.unit.store(s.cause.unit, std::memory_order_relaxed);
  shown_errors_.store(s.errors, std::memory_order_release);
  shown_mode_.store(s.mode, std::memory_order_release);
  shown_waiting_.store(node_.waits_for_commands(), std::memory_order_relaxed);
}

void Service::serve(std::int64_t now_ns) {
  const std::uint64_t cycle = cycles_.load();
  endpoint_.serve_requests(
      now_ns, [this](c3rt_v2_RequestVerb verb) { return order(verb); }, cycle);
  endpoint_.answer_pending(now_ns, cycle, [this](c3rt_v2_RequestVerb verb, bool late) {
    return verb == c3rt_v2_REQUEST_RECOVER ? recovered(late) : stopped(late);
  });
  endpoint_.serve_faults(now_ns, [this](const wire::FaultInject& fault) {
    const Order order = order_of(fault);
    std::string refused = node_.refusal(order.kind);
    if (!refused.empty()) return refused;
    return std::string(orders_.put(order) ? "" : "too many faults at once");
  });
  serve_orders(now_ns);
  tell_refused_motions();
  const Mode mode = shown_mode_.load();
  const bool well = mode == Mode::kIdle || mode == Mode::kMove;
  const std::string text = mode_text();
  if (endpoint_.say(well ? c3rt_v2_SERVICE_RUNNING : c3rt_v2_SERVICE_DEGRADED, text))
    endpoint_.tell(false, "mode " + text);
}

void Service::serve_orders(std::int64_t now_ns) {
  wire::Replies& replies = endpoint_.replies();
  Answered answered{};
  while (node_.answered().take(answered)) {
    --unanswered_;
    const bool obeyed = answered.outcome == Outcome::kObeyed;
    const std::string said = text_of(answered);
    if (answered.kind == OrderKind::kPressStop) stop_pressed_ = true;
    if (answered.kind == OrderKind::kReleaseStop) stop_pressed_ = false;
    replies.answer(answered.request_id, obeyed, said, now_ns);
    if (!obeyed) endpoint_.tell(true, "order " + said);
  }
  replies.answer_refused(ordered_, now_ns);
  wire::RobotOrder sample{};
  // what there is no room for in the queue of answers waits in the reader
  while (unanswered_ < Queue<Answered>::kSize && ordered_.take(sample)) {
    const Order order = order_of(sample);
    std::string refused = node_.refusal(order.kind);
    if (refused.empty() && !orders_.put(order)) refused = "too many orders at once";
    if (refused.empty()) {
      ++unanswered_;
      endpoint_.tell(false, "order " + describe(sample));
    } else {
      replies.answer(sample.request_id, false, "refused: " + refused, now_ns);
      endpoint_.tell(true, "order " + describe(sample) + ", refused: " + refused);
    }
  }
}

std::string Service::text_of(const Answered& answered) {
  switch (answered.outcome) {
    case Outcome::kObeyed:
      return obeyed_text(answered.kind);
    case Outcome::kMoves:
      return "refused: expected a robot that nothing moves (c3rt stop), got one that follows "
             "commands";
    case Outcome::kStopPressed:
      return "refused: expected a user stop that is released, got one that is pressed";
    case Outcome::kRefused:
      break;
  }
  return "refused by the robot; its log tells why";
}

void Service::tell_refused_motions() {
  const std::uint64_t refused = refused_motions_.load();
  const bool grows = refused != told_refused_motions_;
  if (grows && !tells_refused_motions_) {
    std::string why = node_.refusal_of_motions();
    if (why.empty())
      why = "expected a robot that is idle, or that this motion moves; " + mode_text();
    endpoint_.tell(true, "robot/motion is not followed: " + why);
  }
  told_refused_motions_ = refused;
  tells_refused_motions_ = grows;
}

std::optional<wire::Answer> Service::order(c3rt_v2_RequestVerb verb) {
  if (verb == c3rt_v2_REQUEST_RECOVER && stop_pressed_)
    return wire::Answer{false, "the user stop is pressed: c3rt robot user-stop release"};
  const OrderKind kind = verb == c3rt_v2_REQUEST_RECOVER ? OrderKind::kRecover : OrderKind::kStop;
  if (orders_.put({kind, 0, 0, Eigen::Vector3d::Zero()})) return {};
  return wire::Answer{false, "too many requests at once"};
}

std::optional<wire::Answer> Service::stopped(bool late) const {
  const bool stands = shown_mode_.load() != Mode::kMove && shown_standing_.load();
  if (stands) return wire::Answer{true, "stopped, the arm stands; recover ends it"};
  if (late) return wire::Answer{false, "the arm does not stand yet"};
  return {};
}

std::optional<wire::Answer> Service::recovered(bool late) const {
  const Mode mode = shown_mode_.load();
  const bool moves = mode == Mode::kMove && shown_moving_.load() >= wire::kSteadyCycles;
  // a reflex that ends by itself is no answer yet
  const bool stopped_again =
      (mode == Mode::kReflex && !shown_waiting_.load()) || mode == Mode::kUserStopped;
  if (!moves && !stopped_again && !late) return {};
  return wire::Answer{moves,
                      mode == Mode::kIdle ? "idle: no commands arrive; does c3rt-impedance run?"
                      : mode == Mode::kMove && !moves ? "the robot stopped again and moves again"
                                                      : mode_text()};
}

std::string Service::cause_text() const {
  const Cause cause{shown_cause_.error.load(), shown_cause_.axis.load(), shown_cause_.value.load(),
                    shown_cause_.limit.load(), shown_cause_.unit.load()};
  const std::string said = text(cause);
  if (said.empty()) return "";
  const bool alone = shown_errors_.load() == bit(cause.error);
  return " (" + (alone ? "" : std::string(name(cause.error)) + " of ") + said + ")";
}

std::string Service::mode_text() const {
  switch (shown_mode_.load()) {
    case Mode::kIdle:
      return "idle: holds its position and waits for a command";
    case Mode::kMove:
      return "follows commands";
    case Mode::kReflex:
      return "reflex: " +
             (shown_errors_.load() == 0 ? "of no error that has a name here, the log tells"
                                        : names(shown_errors_.load())) +
             cause_text() +
             (shown_waiting_.load() ? "; moves again once commands come steadily"
                                    : "; request recover");
    case Mode::kGuiding:
      return "guided by a person's hand; it moves by commands when that lets go";
    case Mode::kUserStopped:
      break;
  }
  return stop_pressed_ ? "stopped: the user stop is pressed; release it"
                       : "stopped by a person; request recover";
}

}  // namespace c3rt::plant
