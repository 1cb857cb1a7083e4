#include "examples/real_robot/door.hpp"

#include <algorithm>

#include "idl/convert.hpp"

namespace c3rt::real_robot {
namespace {

using plant::Errors;
using plant::Mode;

// The brake: damping that an arm bears whose torques come a cycle late; ours. Less than the
// emulated robot's own, which is part of its integration.
const Vector7d kDamping = (Vector7d() << 20, 20, 20, 20, 3, 3, 0.6).finished();  // [N m s/rad]
constexpr double kAtRest = 0.02;                                                 // [rad/s]
constexpr int kStands = 100;  // cycles at rest, then the robot's own controller takes over

}  // namespace

Door::Door(const plant::Parameters& parameters) : parameters_(parameters) {}

void Door::see(const plant::State& arm, bool commanded) noexcept {
  arm_ = arm;
  commanded_ = commanded;
}

void Door::obey(const plant::Order& order) noexcept {
  switch (order.kind) {
    case plant::OrderKind::kStop:
      events_.stop = true;
      return;
    case plant::OrderKind::kRecover:
      // a robot in good health is not asked: it stands because of us
      if (failed_ || arm_.mode == Mode::kReflex)
        recovery_wanted_ = true;
      else
        events_.recover = true;
      return;
    case plant::OrderKind::kDropCommands:
      drop_until_ = state_.time + order.duration;
      break;
    case plant::OrderKind::kEndFaults:
      drop_until_ = 0.0;
      break;
    case plant::OrderKind::kThresholds:
      if (wants_control()) {
        answer(order, plant::Outcome::kMoves);
      } else if (ordered_) {
        answer(order, plant::Outcome::kRefused);  // another one is on its way to the robot
      } else {
        ordered_ = order;
      }
      return;
    default:  // refusal() has told
      return;
  }
  ++counters_.faults;
}

void Door::take(const wire::RobotCommand& command) noexcept {
  if (state_.time < drop_until_) return;
  const Vector7d tau = wire::vector(command.tau_nm);
  if (!tau.allFinite()) {  // a reader of the bus lets none in
    events_.errors |= plant::bit(plant::Error::kCommandNotFinite);
    return;
  }
  command_ = tau;
  state_.command_seq = command.header.seq;
  state_.command_state_ns = command.origin.state_ns;
  events_.command = true;
}

void Door::judge() noexcept {
  plant::Measured measured;
  measured.q = arm_.q;
  measured.dq = arm_.dq;
  measured.tau = arm_.tau;
  measured.p_WE = arm_.p_WE;
  plant::Findings findings;
  plant::judge_limits(measured, parameters_, findings);
  if (commanded_) watch_.judge(events_.command, findings);
  if (findings.errors != 0 && mode_.errors == 0) state_.cause = findings.first;
  events_.errors |= findings.errors;
}

void Door::enter(plant::ModeState next) noexcept {
  if (next.mode == Mode::kMove && mode_.mode != Mode::kMove) watch_.begin();
  if (next.mode != Mode::kMove && mode_.mode == Mode::kMove) standing_ = 0;
  if (next.errors == 0) state_.cause = {};
  mode_ = next;
}

const Door::Output& Door::step(std::int64_t now_ns, const wire::RobotCommand* command,
                               const wire::RobotMotion* motion) noexcept {
  state_.time += plant::kCycle;
  if (motion != nullptr) ++counters_.refused_motions;
  if (command != nullptr) take(*command);
  if (mode_.mode == Mode::kMove) judge();
  if (arm_.mode == Mode::kUserStopped) events_.stop = true;
  events_.guide = arm_.mode == Mode::kGuiding;
  events_.release = !events_.guide;
  events_.recover = watch_.back(events_.command, waits_for_commands()) || events_.recover;
  if (arm_.mode == Mode::kReflex && !recovery_wanted_) {
    events_.recover = false;
    stopped_by_robot(arm_.errors);
  }
  enter(plant::next(mode_, events_));
  const bool came = events_.command;
  events_ = {};

  const bool moves = mode_.mode == Mode::kMove;
  if (moves && commanded_) {
    watch_.count(came);
    state_.lost_commands = watch_.lost();
  } else if (!moves) {
    watch_.rest();
  }
  torque_ = !commanded_ ? Vector7d::Zero().eval() : limited(moves ? command_ : brake());

  state_.q = arm_.q;
  state_.dq = arm_.dq;
  state_.tau = arm_.tau;
  state_.p_WE = arm_.p_WE;
  state_.q_WE = arm_.q_WE;
  state_.external = arm_.external;
  state_.contacts = arm_.contacts;
  state_.mode = mode_.mode;
  state_.errors = mode_.errors;
  // the link to the robot may lose what came to us
  state_.command_success_rate = commanded_
                                    ? std::min(watch_.success_rate(), arm_.command_success_rate)
                                    : watch_.success_rate();
  count(mode_.mode);
  wire::fill_robot_state(output_.state, state_);
  output_.contact_due = contact_.due(now_ns, state_, output_.contact);
  return output_;
}

Vector7d Door::brake() noexcept {
  standing_ = arm_.dq.cwiseAbs().maxCoeff() < kAtRest ? standing_ + 1 : 0;
  return -kDamping.cwiseProduct(arm_.dq);
}

Vector7d Door::limited(const Vector7d& wanted) noexcept {
  const plant::JointLimits& limits = parameters_.limits;
  const Vector7d step = Vector7d::Constant(limits.tau_rate_max * plant::kCycle);
  Vector7d tau = wanted.cwiseMin(arm_.tau + step)
                     .cwiseMax(arm_.tau - step)
                     .cwiseMin(limits.tau_max)
                     .cwiseMax(-limits.tau_max);
  if (tau != wanted) ++state_.saturated_cycles;
  return tau;
}

bool Door::wants_control() const noexcept {
  if (failed_) return false;
  return mode_.mode == Mode::kMove || (commanded_ && standing_ < kStands);
}

void Door::stopped_by_robot(Errors errors) noexcept {
  failed_ = true;
  commanded_ = false;
  if (*arm_.cause.unit != '\0') state_.cause = arm_.cause;
  if (mode_.mode != Mode::kUserStopped) enter({Mode::kReflex, mode_.errors | errors});
}

void Door::recovered(bool worked) noexcept {
  recovery_wanted_ = false;
  if (!worked) return;
  failed_ = false;
  arm_.mode = Mode::kIdle;
  events_.recover = true;
}

void Door::settled(bool worked) noexcept {
  if (!ordered_) return;
  answer(*ordered_, worked ? plant::Outcome::kObeyed : plant::Outcome::kRefused);
  ordered_.reset();
}

std::string Door::refusal(plant::OrderKind kind) const {
  switch (kind) {
    case plant::OrderKind::kDropCommands:
    case plant::OrderKind::kEndFaults:
    case plant::OrderKind::kThresholds:
      return "";
    case plant::OrderKind::kGuide:
    case plant::OrderKind::kRelease:
      return "a robot that is not simulated is guided by the buttons at its flange alone";
    case plant::OrderKind::kPressStop:
    case plant::OrderKind::kReleaseStop:
      return "a robot that is not simulated has a stop button of its own; c3rt stop stops it, too";
    case plant::OrderKind::kPushArm:
      return "nobody pushes a robot that is not simulated but a hand";
    default:
      return "a robot that is not simulated has no fault but drop-commands";
  }
}

std::string Door::refusal_of_motions() const {
  return "this robot takes torques alone, on robot/command";
}

bool Door::waits_for_commands() const noexcept {
  return parameters_.recovers_alone && !failed_ && mode_.mode == Mode::kReflex &&
         mode_.errors == plant::bit(plant::Error::kCommunicationConstraintsViolation);
}

}  // namespace c3rt::real_robot
