// c3rt-planner: robot state and object estimates in, plan out, at a fixed rate.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <optional>
#include <string>

#include <spdlog/spdlog.h>

#include "config/process_options.hpp"
#include "config/scenario.hpp"
#include "controller/base/time.hpp"
#include "controller/model/arm.hpp"
#include "controller/planner/planner.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "controller/task/circle.hpp"
#include "idl/bus_settings.hpp"
#include "idl/dds.hpp"
#include "idl/endpoint.hpp"
#include "idl/process.hpp"
#include "idl/text.hpp"

namespace {

using namespace c3rt;

constexpr long kRobot = 0;
static_assert(c3rt_v2_MAX_OBJECTS == scene::kMaxBodies,
              "the wire has room for every body of a scene");
constexpr double kCommandTimeout = 0.1;  // [s]
constexpr int kPriority = 40;  // below the 1 kHz loop and what carries its samples, above vision

using base::nanoseconds;
using base::seconds;
Eigen::Vector3d vector(const double (&a)[3]) { return {a[0], a[1], a[2]}; }
template <std::size_t n, typename Derived>
void fill(double (&out)[n], const Eigen::MatrixBase<Derived>& values) {
  const auto count = std::min<Eigen::Index>(static_cast<Eigen::Index>(n), values.size());
  for (Eigen::Index i = 0; i < count; ++i) out[i] = values[i];
}

/// Newest samples of what the planner listens to.
struct Inputs {
  explicit Inputs(wire::Bus& bus) : states(bus), commands(bus), estimates(bus), targets(bus) {}
  wire::Reader<wire::RobotState> states;
  wire::Reader<wire::RobotCommand> commands;
  wire::Reader<wire::ObjectEstimate> estimates;
  wire::Reader<wire::TaskTarget> targets;
  wire::RobotState state{};
  wire::RobotCommand command{};
  std::array<std::optional<wire::ObjectEstimate>, scene::kMaxBodies> objects;  // by key
  bool has_state = false, stopped = false;
  planner::Target target = planner::ScenarioTarget{};
  wire::FaultWindows faults;
};

// what strangers write is checked: an object that the scenario does not have is nobody's
void take_estimates(Inputs& in, int objects, std::int64_t now_ns) {
  wire::ObjectEstimate estimate{};
  while (in.estimates.take_next_effective(now_ns, estimate)) {
    if (estimate.object_index >= 0 && estimate.object_index < objects)
      in.objects[static_cast<std::size_t>(estimate.object_index)] = estimate;
  }
}

planner::Target target_of(const wire::TaskTarget& sample) {
  const Eigen::Vector2d at(sample.center_m[0], sample.center_m[1]);
  switch (sample.kind) {
    case c3rt_v2_TARGET_SCENARIO:
      return planner::ScenarioTarget{};
    case c3rt_v2_TARGET_HOLD:
      return planner::HoldTarget{};
    case c3rt_v2_TARGET_CIRCLE:
      return task::Circle{at, sample.radius_m, sample.lead_rad};
    case c3rt_v2_TARGET_POINT:
      return planner::PointTarget{at};
  }
  return planner::HoldTarget{};  // no other kind passes the reader
}

void take_targets(Inputs& in, const planner::TargetLimits& limits, wire::Replies& replies,
                  std::int64_t now_ns) {
  replies.answer_refused(in.targets, now_ns);
  wire::TaskTarget sample{};
  while (in.targets.take(sample)) {
    const planner::Target target = target_of(sample);
    const std::string refused = planner::check(target, limits).sentence;
    if (refused.empty()) in.target = target;
    const std::string said = refused.empty() ? planner::describe(in.target) : "refused: " + refused;
    replies.answer(sample.request_id, refused.empty(), said, now_ns);
    spdlog::log(refused.empty() ? spdlog::level::info : spdlog::level::warn, "planner: target {}",
                said);
  }
}

std::string describe(const Inputs& in) {
  return in.stopped ? "holding until recover" : "planning: " + planner::describe(in.target);
}

void serve_clients(Inputs& in, wire::Endpoint& endpoint, std::int64_t now_ns) {
  endpoint.serve_requests(now_ns, [&in](c3rt_v2_RequestVerb verb) -> std::optional<wire::Answer> {
    in.stopped = verb == c3rt_v2_REQUEST_STOP;  // or it is to recover
    return wire::Answer{true, describe(in)};
  });
  endpoint.serve_faults(now_ns, [&in, now_ns](const wire::FaultInject& fault) {
    in.faults.begin(fault, now_ns);
    return std::string();
  });
}

planner::BodyInput body_input(const wire::ObjectEstimate& seen, std::int64_t now_ns) {
  return {seen.valid,
          seconds(now_ns - seen.exposure_ns),
          {vector(seen.p_WB_m),
           Eigen::Quaterniond(seen.q_WB[0], seen.q_WB[1], seen.q_WB[2], seen.q_WB[3]),
           vector(seen.v_WB_m_per_s), vector(seen.omega_rad_per_s)}};
}

planner::Input planner_input(const Inputs& in, std::int64_t now_ns, model::Arm& arm,
                             double solve_time) {
  planner::Input input{};
  input.now = seconds(now_ns);
  input.target = in.target;
  input.stopped = in.stopped;
  input.solve_time = solve_time;
  input.state_age = in.has_state ? seconds(now_ns - in.state.header.time_ns)
                                 : std::numeric_limits<double>::infinity();
  input.robot_follows = in.has_state && in.state.mode == c3rt_v2_ROBOT_MOVE &&
                        in.command.mode == c3rt_v2_IMPEDANCE_TRACK &&
                        seconds(now_ns - in.command.header.time_ns) <= kCommandTimeout;
  if (in.has_state) {
    model::ArmState arm_state;
    arm.update(Eigen::Map<const model::Vector7d>(in.state.q_rad),
               Eigen::Map<const model::Vector7d>(in.state.dq_rad_per_s), arm_state);
    input.effector.p_WE = arm_state.X_WE.translation();
    input.effector.v_WE = arm_state.V_WE.head<3>();
  }
  for (std::size_t i = 0; i < in.objects.size(); ++i) {
    if (in.objects[i]) input.bodies[i] = body_input(*in.objects[i], now_ns);
  }
  return input;
}

/// @param effective_ns from when on it is followed
wire::Plan to_wire(const planner::Plan& plan, const Inputs& in, std::int64_t effective_ns) {
  wire::Plan out{};
  out.robot = kRobot;
  out.origin.state_ns = in.state.header.time_ns;
  if (const auto& object = in.objects[static_cast<std::size_t>(plan.body)]) {
    out.origin.exposure_ns = object->exposure_ns;
    out.origin.estimate_ns = object->header.time_ns;
  }
  out.status = plan.status == planner::PlanStatus::kOk          ? c3rt_v2_PLAN_OK
               : plan.status == planner::PlanStatus::kTruncated ? c3rt_v2_PLAN_TRUNCATED
                                                                : c3rt_v2_PLAN_FALLBACK;
  wire::set_text(out.phase, plan.phase);
  out.knot_count = 1;
  c3rt_v2_Knot& knot = out.knots[0];
  knot.time_ns = effective_ns + nanoseconds(plan.delta_t_c);
  fill(knot.p_WE_m, plan.p_WE);
  fill(knot.v_WE_m_per_s, plan.v_WE);
  fill(knot.q_WE, Eigen::Vector4d(plan.q_WE.w(), plan.q_WE.x(), plan.q_WE.y(), plan.q_WE.z()));
  fill(knot.force_E_n, plan.force_E);
  return out;
}

/// One step after the other.
template <std::size_t n>
void fill_horizon(double (&out)[n], const Eigen::MatrixXd& values) {
  fill(out, values.reshaped());
}

wire::PlannerDebug debug_to_wire(const planner::Plan& plan, const planner::Parameters& parameters) {
  wire::PlannerDebug out{};
  out.robot = kRobot;
  out.object_index = plan.body;
  fill(out.p_WB_target_m, plan.body_target);
  out.delta_t_c_s = plan.delta_t_c;
  out.horizon = parameters.N;
  out.state_count = static_cast<int>(plan.x.rows());
  out.force_count = static_cast<int>(plan.lambda.rows());
  out.input_count = static_cast<int>(plan.u.rows());
  fill(out.u_c3, plan.u_c3);
  fill(out.lambda_d, plan.lambda_d);
  fill_horizon(out.states, plan.x);
  fill_horizon(out.forces, plan.lambda);
  fill_horizon(out.inputs, plan.u);
  out.admm_iterations = std::min<int>(plan.admm_iterations, c3rt_v2_MAX_ADMM);
  fill(out.primal_residual, plan.primal_residual.head(std::min<Eigen::Index>(
                                plan.primal_residual.size(), out.admm_iterations)));
  out.complementarity_violation = plan.complementarity_violation;
  return out;
}

/// What the planner is doing, in its status; and in the log where that is not its ordinary work.
class Teller {
 public:
  Teller(wire::Endpoint& endpoint, const planner::Parameters& parameters)
      : endpoint_(endpoint), parameters_(parameters) {}

