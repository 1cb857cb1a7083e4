#pragma once
// How far a run has come with its task, and how far its balls are from where they should be.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cli/report/series.hpp"
#include "controller/planner/task.hpp"

namespace c3rt::cli {

constexpr double kBand = 0.02;  // about the path, that of the paper's figures [m]

/// Counts circles by the angle that the ball has gone about the centre in the task's direction.
class LoopCounter {
 public:
  explicit LoopCounter(const planner::CircleTask& circle) : circle_(circle) {}
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
  planner::CircleTask circle_;
  bool started_ = false;
  double angle_ = 0.0;       // since the start [rad]
  double last_alpha_ = 0.0;  // [rad]
  double last_time_ = 0.0;   // [s]
  double loop_start_ = 0.0;  // [s]
  double quarter_time_ = kNone;
  std::vector<double> times_;
};

/// What of the task is done: circles by the ball, rounds of a path by its clock, balls at the end
/// of the line.
class Course {
 public:
  explicit Course(const planner::Task& task);
  /// @param elapsed since the task began [s]
  void add(double elapsed, const SceneRow& row);
  double amount() const;              // circles and rounds with fractions; balls that have arrived
  int completed() const;              // whole circles or rounds; 1 when all balls have arrived
  std::vector<double> times() const;  // of each circle; until all balls had arrived [s]
  /// From when on the error is judged, since the task began: after the first quarter circle, after
  /// the first second of a path; kNone before a ball that is to circle has come so far [s].
  double judged_from() const;

 private:
  planner::Task task_;
  LoopCounter loops_;
  double elapsed_ = 0.0;  // [s]
  int arrived_ = 0;       // balls
  double all_arrived_ = kNone;
};

/// What Course counts: "circles", "rounds" or "balls".
std::string unit(const planner::Task& task);

/// The largest distance of a ball to where it should be [m]; kNone without balls.
double worst_error(const planner::Task& task, double elapsed, const SceneRow& row);

/// When the task began: the state that the first plan with C3 was made from, which is where a
/// path's clock starts [ns].
std::optional<std::int64_t> task_start_ns(const Series& series);

/// How far a ball is from where it should be, from the task's begin on.
struct PathErrors {
  std::vector<double> time;   // since the task began [s]
  std::vector<double> error;  // planner::path_error [m]
};
PathErrors path_errors(const Series& series, const planner::Task& task, int ball);

/// The desired path as a line to draw: closed for circles and paths. @param y_start of a line [m]
std::vector<Eigen::Vector2d> outline(const planner::Task& task, double y_start);

}  // namespace c3rt::cli
