#include "cli/invariants/samples.hpp"

#include <algorithm>
#include <cmath>

#include "controller/base/time.hpp"
#include "idl/text.hpp"
#include "plant_emulator/errors.hpp"

namespace c3rt::cli::invariants {
namespace {

using base::seconds;

constexpr double kRounding = 1e-6;         // of limits that are kept exactly
constexpr double kFewCycles = 10.0;        // over more that was not heard no rate is known
constexpr double kWorkspaceMargin = 0.02;  // the arm lags behind what it is told [m]
constexpr std::size_t kMostPlans = 256;    // a second of the fastest planner
constexpr double kBrakesAfter = 21.0;      // cycles: in the next one it has stopped itself
constexpr double kLostCommands = 19.0;     // cycles: the twentieth stops the robot

SceneRow row_of(const wire::Scene& sample) {
  SceneRow row;
  row.time_ns = sample.header.time_ns;
  row.object_count = std::clamp(static_cast<int>(sample.object_count), 0, kMaxObjects);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.object_count); ++i) {
    const double(&p)[3] = sample.objects[i].p_WB_m;
    const double(&q)[4] = sample.objects[i].q_WB;
    row.p_WB[i] = Eigen::Vector3d(p[0], p[1], p[2]);
    row.q_WB[i] = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }
  return row;
}

template <int n>
Eigen::Matrix<double, n, 1> vector_of(const double (&values)[n]) {
  return Eigen::Map<const Eigen::Matrix<double, n, 1>>(values);
}

}  // namespace

Samples::Samples(const Limits& limits, const task::Task& task, Violations& violations)
    : limits_(limits), task_(task), violations_(violations), course_(task) {}

void Samples::violated(const char* name, const std::string& subject, std::int64_t time_ns,
                       double value, double limit, const char* unit) {
  violations_.add(name, subject, seconds(time_ns - first_ns_.value_or(time_ns)), value, limit,
                  unit);
}

void Samples::step(Stream& stream, const wire::Header& header, const char* subject) {
  ++samples_;
  if (!first_ns_) first_ns_ = header.time_ns;
  stream.begins_anew(header.seq);
  if (stream.seq != 0 && header.seq <= stream.seq) {
    violated("sequence", subject, header.time_ns, static_cast<double>(header.seq),
             static_cast<double>(stream.seq + 1), "");
  }
  const bool jumps = state_.time_ns <= jumps_until_ns_;
  if (stream.seq != 0 && header.time_ns < stream.time_ns && !jumps) {
    violated("time", subject, header.time_ns, seconds(header.time_ns - *first_ns_),
             seconds(stream.time_ns - *first_ns_), "s");
  }
  stream.seq = header.seq;
  stream.time_ns = header.time_ns;
}

void Samples::hear(const wire::Plan& sample) {
  step(plan_, sample.header, "plan");
  plans_.push_back({sample.header.time_ns, sample.valid_until_ns});
  if (plans_.size() > kMostPlans) plans_.pop_front();
  const bool begins = at_task_ && !task_start_ && wire::is_at_task(sample.phase) &&
                      sample.origin.state_ns >= task_not_before_ns_;
  if (begins) task_start_ = sample.origin.state_ns;
}

void Samples::hear(const wire::ObjectEstimate& sample) {
  step(estimate_, sample.header, "object/estimate");
  if (!vector_of(sample.p_WB_m).allFinite())
    violated("not_finite", "object/estimate", sample.header.time_ns, NAN, 0.0, "");
}

void Samples::hear(const wire::Scene& sample) {
  step(scene_, sample.header, "sim/scene");
  check_object(sample);
}

void Samples::check_object(const wire::Scene& sample) {
  const SceneRow row = row_of(sample);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.object_count); ++i) {
    const double away = (row.p_WB[i].head<2>() - task_.middle()).norm();
    if (!(away <= limits_.object_reach))
      violated("object_lost", "sim/scene", row.time_ns, away, limits_.object_reach, "m");
  }
  if (!at_task_ || !task_start_ || row.time_ns < *task_start_) return;
  const double elapsed = seconds(row.time_ns - *task_start_);
  course_.add(elapsed, row);
  if (!(elapsed >= course_.progress().judged_from())) return;
  const double error = worst_error(task_, elapsed, row);
  if (error > limits_.object_error)
    violated("object", "sim/scene", row.time_ns, error, limits_.object_error, "m");
}

void Samples::check_torque(const Vector7d& tau, const char* subject, std::int64_t time_ns) {
  if (!tau.allFinite()) {
    violated("not_finite", subject, time_ns, NAN, 0.0, "");
    return;
  }
  Eigen::Index worst = 0;
  const double excess = (tau.cwiseAbs() - limits_.tau_max).maxCoeff(&worst);
  if (excess > kRounding)
    violated("torque", subject, time_ns, std::abs(tau[worst]), limits_.tau_max[worst], "N m");
}

void Samples::check_rate(const Torque& before, const Torque& now, const char* subject) {
  if (before.seq == 0 || now.seq <= before.seq || !before.tau.allFinite() || !now.tau.allFinite())
    return;
  const double passed = std::round(seconds(now.time_ns - before.time_ns) / limits_.cycle);
  const double cycles = std::max(static_cast<double>(now.seq - before.seq), passed);
  if (cycles > kFewCycles) return;
  const double replaced = limits_.realtime ? 1.0 : 0.0;
  const double limit = limits_.tau_rate_max * limits_.cycle * (cycles + replaced);
  const double change = (now.tau - before.tau).cwiseAbs().maxCoeff();
  if (change > limit + kRounding)
    violated("torque_rate", subject, now.time_ns, change / (cycles * limits_.cycle),
             limit / (cycles * limits_.cycle), "N m/s");
}

