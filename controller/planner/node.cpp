#include "controller/planner/node.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "controller/base/time.hpp"
#include "idl/convert.hpp"

namespace c3rt::planner {
namespace {

using base::nanoseconds;
using base::seconds;

constexpr long kRobot = 0;
constexpr double kCommandTimeout = 0.1;  // [s]

struct DeadlineClock {
  std::int64_t (*now_ns)() noexcept;
  std::int64_t at_ns;
  static bool reached(void* context) noexcept {
    const DeadlineClock& self = *static_cast<DeadlineClock*>(context);
    return self.now_ns() >= self.at_ns;
  }
};

BodyInput body_input(const wire::ObjectEstimate& seen, std::int64_t now_ns) {
  BodyInput input{seen.valid, seconds(now_ns - seen.exposure_ns), wire::body(seen)};
  input.body.a_WB = wire::vector(seen.a_WB_m_per_s2).head<2>();
  return input;
}

}  // namespace

Node::Node(const Parameters& parameters, model::Arm arm, const Clock& clock,
           const c3::Parallel& parallel)
    : parameters_(parameters),
      clock_(clock),
      planner_(parameters, parallel),
      arm_(std::move(arm)),
      solve_time_(clock.solve_time) {}

planner::Input Node::planner_input(std::int64_t now_ns, const Input& in) {
  planner::Input input{};
  input.now = seconds(now_ns);
  input.target = in.target;
  input.stopped = in.stopped;
  input.solve_time = solve_time_;
  input.state_age = in.has_state ? seconds(now_ns - in.state.header.time_ns)
                                 : std::numeric_limits<double>::infinity();
  input.robot_follows = in.has_state && in.state.mode == c3rt_v2_ROBOT_MOVE &&
                        in.command.mode == c3rt_v2_IMPEDANCE_TRACK &&
                        seconds(now_ns - in.command.header.time_ns) <= kCommandTimeout;
  if (in.has_state) {
    model::ArmState arm_state;
    arm_.update(wire::vector(in.state.q_rad), wire::vector(in.state.dq_rad_per_s), arm_state);
    input.effector.p_WE = arm_state.X_WE.translation();
    input.effector.v_WE = arm_state.V_WE.head<3>();
  }
  for (std::size_t i = 0; i < in.objects.size(); ++i) {
    if (in.objects[i]) input.bodies[i] = body_input(*in.objects[i], now_ns);
  }
  return input;
}

const Node::Output& Node::step(std::int64_t now_ns, const Input& in) {
  const std::int64_t started_ns = clock_.now_ns();
  DeadlineClock deadline{
      clock_.now_ns, started_ns + nanoseconds(parameters_.deadline_fraction / parameters_.rate)};
  const Plan& plan = planner_.step(
      planner_input(now_ns, in),
      clock_.realtime ? c3::Deadline{&DeadlineClock::reached, &deadline} : c3::Deadline{});
  output_.measured = seconds(clock_.now_ns() - started_ns);
  if (clock_.realtime) solve_time_ = output_.measured;
  output_.plans = in.has_state && plan.mode != Mode::kWait;
  if (!output_.plans) return output_;

  const std::int64_t solved_ns =
      clock_.realtime ? clock_.now_ns() : now_ns + nanoseconds(clock_.solve_time);
  output_.effective_ns = std::max(now_ns + nanoseconds(parameters_.publish_delay), solved_ns);
  fill_plan(plan, in);
  output_.plan.solve_time_s = output_.measured;
  output_.plan.valid_until_ns = output_.effective_ns + nanoseconds(parameters_.valid_for);
  if (in.spoilt) output_.plan.knots[0].p_WE_m[0] = std::numeric_limits<double>::quiet_NaN();
  output_.debug = {};
  output_.debug.robot = kRobot;
  output_.debug.horizon = parameters_.N;
  wire::fill_debug(output_.debug, plan);
  return output_;
}

void Node::fill_plan(const Plan& plan, const Input& in) noexcept {
  wire::Plan& out = output_.plan;
  out = {};
  out.robot = kRobot;
  out.origin.state_ns = in.state.header.time_ns;
  if (const auto& object = in.objects[static_cast<std::size_t>(plan.body)]) {
    out.origin.exposure_ns = object->exposure_ns;
    out.origin.estimate_ns = object->header.time_ns;
  }
  wire::fill_plan(out, plan, output_.effective_ns + nanoseconds(plan.delta_t_c));
}

}  // namespace c3rt::planner
