#include "plant_emulator/node.hpp"

#include <limits>

#include "controller/base/time.hpp"
#include "idl/convert.hpp"
#include "plant_emulator/start.hpp"

namespace c3rt::plant {
namespace {

constexpr std::int64_t kScenePeriodNs = 10'000'000;  // truth for the recorder, beside the exposures

c3rt_v2_RobotMode robot_mode(Mode mode) noexcept {
  switch (mode) {
    case Mode::kIdle:
      return c3rt_v2_ROBOT_IDLE;
    case Mode::kMove:
      return c3rt_v2_ROBOT_MOVE;
    case Mode::kReflex:
      return c3rt_v2_ROBOT_REFLEX;
    case Mode::kUserStopped:
      return c3rt_v2_ROBOT_USER_STOPPED;
  }
  return c3rt_v2_ROBOT_REFLEX;
}

void fill_state(wire::RobotState& sample, const State& state) noexcept {
  sample = {};
  wire::fill(sample.q_rad, state.q);
  wire::fill(sample.dq_rad_per_s, state.dq);
  wire::fill(sample.tau_nm, state.tau);
  wire::fill(sample.p_WE_m, state.p_WE);
  wire::fill(sample.q_WE, state.q_WE);
  sample.mode = robot_mode(state.mode);
  sample.errors = state.errors;
  sample.command_success_rate = state.command_success_rate;
  sample.command_seq = state.command_seq;
  sample.command_state_ns = state.command_state_ns;
}

void fill_scene(wire::Scene& sample, const State& state, bool exposure) noexcept {
  sample = {};
  sample.exposure = exposure;
  wire::fill(sample.q_rad, state.q);
  wire::fill(sample.p_WE_m, state.p_WE);
  sample.object_count = state.object_count;
  for (int i = 0; i < state.object_count; ++i)
    wire::fill_motion(sample.objects[i], state.objects[static_cast<std::size_t>(i)]);
}

}  // namespace

Node::Node(const Parameters& parameters, double exposure_rate, std::uint64_t seed)
    : plant_(drawn_start(parameters, seed)),
      exposure_(base::nanoseconds(1.0 / exposure_rate)),
      scene_(kScenePeriodNs),
      pushes_(drawn_pushes(parameters.pushes, static_cast<int>(parameters.world.objects.size()),
                           seed)) {}

void Node::obey(const Order& order) noexcept {
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
    case OrderKind::kStall:
      break;
  }
  ++counters_.faults;
}

const Node::Output& Node::step(std::int64_t now_ns, const wire::RobotCommand* command) noexcept {
  if (command != nullptr) {
    plant_.set_command(wire::vector(command->tau_nm), command->header.seq,
                       command->origin.state_ns);
  }
  // the scenario's own pushes take the way of a client's, but at the same instant in every run
  for (; pushed_ < pushes_.size() && pushes_[pushed_].time <= plant_.state().time; ++pushed_)
    obey({OrderKind::kPushObject, pushes_[pushed_].object, 0.0, pushes_[pushed_].impulse});
  plant_.step_1ms();
  const Mode mode = plant_.state().mode;
  if (mode == Mode::kReflex && mode_ != Mode::kReflex) ++counters_.reflexes;
  counters_.moving_cycles = mode == Mode::kMove ? counters_.moving_cycles + 1 : 0;
  mode_ = mode;
  return observe(now_ns);
}

const Node::Output& Node::observe(std::int64_t now_ns) noexcept {
  const State& state = plant_.state();
  fill_state(output_.state, state);
  if (state.time < nan_until_) output_.state.q_rad[0] = std::numeric_limits<double>::quiet_NaN();
  const bool exposure = exposure_.due(now_ns);
  output_.scene_due = scene_.due(now_ns) || exposure;
  if (exposure) ++counters_.exposures;
  if (output_.scene_due) fill_scene(output_.scene, state, exposure);
  return output_;
}

}  // namespace c3rt::plant
