#include "controller/impedance/controller.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace c3rt::impedance {

namespace {

constexpr double kSecondsPerNs = 1e-9;
constexpr double kQuaternionTolerance = 1e-2;  // a norm farther from 1 is no orientation
// what no planner of this arm can mean; more than the limits but less than this is cut to them
constexpr double kFarthest = 2.0;       // from the robot's base [m]
constexpr double kFastest = 10.0;       // [m/s]
constexpr double kStrongest = 200.0;    // [N]
constexpr double kLongestAhead = 10.0;  // of a knot, from the plan's stamp [s]
constexpr double kNew = 2.5;  // cycles: so old a robot state may be for the law to act on it
// of a joint's velocity limit: from here the reference asks for less, from there for nothing
constexpr double kFastJoint = 0.5, kTooFastJoint = 0.8;
// and below this one, with the law's own torque for so many cycles in a row, the arm stands
constexpr double kStandingJoint = 0.1;
constexpr int kStandingCycles = 10;

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) noexcept {
  return static_cast<double>(to_ns - from_ns) * kSecondsPerNs;
}

/// Finite, and of this world. (A comparison with NaN is false.)
bool is_plausible(const Knot& knot, std::int64_t stamp_ns) noexcept {
  return knot.p_WE.norm() <= kFarthest && knot.v_WE.norm() <= kFastest &&
         knot.force_E.norm() <= kStrongest &&
         std::abs(static_cast<double>(knot.time_ns) - static_cast<double>(stamp_ns)) *
                 kSecondsPerNs <=
             kLongestAhead &&
         std::abs(knot.q_WE.norm() - 1.0) <= kQuaternionTolerance;
}

bool is_plausible(const Plan& plan) noexcept {
  if (!are_ordered(plan.knots, plan.knot_count)) return false;
  return std::all_of(plan.knots.begin(), plan.knots.begin() + plan.knot_count,
                     [&plan](const Knot& knot) { return is_plausible(knot, plan.stamp_ns); });
}

StopReason reason_of(StateFault fault) noexcept {
  switch (fault) {
    case StateFault::kStale:
      return StopReason::kStateStale;
    case StateFault::kNotFinite:
      return StopReason::kStateNotFinite;
    case StateFault::kJointPosition:
      return StopReason::kJointPosition;
    case StateFault::kJointVelocity:
      return StopReason::kJointVelocity;
    case StateFault::kNone:
      break;
  }
  return StopReason::kRequested;
}

/// The point at most `step` away from `from` on the way to `to`.
Eigen::Vector3d move_towards(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                             double step) noexcept {
  const double distance = (to - from).norm();
  return distance <= step ? to : Eigen::Vector3d(from + (to - from) * (step / distance));
}

Eigen::Quaterniond turn_towards(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to,
                                double step) noexcept {
  const double angle = from.angularDistance(to);
  return angle <= step ? to : from.slerp(step / angle, to).normalized();
}

/// Of its velocity limit.
double fastest_joint(const Vector7d& dq, const Vector7d& dq_max) noexcept {
  return (dq.array().abs() / dq_max.array()).maxCoeff();
}

/// 1 while every joint is well within its velocity limit, 0 near it.
double ease(const Vector7d& dq, const Vector7d& dq_max) noexcept {
  return std::clamp((kTooFastJoint - fastest_joint(dq, dq_max)) / (kTooFastJoint - kFastJoint), 0.0,
                    1.0);
}

/// The error that the law answers with an acceleration.
double lead(double acceleration, double stiffness) noexcept {
  return std::min(kFarthest, acceleration / std::max(stiffness, 1e-9));
}

}  // namespace

StateFault judge_state(const Input& input, const Limits& limits) noexcept {
  if (!input.q.allFinite() || !input.dq.allFinite()) return StateFault::kNotFinite;
  if ((input.q.array() < limits.q_min.array()).any() ||
      (input.q.array() > limits.q_max.array()).any()) {
    return StateFault::kJointPosition;
  }
  if ((input.dq.array().abs() > limits.dq_max.array()).any()) return StateFault::kJointVelocity;
  if (seconds_between(input.state_stamp_ns, input.now_ns) > limits.state_timeout)
    return StateFault::kStale;
  return StateFault::kNone;
}

PlanVerdict judge_plan(const Input& input, const Limits& limits) noexcept {
  if (!input.has_plan) return PlanVerdict::kNone;
  const Plan& plan = input.plan;
  if (plan.session_id == 0 || plan.session_id != input.session_id)
    return PlanVerdict::kOtherSession;
  if (plan.status == PlanStatus::kUnknown || !is_plausible(plan)) return PlanVerdict::kInvalid;
  if (input.now_ns > plan.valid_until_ns ||
      seconds_between(plan.stamp_ns, input.now_ns) > limits.plan_timeout) {
    return PlanVerdict::kStale;
  }
  return PlanVerdict::kGood;
}

