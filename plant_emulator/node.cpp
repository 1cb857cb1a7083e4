#include "plant_emulator/node.hpp"

#include <limits>

#include "controller/base/time.hpp"
#include "idl/convert.hpp"
#include "plant_emulator/start.hpp"

namespace c3rt::plant {
namespace {

constexpr std::int64_t kScenePeriodNs = 10'000'000;  // truth for the recorder, beside the exposures

/// Something began or ended between the two.
bool changed(const wire::RobotContact& a, const State& b) noexcept {
  return a.joint_contact != b.contacts.joint || a.cartesian_contact != b.contacts.cartesian ||
         a.joint_collision != b.contacts.joint_collision ||
         a.cartesian_collision != b.contacts.cartesian_collision || a.errors != b.errors ||
         a.guided != (b.mode == Mode::kGuiding);
}

}  // namespace

bool ContactReport::due(std::int64_t now_ns, const State& state,
                        wire::RobotContact& sample) noexcept {
  const bool news = changed(sample, state);
  if (!schedule_.due(now_ns) && !news) return false;
  wire::fill_robot_contact(sample, state);
  return true;
}

void RobotNode::count(Mode mode) noexcept {
  if (mode == Mode::kReflex && mode_ != Mode::kReflex) ++counters_.reflexes;
  counters_.moving_cycles = mode == Mode::kMove ? counters_.moving_cycles + 1 : 0;
  mode_ = mode;
}

Node::Node(const Parameters& parameters, double exposure_rate, std::uint64_t seed)
    : plant_(drawn_start(parameters, seed)),
      exposure_(base::nanoseconds(1.0 / exposure_rate)),
      scene_(kScenePeriodNs),
      pushes_(drawn_pushes(parameters.pushes, static_cast<int>(parameters.world.objects.size()),
                           seed)) {
  // what MuJoCo warns about becomes a named error of the robot; it shall not write a log file of
  // its own
  mju_user_warning = [](const char*) {};
}

Outcome Node::outcome_of(const Order& order) noexcept {
  switch (order.kind) {
    case OrderKind::kGuide:
      if (plant_.request_guiding(order.axes)) break;
      return plant_.stop_pressed() ? Outcome::kStopPressed : Outcome::kMoves;
    case OrderKind::kRelease:
      plant_.release();
      break;
    case OrderKind::kThresholds:
      return plant_.set_collision_behavior(order.behavior) ? Outcome::kObeyed : Outcome::kMoves;
    case OrderKind::kPushArm:
      plant_.pull(order.value, order.duration);
      break;
    case OrderKind::kPressStop:
    case OrderKind::kReleaseStop:
      plant_.press_stop(order.kind == OrderKind::kPressStop);
      break;
    default:
      break;
  }
  return Outcome::kObeyed;
}

void Node::obey(const Order& order) noexcept {
  if (is_answered(order.kind)) {
    answer(order, outcome_of(order));
    return;
  }
  switch (order.kind) {
    case OrderKind::kRecover:
      plant_.request_recovery();
      return;
    case OrderKind::kStop:
      plant_.request_stop();
      return;
    case OrderKind::kPushObject:
      plant_.push(order.index, order.value);
      break;
    case OrderKind::kDropCommands:
      plant_.drop_commands(order.duration);
      break;
    case OrderKind::kNan:
      nan_until_ = plant_.state().time + order.duration;
      break;
    case OrderKind::kEndFaults:
      plant_.drop_commands(0);
      nan_until_ = 0;
      break;
    default:  // a stall
      break;
  }
  ++counters_.faults;
}

const Node::Output& Node::step(std::int64_t now_ns, const wire::RobotCommand* command,
                               const wire::RobotMotion* motion) noexcept {
  if (command != nullptr) {
    plant_.set_command(wire::vector(command->tau_nm), command->header.seq,
                       command->origin.state_ns);
  }
  if (motion != nullptr) {
    wire::read_motion(*motion, motion_);
    if (!plant_.set_motion(motion_, motion->header.seq, motion->origin.state_ns))
      ++counters_.refused_motions;
  }
  // the scenario's own pushes take the way of a client's, but at the same instant in every run
  for (; pushed_ < pushes_.size() && pushes_[pushed_].time <= plant_.state().time; ++pushed_)
    obey({OrderKind::kPushObject, pushes_[pushed_].object, 0.0, pushes_[pushed_].impulse});
  plant_.step_1ms();
  count(plant_.state().mode);
  return observe(now_ns);
}

const Node::Output& Node::observe(std::int64_t now_ns) noexcept {
  const State& state = plant_.state();
  wire::fill_robot_state(output_.state, state);
  if (state.time < nan_until_) output_.state.q_rad[0] = std::numeric_limits<double>::quiet_NaN();
  const bool exposure = exposure_.due(now_ns);
  output_.scene_due = scene_.due(now_ns) || exposure;
  if (exposure) ++counters_.exposures;
  output_.contact_due = contact_.due(now_ns, state, output_.contact);
  if (output_.scene_due) {
    wire::fill_scene(output_.scene, state);
    output_.scene.exposure = exposure;
  }
  return output_;
}

}  // namespace c3rt::plant
