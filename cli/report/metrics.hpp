#pragma once
// What a run amounts to: time series in, figures out. Errors are taken from ground truth, never
// from the estimate.
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cli/report/series.hpp"

namespace c3rt::cli {

constexpr double kNone =
    std::numeric_limits<double>::quiet_NaN();  // a figure that the run does not give

/// The circle that the ball is to follow.
struct Circle {
  Eigen::Vector2d center;  // in W [m]
  double radius;           // [m]
  bool clockwise;  // seen from above: α = atan2(x − x_c, y − y_c) increases (the paper's positive
                   // lead)
};

/// Counts circles by the angle that the ball has gone about the centre in the task's direction.
class LoopCounter {
 public:
  explicit LoopCounter(const Circle& circle) : circle_(circle) {}
  /// The first position starts the count. @param time [s]
  void add(double time, const Eigen::Vector2d& p_WB);
  double turns() const { return angle_ / (2.0 * M_PI); }  // net, in the task's direction
  int completed() const {
    return static_cast<int>(times_.size());
  }  // full circles; going back does not undo one
  const std::vector<double>& times() const { return times_; }  // of each full circle [s]
  /// When the ball had gone a quarter of the first circle; kNone before.
  double quarter_time() const { return quarter_time_; }

 private:
  Circle circle_;
  bool started_ = false;
  double angle_ = 0.0;       // since the start [rad]
  double last_alpha_ = 0.0;  // [rad]
  double last_time_ = 0.0;   // [s]
  double loop_start_ = 0.0;  // [s]
  double quarter_time_ = kNone;
  std::vector<double> times_;
};

/// Distance of the ball's centre to the circle, in the plane of the table [m].
double path_error(const Circle& circle, const Eigen::Vector3d& p_WB);

/// Quantiles by nearest rank; kNone without samples.
struct Spread {
  double p50 = kNone;
  double p95 = kNone;
  double p99 = kNone;
  double max = kNone;
};
Spread spread(std::vector<double> samples);

/// One limit of the scenario; its names are those that config/scenario.cpp lets through.
struct Limit {
  std::string name;
  std::optional<double> min;
  std::optional<double> max;
};

struct CriterionResult {
  std::string name;
  double value;
  double limit;
  bool met;  // false where the value is kNone
};

/// One result for each bound.
std::vector<CriterionResult> judge(const std::vector<Limit>& limits,
                                   const std::function<double(const std::string&)>& value_of);

struct BallFigures {
  double rms_error =
      kNone;  // of the distance to the path, weighted by time, from the start of the task [m]
  double p95_error = kNone;    // [m]
  double max_error = kNone;    // [m]
  double in_band_2cm = kNone;  // share of the time from the start of the task
  double in_band_1cm = kNone;
};

struct Figures {
  double duration = 0.0;      // of the recording [s]
  double task_start = kNone;  // first plan of the task itself, since the recording's start [s]
  int loops_completed = 0;
  double turns = 0.0;              // circles, with fractions
  std::vector<double> loop_times;  // [s]
  std::vector<BallFigures> balls;
  Spread tracking_error;        // |p_WE − p_WE_desired|, without the first second of tracking [m]
  double planner_rate = kNone;  // [Hz]
  Spread solve_time;            // [s]
  std::uint64_t overruns = 0;   // plans that the deadline truncated
  std::uint64_t fallbacks = 0;
  double impedance_rate = kNone;     // [Hz]
  double vision_rate = kNone;        // [Hz]
  Spread vision_error;               // |p_measured − truth at the exposure| [m]
  std::uint64_t dropped_frames = 0;  // exposures that no estimate answered
  double cameras_used_mean = kNone;
  Spread state_to_command;          // [s]
  Spread exposure_to_plan;          // [s]
  Spread exposure_to_torque;        // first command that acts on a plan [s]
  std::uint64_t error_bits = 0;     // of every reflex
  double success_rate_min = kNone;  // from the first command that tracks
  std::vector<CriterionResult> criteria;
};

/// Everything at once. The criteria look at the time after the first quarter circle; a ball that
/// never got there meets no band, so that a parked end effector cannot pass.
Figures evaluate(const Series& series, const Circle& circle, const std::vector<Limit>& limits);

/// The rows behind the pictures, thinned to what an eye can see.
struct TrackingError {
  std::vector<double> time;   // since the recording's start [s]
  std::vector<double> error;  // [m]
};
TrackingError tracking_error(const Series& series);

/// exposure → plan and state → command, exposure → torque, sample by sample [s]
struct Latencies {
  std::vector<double> state_to_command;
  std::vector<double> exposure_to_plan;
  std::vector<double> exposure_to_torque;
};
Latencies latencies(const Series& series);

/// Start of the recording: the clock's zero in report and pictures; 0 for an empty series.
std::int64_t start_ns(const Series& series);

}  // namespace c3rt::cli
