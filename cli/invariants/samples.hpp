#pragma once
// What every run must keep, looked at on every sample of the bus. Pure: samples go in, violations
// come out; `c3rt soak` and tests feed the same unit.
#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "cli/invariants/violations.hpp"
#include "cli/report/course.hpp"
#include "controller/task/task.hpp"
#include "idl/topics.hpp"

namespace c3rt::cli::invariants {

using Vector7d = Eigen::Matrix<double, 7, 1>;

/// The numbers; of a scenario: load_limits.hpp.
struct Limits {
  // of the robot, as the plant has them
  Vector7d tau_max;     // [N m]
  double tau_rate_max;  // [N m/s]
  double cycle = 1e-3;  // [s]
  // of the end effector while commands move it, in W [m]
  Eigen::Vector3d workspace_min, workspace_max;
  // of an object: from when the task judges it, as far as a criterion says so of every instant
  double object_error = std::numeric_limits<double>::infinity();  // [m]
  double object_reach = 0.5;  // from the task's middle: farther away it is lost [m]
  /// In realtime a state or command may be replaced by the next one before it is sent, and stamps
  /// that are late by part of a cycle hide it: two changes in one.
  bool realtime = false;
};

/// The samples of one service or one simulated run, each topic in order; a plan before the commands
/// that follow it. Names, subjects and what is asked:
///
///   torque, torque_rate     robot/state    while the robot moves, what it applied is within limits
///   torque, torque_rate     robot/command  and so is what was asked of it
///   not_finite              all            every number that counts is finite
///   workspace               robot/state    the end effector is where it may be
///   brake                   robot/state    without a new command for 20 cycles it no longer moves
///   stale_plan              robot/command  a plan is not followed for more than a cycle after its
///                                          end: the command before this one was sent after that
///   sequence, time          all            both go forwards
///   reflex                  robot/state    the robot stops itself for a cause alone: commands that
///                                          did not come, or what excuse() tells
///   object                  sim/scene      an object is where the criteria want it, once judged
///   object_lost             sim/scene      and never out of reach
///   failed                  a process      no process says that it has failed
class Samples {
 public:
  Samples(const Limits& limits, const task::Task& task, Violations& violations);

  void hear(const wire::Plan& sample);
  void hear(const wire::Scene& sample);
  void hear(const wire::ObjectEstimate& sample);
  void hear(const wire::RobotState& sample);
  void hear(const wire::RobotCommand& sample);
  void hear(const wire::ServiceStatus& sample);

  /// The task begins anew, in the same streams.
  void begin_task();
  /// It has ended, and objects are where they may be, until it begins anew.
  void end_task();
  /// Something was done up to `until_ns` that may stop the robot.
  void excuse(std::int64_t until_ns) { excused_until_ns_ = std::max(excused_until_ns_, until_ns); }
  /// Stamps were made to jump up to `until_ns`: till then times may go back.
  void excuse_time(std::int64_t until_ns) { jumps_until_ns_ = std::max(jumps_until_ns_, until_ns); }
  /// A process was killed and is started again: from its successor's first sample on its streams
  /// count from 1, and what went before is forgotten.
  void restarted(wire::Process process);

  std::uint64_t samples() const noexcept { return samples_; }    // all that were heard
  std::uint64_t reflexes() const noexcept { return reflexes_; }  // with and without a cause

 private:
  struct Stream {
    std::uint64_t seq = 0;
    std::int64_t time_ns = 0;
    bool may_begin_anew = false;
    /// Whether this is a successor's first sample.
    bool begins_anew(std::uint64_t newest) noexcept {
      if (!may_begin_anew || newest > seq) return false;
      *this = {};
      return true;
    }
  };
  struct KnownPlan {
    std::int64_t time_ns, valid_until_ns;
  };
  struct Torque {
    Vector7d tau = Vector7d::Zero();
    std::uint64_t seq = 0;  // 0: none yet
    std::int64_t time_ns = 0;
    bool moves = false;
  };
  void step(Stream& stream, const wire::Header& header, const char* subject);
  void check_torque(const Vector7d& tau, const char* subject, std::int64_t time_ns);
  void check_rate(const Torque& before, const Torque& now, const char* subject);
  void check_object(const wire::Scene& sample);
  void violated(const char* name, const std::string& subject, std::int64_t time_ns, double value,
                double limit, const char* unit);

  const Limits limits_;
  const task::Task task_;
  Violations& violations_;
  std::optional<std::int64_t> first_ns_;  // of all that was heard
  std::uint64_t samples_ = 0, reflexes_ = 0;

  Stream plan_, scene_, estimate_, state_, command_;
  std::array<Stream, wire::kProcessCount> status_{};
  std::deque<KnownPlan> plans_;
  Torque applied_, asked_;
  bool reflex_ = false;
  std::uint64_t obeyed_ = 0;       // newest command that the robot applied
  std::int64_t obeyed_at_ns_ = 0;  // since when
  std::uint64_t obeyed_at_ = 0;    // and since which state
  std::int64_t excused_until_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t jumps_until_ns_ = std::numeric_limits<std::int64_t>::min();
  Course course_;
  std::optional<std::int64_t> task_start_;  // [ns]
  std::int64_t task_not_before_ns_ = 0;
  bool at_task_ = true;
};

}  // namespace c3rt::cli::invariants