const char* to_text(StopReason reason) noexcept {
  switch (reason) {
    case StopReason::kNone:
      return "not stopped";
    case StopReason::kRequested:
      return "a stop was requested";
    case StopReason::kStateStale:
      return "the robot state is stale";
    case StopReason::kStateNotFinite:
      return "the robot state is not finite";
    case StopReason::kJointPosition:
      return "a joint position is outside its limits";
    case StopReason::kJointVelocity:
      return "a joint velocity is outside its limits";
    case StopReason::kTorqueNotFinite:
      return "the law gave a torque that is not finite";
  }
  return "unknown";
}

Controller::Controller(const Parameters& parameters, model::Arm arm)
    : parameters_(parameters), arm_(std::move(arm)) {
  arm_.update(Vector7d::Zero(), Vector7d::Zero(), state_);
  rest_here();
}

Output Controller::step(const Input& input) noexcept {
  if (input.has_state && input.session_id != session_id_) meet_new_robot(input.session_id);
  change_mode(input);

  if (mode_ != Mode::kWait) {
    const bool finite = fault_ != StateFault::kNotFinite;
    const bool state_usable = finite && !old_state_;
    Vector7d wanted = Vector7d::Zero();
    // damping bears states that are too old for the law, as long as they come one after the other
    const bool states_come = same_state_cycles_ <= kNew;
    if (finite && (!old_state_ || states_come) && late_ && mode_ != Mode::kStop) {
      arm_.update(input.q, input.dq, state_);
      rest_here();
      brakes_ = catches_up_ = true;
      wanted = damping(input);
    } else if (state_usable && !new_state_ && mode_ != Mode::kStop) {
      wanted = tau_;  // a law whose arm seems to stand still pulls it the harder
    } else if (state_usable) {
      arm_.update(input.q, input.dq, state_);
      if (mode_ == Mode::kStop) rest_here();
      // an old velocity damps nothing, so without a usable state the torque fades out instead
      wanted = mode_ == Mode::kStop ? damping(input) : law_torque(input);
    }
    if (!wanted.allFinite()) {
      wanted.setZero();
      if (mode_ != Mode::kStop) ++counters_.stops;
      mode_ = Mode::kStop;
      stop_reason_ = StopReason::kTorqueNotFinite;
    }
    tau_ = limited(wanted);
  }

  Output output;
  output.mode = mode_;
  output.commands = mode_ != Mode::kWait && !(mode_ == Mode::kStop && old_state_);
  output.tau = tau_;
  output.p_WE_desired = reference_.p_WE;
  output.v_WE_desired = reference_.v_WE;
  output.q_WE_desired = reference_.q_WE;
  output.stop_reason = stop_reason_;
  output.ends_alone = stop_ends_alone();
  output.plan = plan_verdict_;
  output.steady_cycles = steady_cycles_;
  output.counters = counters_;
  return output;
}

void Controller::meet_new_robot(std::uint64_t session_id) noexcept {
  session_id_ = session_id;
  mode_ = Mode::kWait;
  stop_reason_ = StopReason::kNone;
  judged_plan_ns_ = 0;
  stale_cycles_ = 0;
  previous_now_ns_ = 0;
  loop_age_ = lag_ = 1.0;
  answered_ns_ = 0;
  late_ = false;
  away_ = false;
  tau_.setZero();
}