void Samples::hear(const wire::RobotState& sample) {
  step(state_, sample.header, "robot/state");
  const std::int64_t now_ns = sample.header.time_ns;
  const Torque now{vector_of(sample.tau_nm), sample.header.seq, now_ns,
                   sample.mode == c3rt_v2_ROBOT_MOVE};
  // a brake is no motor: it holds as hard as it must
  if (now.moves) {
    check_torque(now.tau, "robot/state", now_ns);
    const bool next = now.seq == applied_.seq + 1;
    if (applied_.moves || next) check_rate(applied_, now, "robot/state");
    const Eigen::Vector3d p_WE = vector_of(sample.p_WE_m);
    const Eigen::Vector3d out =
        (limits_.workspace_min - p_WE).cwiseMax(p_WE - limits_.workspace_max);
    if (!out.allFinite()) {
      violated("not_finite", "robot/state", now_ns, NAN, 0.0, "");
    } else if (out.maxCoeff() > kWorkspaceMargin) {
      violated("workspace", "robot/state", now_ns, out.maxCoeff(), kWorkspaceMargin, "m");
    }
  }
  applied_ = now;

  const bool reflex = sample.mode == c3rt_v2_ROBOT_REFLEX;
  if (reflex && !reflex_) {
    ++reflexes_;
    // in its time or in its cycles: after a pause of the machine these come closer together; or by
    // the state that its newest command answered: the state that first told of it may have been
    // replaced by the next one
    const bool without_commands =
        seconds(now_ns - obeyed_at_ns_) >= (kLostCommands - 0.5) * limits_.cycle ||
        static_cast<double>(sample.header.seq) - static_cast<double>(obeyed_at_) >= kLostCommands ||
        (sample.command_state_ns != 0 &&
         seconds(now_ns - sample.command_state_ns) >= kLostCommands * limits_.cycle);
    const bool of_lost_commands =
        sample.errors == plant::bit(plant::Error::kCommunicationConstraintsViolation) &&
        without_commands;
    if (!of_lost_commands && now_ns > excused_until_ns_) {
      violated("reflex", "robot/state: " + plant::names(sample.errors), now_ns,
               static_cast<double>(sample.errors), 0.0, "");
    }
  }
  reflex_ = reflex;
  if (sample.command_seq != obeyed_ || !now.moves) {
    // while it moves this is when it was last given something new; else it waits for nothing
    if (!reflex) obeyed_at_ns_ = now_ns;
    obeyed_ = sample.command_seq;
    obeyed_at_ = sample.header.seq;
  }
  // in cycles of its own: time goes on while its process stands still
  const double waited = static_cast<double>(sample.header.seq) - static_cast<double>(obeyed_at_);
  if (waited > kBrakesAfter)
    violated("brake", "robot/state", now_ns, waited, kBrakesAfter, "cycles");
}

void Samples::hear(const wire::RobotCommand& sample) {
  const std::int64_t now_ns = sample.header.time_ns, before_ns = command_.time_ns;
  const bool first = command_.seq == 0 || command_.begins_anew(sample.header.seq);
  step(command_, sample.header, "robot/command");
  const Torque now{vector_of(sample.tau_nm), sample.header.seq, now_ns, true};
  check_torque(now.tau, "robot/command", now_ns);
  check_rate(asked_, now, "robot/command");
  asked_ = now;

  if (sample.mode != c3rt_v2_IMPEDANCE_TRACK || first) return;
  const auto plan = std::find_if(plans_.rbegin(), plans_.rend(), [&sample](const KnownPlan& known) {
    return known.time_ns == sample.origin.plan_ns;
  });
  if (plan != plans_.rend() && before_ns > plan->valid_until_ns) {
    violated("stale_plan", "robot/command", now_ns, seconds(now_ns - plan->valid_until_ns),
             limits_.cycle, "s");
  }
}

void Samples::hear(const wire::ServiceStatus& sample) {
  const auto process = static_cast<std::size_t>(sample.process);
  if (process >= status_.size()) return;
  // its time is the wall's, in lockstep too: only the sequence belongs to the run's streams
  ++samples_;
  Stream& stream = status_[process];
  const std::int64_t now_ns = state_.time_ns;
  const std::string name = wire::process_name(sample.process);
  stream.begins_anew(sample.header.seq);
  if (stream.seq != 0 && sample.header.seq <= stream.seq) {
    violated("sequence", "service/status of " + name, now_ns,
             static_cast<double>(sample.header.seq), static_cast<double>(stream.seq + 1), "");
  }
  stream.seq = sample.header.seq;
  if (sample.state == c3rt_v2_SERVICE_FAILED)
    violated("failed", name, now_ns, static_cast<double>(sample.state), 0.0, "");
}

void Samples::begin_task() {
  course_ = Course(task_);
  task_start_.reset();
  task_not_before_ns_ = state_.time_ns;
  at_task_ = true;
}

void Samples::end_task() {
  task_start_.reset();
  at_task_ = false;
}

void Samples::restarted(wire::Process process) {
  status_[static_cast<std::size_t>(process)].may_begin_anew = true;
  switch (process) {
    case c3rt_v2_PROCESS_PLANT:
      state_.may_begin_anew = scene_.may_begin_anew = true;
      applied_ = {};
      asked_ = {};  // the controller begins anew with a new robot
      break;
    case c3rt_v2_PROCESS_IMPEDANCE:
      command_.may_begin_anew = true;
      asked_ = {};
      break;
    case c3rt_v2_PROCESS_PLANNER:
      plan_.may_begin_anew = true;
      break;
    case c3rt_v2_PROCESS_VISION:
      estimate_.may_begin_anew = true;
      break;
    default:
      break;
  }
}

}  // namespace c3rt::cli::invariants
