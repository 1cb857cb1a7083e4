#include "controller/impedance/node.hpp"

#include <limits>
#include <utility>

#include "idl/convert.hpp"

namespace c3rt::impedance {

namespace {

constexpr double kStanding = 0.02;  // [rad/s]

}  // namespace

Node::Node(const Parameters& parameters, model::Arm arm)
    : controller_(parameters, std::move(arm)) {}

const Node::Output& Node::step(std::int64_t now_ns, const Input& in) noexcept {
  if (in.state != nullptr) {
    robot_ = in.state->robot;
    input_.has_state = true;
    wire::read_robot_state(*in.state, input_);
    input_.answered_ns = in.state->command_state_ns;
  }
  if (in.plan != nullptr) {
    plan_origin_ = in.plan->origin;
    plan_origin_.plan_ns = in.plan->header.time_ns;
    input_.has_plan = true;
    wire::read_plan(*in.plan, input_.plan);
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
  wire::fill_command(command, control);
}

}  // namespace c3rt::impedance