void Controller::change_mode(const Input& input) noexcept {
  plan_verdict_ = judge_plan(input, parameters_.limits);
  if (input.has_plan && input.plan.stamp_ns != judged_plan_ns_) {
    judged_plan_ns_ = input.plan.stamp_ns;
    if (plan_verdict_ == PlanVerdict::kOtherSession) ++counters_.plans_other_session;
    if (plan_verdict_ == PlanVerdict::kInvalid) ++counters_.plans_invalid;
  }
  fault_ = judge_state(input, parameters_.limits);
  watch_loop(input);
  stale_cycles_ = fault_ == StateFault::kStale ? stale_cycles_ + 1 : 0;
  const double longest = kPatience * parameters_.period;
  new_state_ = seconds_between(input.state_stamp_ns, input.now_ns) <= kNew * parameters_.period;
  old_state_ = seconds_between(input.state_stamp_ns, input.now_ns) > longest;
  same_state_cycles_ = input.state_stamp_ns == seen_state_ns_ ? same_state_cycles_ + 1 : 0;
  seen_state_ns_ = input.state_stamp_ns;
  const double pause = seconds_between(previous_now_ns_, input.now_ns);
  away_ = away_ || old_state_ || (previous_now_ns_ != 0 && pause > longest);
  previous_now_ns_ = input.now_ns;
  if (fault_ == StateFault::kStale && stale_cycles_ <= kPatience) fault_ = StateFault::kNone;

  Health health{};
  health.state_seen = input.has_state;
  health.state_good = fault_ == StateFault::kNone;
  health.robot_moves = input.robot_moves;
  health.plan_good = plan_verdict_ == PlanVerdict::kGood;
  health.stop = input.stop;
  health.recover = recovers(input.recover);
  const Mode before = mode_;
  mode_ = next(before, health);

  if (mode_ == Mode::kStop && before != Mode::kStop) {
    ++counters_.stops;
    stop_reason_ = reason_of(fault_);
  }
  if (mode_ != Mode::kStop) stop_reason_ = StopReason::kNone;
  if (mode_ != before || away_) catches_up_ = true;
  if (away_) brakes_ = true;
  if (before == Mode::kTrack && mode_ == Mode::kHold && plan_verdict_ == PlanVerdict::kStale) {
    ++counters_.stale_plan_events;
  }

  const bool moving = mode_ == Mode::kHold || mode_ == Mode::kTrack;
  steady_cycles_ = moving && input.robot_moves && !late_ ? steady_cycles_ + 1 : 0;
  if (!moving || old_state_) return;
  // a robot that was not under our control is wherever it is: start from there
  const bool anew = before == Mode::kWait || before == Mode::kStop || away_ || !input.robot_moves ||
                    (before == Mode::kHold && mode_ == Mode::kTrack);
  if (anew || before != mode_) {
    arm_.update(input.q, input.dq, state_);
    X_WE_hold_ = state_.X_WE;
  }
  if (anew) rest_here();
  away_ = false;
}

void Controller::watch_loop(const Input& input) noexcept {
  double age = 1.0;  // cycles; of a loop that is not closed nothing is late
  if (input.robot_moves && input.answered_ns != 0) {
    const double answer = seconds_between(input.answered_ns, input.state_stamp_ns);
    const double state = seconds_between(input.state_stamp_ns, input.now_ns);
    age = std::clamp(std::max(answer, state) / parameters_.period, 0.0, 1.0 * kPatience);
  }
  loop_age_ += (age - loop_age_) / kLoopMemory;
  const bool swings = fastest_joint(input.dq, parameters_.limits.dq_max) > kSwinging;
  const double bearable = late_ ? kLoopIsWell : kLateLoop;
  const double lag = take_lag(input, age);  // in every cycle, or a gap would seem to have been
  const bool late = loop_age_ > (swings ? kLateSwinging : bearable) || lag > bearable;
  if (late && !late_) ++counters_.late_loops;
  late_ = late;
}

double Controller::take_lag(const Input& input, double age) noexcept {
  if (!input.robot_moves || input.answered_ns == 0) {
    answered_ns_ = 0;
    return lag_ = 1.0;
  }
  const bool first = answered_ns_ == 0;
  const double gap = first ? 0.0 : seconds_between(answered_at_ns_, input.now_ns);
  const double newest = std::min(std::max(age, gap / parameters_.period), kLongestLag);
  const double with_newest = lag_ + (newest - lag_) / kFewCommands;
  if (first || input.answered_ns != answered_ns_) {
    answered_ns_ = input.answered_ns;
    answered_at_ns_ = input.now_ns;
    lag_ = with_newest;
  }
  return with_newest;
}

Vector7d Controller::damping(const Input& input) const noexcept {
  return -parameters_.limits.stop_damping * (state_.M * input.dq);
}

bool Controller::stop_ends_alone() const noexcept {
  return parameters_.recovers_alone && mode_ == Mode::kStop &&
         stop_reason_ == StopReason::kStateStale;
}

bool Controller::recovers(bool asked) noexcept {
  const bool good = stale_cycles_ == 0 && fault_ == StateFault::kNone;
  good_cycles_ = stop_ends_alone() && good ? good_cycles_ + 1 : 0;
  return asked || good_cycles_ >= kGoodStates;
}

void Controller::rest_here() noexcept {
  reference_.p_WE = state_.X_WE.translation();
  reference_.v_WE.setZero();
  reference_.q_WE = Eigen::Quaterniond(state_.X_WE.linear());
  reference_.force_E.setZero();
  tau_of_goal_.setZero();
}

