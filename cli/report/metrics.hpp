#pragma once
// What a run amounts to: time series in, figures out. Errors are taken from ground truth, never
// from the estimate.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "cli/report/course.hpp"
#include "cli/report/excursions.hpp"
#include "cli/report/series.hpp"

namespace c3rt::cli {

/// Quantiles by nearest rank; kNone without samples.
struct Spread {
  double p50 = kNone;
  double p95 = kNone;
  double p99 = kNone;
  double max = kNone;
};
Spread spread(std::vector<double> samples);
/// The same of many; sorts them.
Spread spread_of(LongRows<double>& samples);

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

/// Of the distance of an object to where it should be (Task::error), weighted by time.
struct ObjectFigures {
  double rms_error = kNone;    // [m]
  double p95_error = kNone;    // [m]
  double max_error = kNone;    // [m]
  double in_band_2cm = kNone;  // share of the time
  double in_band_1cm = kNone;
  // of a task with a place to arrive at alone
  double arrived_after = kNone;  // first there, since the task began [s]
  double arrival_error = kNone;  // distance to the line at that instant [m]
  double end_error = kNone;      // and at the end of the recording [m]
};

struct Figures {
  double duration = 0.0;      // of the recording [s]
  double task_start = kNone;  // first plan of the task itself, since the recording's start [s]
  int loops_completed = 0;    // circles, rounds of a path; 1 when all objects are at a line's end
  double turns = 0.0;         // task::Progress::amount()
  std::string unit;           // of turns: circles, rounds, objects
  std::vector<double> loop_times;                    // [s]
  std::vector<std::pair<std::string, double>> task;  // task::Progress::results()
  std::vector<ObjectFigures> objects;                // from the start of the task
  ObjectFigures judged;  // what criteria look at: the worst object's, when it has settled
  // judged by other readings of the task, by their names
  std::vector<std::pair<std::string, ObjectFigures>> readings;
  ExcursionFigures out_of_band;
  // |p_WE − p_WE_desired|, without the first second of tracking [m]
  Spread tracking_error;        // outside the approach
  Spread approach_error;        // on the way to an object
  double planner_rate = kNone;  // [Hz]
  Spread solve_time;            // [s]
  std::uint64_t overruns = 0;   // plans that the deadline truncated
  std::uint64_t fallbacks = 0;
  double impedance_rate = kNone;     // [Hz]
  double vision_rate = kNone;        // [Hz]
  Spread vision_error;               // |p_measured − truth at the exposure| [m]
  Spread vision_angle_error;         // of measured orientations; none of a sphere [rad]
  std::uint64_t dropped_frames = 0;  // exposures that no estimate answered
  double cameras_used_mean = kNone;
  Spread state_to_command;          // [s]
  Spread exposure_to_plan;          // [s]
  Spread exposure_to_torque;        // first command that acts on a plan [s]
  std::uint64_t error_bits = 0;     // of every reflex
  double success_rate_min = kNone;  // from the first command that tracks
  std::vector<CriterionResult> criteria;
};

/// The first command that tracks; the end of the commands if there is none.
const CommandRow* first_tracking(const Series& series);

/// Everything at once. The criteria look at the time from task::Progress::judged_from() on: an
/// object that never got a quarter round its circle meets no band, so that a parked end effector
/// cannot pass.
/// @param pushes that the scenario's hand gave, in order of time
Figures evaluate(const Series& series, const task::Task& task, const std::vector<Limit>& limits,
                 const std::vector<plant::Push>& pushes = {});

/// exposure → plan and state → command, exposure → torque, sample by sample [s]
struct Latencies {
  LongRows<double> state_to_command;
  LongRows<double> exposure_to_plan;
  LongRows<double> exposure_to_torque;
};
Latencies latencies(const Series& series);

/// Start of the recording: the clock's zero in report and pictures; 0 for an empty series.
std::int64_t start_ns(const Series& series);

}  // namespace c3rt::cli
