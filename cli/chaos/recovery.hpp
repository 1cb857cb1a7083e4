#pragma once
// How long after a fault the task goes on. Pure: samples and the faults' times go in, times come
// out.
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cli/chaos/schedule.hpp"
#include "idl/topics.hpp"

namespace c3rt::cli::chaos {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// What came of a fault. Times are from its end, of a kill from when it was killed [s].
struct Outcome {
  Fault fault;
  double resumed = kNever;  // the arm follows what was seen after it, and has moved kMoved
  double at_task = kNever;  // and so has an object, while the plan is at the task
  bool overtaken = false;   // the next fault began before it had resumed
};

/// Hears the samples of one run, each topic in order.
///
/// A command carries the stamps of what it was made from, so it says itself that every process does
/// its work again: it follows a plan, from a state and an exposure, all of after the fault's end.
class Recovery {
 public:
  static constexpr double kMoved = 0.002;    // [m]
  static constexpr double kPatience = 20.0;  // without a fault: then it has not recovered [s]

  void begin(const Fault& fault, std::int64_t now_ns);
  void end(std::int64_t now_ns);
  void hear(const wire::Plan& sample);
  void hear(const wire::Scene& sample);
  void hear(const wire::RobotState& sample);
  void hear(const wire::RobotCommand& sample);

  /// The run has ended: what is still open stays so, as if the next fault had come.
  void finish();
  /// Whether the task has not gone on for longer than kPatience, of which faults themselves do not
  /// count; told once.
  bool lost_patience(std::int64_t now_ns);
  /// The last ones are still open.
  const std::vector<Outcome>& outcomes() const noexcept { return outcomes_; }

 private:
  void forget();
  bool fault_is_over() const { return end_ns_.has_value(); }

  std::vector<Outcome> outcomes_;
  std::optional<std::int64_t> end_ns_;  // of the newest fault; none while it lasts
  double waited_ = 0.0;                 // since the task went on last, before the newest fault [s]
  bool told_ = false;
  // since the newest fault's end
  std::uint64_t followed_ = 0;  // the first command that follows what was seen after it; 0: none
  bool at_task_ = false;
  std::optional<Eigen::Vector3d> from_;   // where the arm was when that was applied [m]
  std::vector<Eigen::Vector3d> objects_;  // where they were at the task; none: not yet [m]
};

/// What a report has of the faults of one group.
struct Times {
  std::uint64_t count = 0, overtaken = 0, not_resumed = 0;
  std::vector<double> resumed, at_task;  // sorted [s]
};

/// By kind; kills and stops by process, too. The faults that are still open do not count.
std::map<std::string, Times> by_kind(const std::vector<Outcome>& outcomes);

/// Of the plant or of all others.
Times of_plant(const std::vector<Outcome>& outcomes, bool plant);

}  // namespace c3rt::cli::chaos