Goal Controller::target(const Input& input) noexcept {
  const Limits& limits = parameters_.limits;
  Goal target;
  target.p_WE = X_WE_hold_.translation();
  target.v_WE.setZero();
  target.q_WE = Eigen::Quaterniond(X_WE_hold_.linear());
  target.force_E.setZero();
  if (mode_ != Mode::kTrack) return target;

  const Plan& plan = input.plan;
  const Goal planned = interpolate(plan.knots, plan.knot_count, input.now_ns);
  target.p_WE = planned.p_WE;
  target.v_WE = planned.v_WE;
  target.q_WE = planned.q_WE;
  if (parameters_.reference == Reference::kInterpolate && plan.knot_count == 1) {
    const double to_go = seconds_between(input.now_ns, plan.knots[0].time_ns);
    target.p_WE -= planned.v_WE * std::max(to_go, 0.0);
    if (to_go <= 0.0) target.v_WE.setZero();
  }
  const Eigen::Vector3d inside =
      target.p_WE.cwiseMax(limits.workspace_min).cwiseMin(limits.workspace_max);
  if (inside != target.p_WE) {
    ++counters_.workspace_clamps;
    target.v_WE = (inside.array() == target.p_WE.array()).select(target.v_WE, 0.0);
    target.p_WE = inside;
  }
  if (parameters_.feed_forward && plan.status != PlanStatus::kFallback &&
      planned.force_E.norm() > parameters_.feed_forward_threshold) {
    target.force_E = planned.force_E;
  }
  return target;
}

void Controller::move_reference(const Input& input) noexcept {
  const Limits& limits = parameters_.limits;
  const double period = parameters_.period;
  const Goal wanted = target(input);
  const double given = ease(input.dq, limits.dq_max);
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();

  const Eigen::Vector3d p_WE = state_.X_WE.translation();
  const double farthest =
      given * lead(limits.lead_acceleration, parameters_.gains.stiffness.head<3>().maxCoeff());
  const Eigen::Vector3d next =
      move_towards(reference_.p_WE, wanted.p_WE, limits.reference_speed * period);
  reference_.p_WE = move_towards(p_WE, next, farthest);

  const Eigen::Quaterniond q_WE(state_.X_WE.linear());
  // the law's rotational error is half an angle
  const double farthest_turn =
      given * 2.0 *
      lead(limits.lead_angular_acceleration, parameters_.gains.stiffness.tail<3>().maxCoeff());
  const Eigen::Quaterniond next_turn =
      turn_towards(reference_.q_WE, wanted.q_WE, limits.reference_angular_speed * period);
  reference_.q_WE = turn_towards(q_WE, next_turn, farthest_turn);

  // an arm that is far from its plan moves no farther away from it, and touches something else than
  // the plan means, or nothing: no force of the plan's
  const Eigen::Vector3d way = wanted.p_WE - p_WE;
  const double off = way.norm();
  const double at_plan = off <= farthest ? 1.0 : std::clamp(2.0 - off / farthest, 0.0, 1.0);
  const bool away = way.dot(wanted.v_WE) < 0.0;
  const Eigen::Vector3d v_WE =
      move_towards(none, (away ? at_plan * given : given) * wanted.v_WE, limits.plan_speed);
  reference_.v_WE = move_towards(reference_.v_WE, v_WE, limits.plan_acceleration * period);
  reference_.force_E = given * at_plan * move_towards(none, wanted.force_E, limits.plan_force);

  if (reference_.p_WE != next || v_WE != wanted.v_WE || reference_.force_E != wanted.force_E)
    ++counters_.plan_clamps;
}

bool Controller::stands(const Input& input) const noexcept {
  return own_torque_cycles_ >= kStandingCycles &&
         fastest_joint(input.dq, parameters_.limits.dq_max) < kStandingJoint;
}

Vector7d Controller::law_torque(const Input& input) noexcept {
  brakes_ = brakes_ && !stands(input);
  if (brakes_) {
    rest_here();
  } else {
    move_reference(input);
  }
  const Torque wanted = torque(parameters_.gains, state_, input.q, input.dq, reference_);
  const Vector7d change = wanted.of_goal - tau_of_goal_;
  const double largest = change.cwiseAbs().maxCoeff();
  const double step = parameters_.limits.tau_rate_max * parameters_.period;
  if (largest <= step) {
    tau_of_goal_ = wanted.of_goal;
  } else {
    tau_of_goal_ += change * (step / largest);
  }
  return tau_of_goal_ + wanted.of_arm;
}

Vector7d Controller::limited(const Vector7d& wanted) noexcept {
  const Limits& limits = parameters_.limits;
  Vector7d clamped = wanted.cwiseMin(limits.tau_max).cwiseMax(-limits.tau_max);
  if (clamped != wanted) ++counters_.torque_clamps;
  const double step = limits.tau_rate_max * parameters_.period;
  const Vector7d change = clamped - tau_;
  const double largest = change.cwiseAbs().maxCoeff();
  own_torque_cycles_ = largest <= step ? own_torque_cycles_ + 1 : 0;
  if (largest <= step) {
    catches_up_ = false;
    return clamped;
  }
  ++counters_.torque_rate_clamps;
  if (catches_up_) return tau_ + change * (step / largest);
  return clamped.cwiseMin((tau_.array() + step).matrix()).cwiseMax((tau_.array() - step).matrix());
}

}  // namespace c3rt::impedance
