#pragma once
// How far a run has come with its task, and how far its objects are from where they should be.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "cli/report/series.hpp"
#include "controller/task/task.hpp"

namespace c3rt::cli {

constexpr double kBand = 0.02;  // about the path, that of the paper's figures [m]

/// What of the task is done, by the rows of a recording.
class Course {
 public:
  explicit Course(const task::Task& task) : progress_(task.progress()) {}
  /// @param elapsed since the task began [s]
  void add(double elapsed, const SceneRow& row);
  const task::Progress& progress() const { return *progress_; }

 private:
  std::unique_ptr<task::Progress> progress_;
  std::vector<task::Placement> bodies_;
};

/// The largest distance of an object to where it should be [m]; kNone without objects.
double worst_error(const task::Task& task, double elapsed, const SceneRow& row);

/// When the task began: the state that the first plan with C3 was made from, which is where a
/// path's clock starts [ns].
std::optional<std::int64_t> task_start_ns(const Series& series);

/// How far an object is from where it should be, from the task's begin on.
struct PathErrors {
  LongRows<double> time;   // since the task began [s]
  LongRows<double> error;  // Task::error [m]
};
PathErrors path_errors(const Series& series, const task::Task& task, int object);

}  // namespace c3rt::cli