  void tell(const planner::Activity& activity, double now) {
    const std::string text = planner::describe(activity, parameters_, now);
    const bool degraded = planner::needs_attention(activity);
    if (!endpoint_.say(degraded ? c3rt_v2_SERVICE_DEGRADED : c3rt_v2_SERVICE_RUNNING, text)) return;
    // a cause is told once, though its numbers go on
    const bool new_cause = activity.cause != told_.cause || activity.body != told_.body;
    const bool at_rest = activity.cause != planner::Cause::kNone && activity.mode != told_.mode;
    if (new_cause || at_rest) spdlog::info("planner: {}", text);
    told_ = activity;
  }

 private:
  wire::Endpoint& endpoint_;
  const planner::Parameters& parameters_;
  planner::Activity told_;
};

struct DeadlineClock {
  std::int64_t at_ns;
  static bool reached(void* context) noexcept {
    return rt::now_ns() >= static_cast<DeadlineClock*>(context)->at_ns;
  }
};

int run(const config::ProcessOptions& options) {
  const config::Scenario scenario = config::load_scenario(options.scenario_path, options.overrides);
  const planner::Parameters& parameters = scenario.planner;
  const bool realtime = options.clock == config::Clock::kRealtime;
  wire::Bus bus(wire::bus_settings(options));
  wire::Endpoint endpoint(
      bus, c3rt_v2_PROCESS_PLANNER, {}, [](bool attention, const std::string& said) {
        spdlog::log(attention ? spdlog::level::warn : spdlog::level::info, "planner: {}", said);
      });
  wire::StatusReporter& status = endpoint.status();
  auto& plans = status.counter("plans");
  auto& overruns = status.counter("overruns");
  auto& truncated = status.counter("truncated");
  auto& fallbacks = status.counter("fallbacks");
  auto& object_lost = status.counter("object_lost");

  planner::Planner planner(parameters);
  model::Arm arm(scenario.impedance.arm);
  Inputs in(bus);
  wire::Writer<wire::Plan> writer(bus);
  wire::Writer<wire::PlannerDebug> debug_writer(bus);
  const planner::TargetLimits limits = planner::target_limits(parameters);
  Teller teller(endpoint, parameters);
  const std::int64_t period_ns = nanoseconds(1.0 / parameters.rate);
  if (realtime) {
    const std::string refused = rt::setup_thread({kPriority, {}, false});
    if (!refused.empty()) spdlog::warn("NOT REAL-TIME: {}; plans will be late under load", refused);
  }
  wire::Loop loop(bus, {c3rt_v2_PROCESS_PLANNER, period_ns});
  double solve_time = scenario.timing.solve_time_s;
  endpoint.say(c3rt_v2_SERVICE_RUNNING, "waiting for the robot's state");
  spdlog::info("planner: start rate_hz={} N={} scenario={}", parameters.rate, parameters.N,
               scenario.name);

  std::int64_t now_ns = 0;
  while (loop.wait(now_ns)) {
    in.has_state |= in.states.take_effective(now_ns, in.state);
    in.commands.take_effective(now_ns, in.command);
    take_estimates(in, parameters.model.bodies, now_ns);
    take_targets(in, limits, endpoint.replies(), now_ns);
    serve_clients(in, endpoint, now_ns);
    if (in.faults.stalls(now_ns)) continue;

    const std::int64_t started_ns = rt::now_ns();
    DeadlineClock clock{started_ns + nanoseconds(parameters.deadline_fraction / parameters.rate)};
    const planner::Plan& plan =
        planner.step(planner_input(in, now_ns, arm, solve_time),
                     realtime ? c3::Deadline{&DeadlineClock::reached, &clock} : c3::Deadline{});
    const double measured = seconds(rt::now_ns() - started_ns);
    solve_time = realtime ? measured : scenario.timing.solve_time_s;
    status.compute().add(measured);
    if (measured > 1.0 / parameters.rate) ++overruns;

    // what does not know where the arm is asks nothing of it: without plans the arm is held
    if (in.has_state && plan.mode != planner::Mode::kWait) {
      // sent at once, in effect at a time that does not depend on how long the solve took
      const std::int64_t solved_ns =
          realtime ? rt::now_ns() : now_ns + nanoseconds(scenario.timing.solve_time_s);
      const std::int64_t effective_ns =
          std::max(now_ns + nanoseconds(parameters.publish_delay), solved_ns);
      wire::Plan out = to_wire(plan, in, effective_ns);
      out.solve_time_s = measured;
      out.valid_until_ns = effective_ns + nanoseconds(parameters.valid_for);
      if (in.faults.spoils(now_ns)) out.knots[0].p_WE_m[0] = std::nan("");
      writer.write(out, effective_ns);
      wire::PlannerDebug debug = debug_to_wire(plan, parameters);
      debug.plan_seq = out.header.seq;
      debug_writer.write(debug, effective_ns);
      ++plans;
    }
    truncated = planner.counters().truncated;
    fallbacks = planner.counters().fallbacks;
    object_lost = planner.counters().body_lost;
    teller.tell(planner.activity(), seconds(now_ns));
  }
  if (!loop.failure().empty()) {
    spdlog::error("planner: stop: {}", loop.failure());
    return config::kFailedWhileRunning;
  }
  spdlog::info(
      "planner: stop plans={} truncated={} fallbacks={} object_lost={} lcp_failures={} "
      "speed_clamped={}",
      plans.load(), planner.counters().truncated, planner.counters().fallbacks,
      planner.counters().body_lost, planner.counters().lcp_failures,
      planner.counters().speed_clamped);
  return config::kStopped;
}

}  // namespace

int main(int argc, char** argv) {
  int exit_status = 0;
  const auto options = c3rt::config::parse_process_options(
      argc, argv, "c3rt-planner",
      "Consensus complementarity control at a fixed rate: plans contact-implicit motion",
      exit_status);
  if (!options) return exit_status;
  const c3rt::wire::StopFlag stop;
  try {
    return run(*options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "c3rt-planner: %s\n", error.what());
    return c3rt::config::kCouldNotStart;
  }
}
