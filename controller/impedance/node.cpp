#include "controller/impedance/node.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "idl/convert.hpp"

namespace c3rt::impedance {

namespace {

static_assert(c3rt_v2_MAX_KNOTS == kMaxKnots, "room for every knot of a plan");
constexpr double kStanding = 0.02;  // [rad/s]

PlanStatus status_of(c3rt_v2_PlanStatus status) noexcept {
  switch (status) {
    case c3rt_v2_PLAN_OK:
      return PlanStatus::kOk;
    case c3rt_v2_PLAN_TRUNCATED:
      return PlanStatus::kTruncated;
    case c3rt_v2_PLAN_FALLBACK:
      return PlanStatus::kFallback;
  }
  return PlanStatus::kUnknown;
}

c3rt_v2_ImpedanceMode to_wire(Mode mode) noexcept {
  switch (mode) {
    case Mode::kWait:
      return c3rt_v2_IMPEDANCE_WAIT;
    case Mode::kHold:
      return c3rt_v2_IMPEDANCE_HOLD;
    case Mode::kTrack:
      return c3rt_v2_IMPEDANCE_TRACK;
    case Mode::kStop:
      break;
  }
  return c3rt_v2_IMPEDANCE_STOP;
}

void unpack(const wire::RobotState& state, Input& input) noexcept {
  input.has_state = true;
  input.session_id = state.header.session_id;
  input.state_stamp_ns = state.header.time_ns;
  input.q = wire::vector(state.q_rad);
  input.dq = wire::vector(state.dq_rad_per_s);
  input.robot_moves = state.mode == c3rt_v2_ROBOT_IDLE || state.mode == c3rt_v2_ROBOT_MOVE;
}

void unpack(const wire::Plan& plan, Input& input) noexcept {
  input.has_plan = true;
  input.plan.session_id = plan.header.session_id;
  input.plan.stamp_ns = plan.header.time_ns;
  input.plan.valid_until_ns = plan.valid_until_ns;
  input.plan.status = status_of(plan.status);
  input.plan.knot_count = std::clamp(static_cast<int>(plan.knot_count), 0, kMaxKnots);
  for (int i = 0; i < input.plan.knot_count; ++i) {
    const c3rt_v2_Knot& from = plan.knots[i];
    Knot& knot = input.plan.knots[static_cast<std::size_t>(i)];
    knot.time_ns = from.time_ns;
    knot.p_WE = wire::vector(from.p_WE_m);
    knot.v_WE = wire::vector(from.v_WE_m_per_s);
    knot.q_WE = wire::quaternion(from.q_WE);
    knot.force_E = wire::vector(from.force_E_n);
  }
}

}  // namespace

Node::Node(const Parameters& parameters, model::Arm arm)
    : controller_(parameters, std::move(arm)) {}

const Node::Output& Node::step(std::int64_t now_ns, const Input& in) noexcept {
  if (in.state != nullptr) {
    robot_ = in.state->robot;
    unpack(*in.state, input_);
  }
  if (in.plan != nullptr) {
    plan_origin_ = in.plan->origin;
    plan_origin_.plan_ns = in.plan->header.time_ns;
    unpack(*in.plan, input_);
  }
  input_.now_ns = now_ns;
  input_.stop = in.stop;
  input_.recover = in.recover;
  output_.control = controller_.step(input_);
  output_.commands = output_.control.commands;
  output_.robot_moves = input_.robot_moves;
  output_.standing = input_.dq.cwiseAbs().maxCoeff() < kStanding;
  if (!output_.commands) return output_;
  fill_command();
  if (in.spoilt) output_.command.tau_nm[0] = std::numeric_limits<double>::quiet_NaN();
  return output_;
}

void Node::fill_command() noexcept {
  const impedance::Output& control = output_.control;
  wire::RobotCommand& command = output_.command;
  command.robot = robot_;
  command.origin = control.mode == Mode::kTrack ? plan_origin_ : wire::Origin{};
  command.origin.state_ns = input_.state_stamp_ns;
  command.mode = to_wire(control.mode);
  wire::fill(command.tau_nm, control.tau);
  wire::fill(command.p_WE_desired_m, control.p_WE_desired);
  wire::fill(command.v_WE_desired_m_per_s, control.v_WE_desired);
}

}  // namespace c3rt::impedance
