#include "controller/impedance/servo.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "controller/rt/periodic_clock.hpp"

namespace c3rt::impedance {

namespace {

constexpr double kSecondsPerNs = 1e-9;
static_assert(c3rt_v2_MAX_KNOTS == kMaxKnots, "room for every knot of a plan");
constexpr double kStanding = 0.02;  // [rad/s]

Eigen::Vector3d to_vector(const double (&v)[3]) noexcept {
  return Eigen::Vector3d(v[0], v[1], v[2]);
}
void from_vector(const Eigen::Vector3d& v, double (&out)[3]) noexcept {
  Eigen::Map<Eigen::Vector3d>{out} = v;
}

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
  input.q = Eigen::Map<const Vector7d>(state.q_rad);
  input.dq = Eigen::Map<const Vector7d>(state.dq_rad_per_s);
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
    knot.p_WE = to_vector(from.p_WE_m);
    knot.v_WE = to_vector(from.v_WE_m_per_s);
    knot.q_WE = Eigen::Quaterniond(from.q_WE[0], from.q_WE[1], from.q_WE[2], from.q_WE[3]);
    knot.force_E = to_vector(from.force_E_n);
  }
}

}  // namespace

Servo::Servo(wire::Bus& bus, const Parameters& parameters, model::Arm arm, rt::Statistics& compute)
    : realtime_(bus.clock() == wire::ClockMode::kRealtime),
      states_(bus, &state_arrival_),
      plans_(bus),
      commands_(bus),
      controller_(parameters, std::move(arm)),
      compute_(compute) {}

void Servo::cycle(std::int64_t now_ns) noexcept {
  if (faults_.stalls(now_ns)) return;

  const std::int64_t begin_ns = rt::now_ns();
  take_samples(realtime_ ? begin_ns : now_ns);
  input_.now_ns = realtime_ ? rt::now_ns() : now_ns;
  input_.stop = stop_.exchange(false);
  input_.recover = recover_.exchange(false);
  const Output output = controller_.step(input_);
  if (output.commands) send(output, now_ns);
  compute_.add(static_cast<double>(rt::now_ns() - begin_ns) * kSecondsPerNs);

  ++snapshot_.cycle;
  snapshot_.mode = output.mode;
  snapshot_.stop_reason = output.stop_reason;
  snapshot_.ends_alone = output.ends_alone;
  snapshot_.plan = output.plan;
  snapshot_.robot_moves = input_.robot_moves;
  snapshot_.standing = input_.dq.cwiseAbs().maxCoeff() < kStanding;
  snapshot_.steady_cycles = output.steady_cycles;
  snapshot_.counters = output.counters;
  snapshots_.put(snapshot_);
}

void Servo::take_samples(std::int64_t now_ns) noexcept {
  if (states_.take(now_ns, state_)) unpack(state_, input_);
  if (plans_.take(now_ns, plan_)) unpack(plan_, input_);
}

void Servo::send(const Output& output, std::int64_t now_ns) noexcept {
  command_.robot = state_.robot;
  command_.origin = {};
  if (output.mode == Mode::kTrack) {
    command_.origin = plan_.origin;
    command_.origin.plan_ns = plan_.header.time_ns;
  }
  command_.origin.state_ns = state_.header.time_ns;
  Eigen::Map<Vector7d>{command_.tau_nm} = output.tau;
  if (faults_.spoils(now_ns)) command_.tau_nm[0] = std::numeric_limits<double>::quiet_NaN();
  command_.mode = to_wire(output.mode);
  from_vector(output.p_WE_desired, command_.p_WE_desired_m);
  from_vector(output.v_WE_desired, command_.v_WE_desired_m_per_s);

  const std::int64_t sent_ns = realtime_ ? rt::now_ns() : now_ns;
  commands_.put(command_, sent_ns);
  state_to_command_.add(static_cast<double>(sent_ns - state_.header.time_ns) * kSecondsPerNs);
}

}  // namespace c3rt::impedance
