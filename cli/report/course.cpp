#include "cli/report/course.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::cli {

void Course::add(double elapsed, const SceneRow& row) {
  if (row.object_count == 0) return;
  bodies_.clear();
  for (int i = 0; i < row.object_count; ++i)
    bodies_.emplace_back(row.p_WB[static_cast<std::size_t>(i)].head<2>(),
                         row.q_WB[static_cast<std::size_t>(i)]);
  progress_->add(elapsed, bodies_);
}

double worst_error(const task::Task& task, double elapsed, const SceneRow& row) {
  double worst = kNone;
  for (int object = 0; object < row.object_count; ++object) {
    const Eigen::Vector3d& p_WB = row.p_WB[static_cast<std::size_t>(object)];
    worst = std::fmax(worst, task.error(elapsed, p_WB.head<2>(), object));
  }
  return worst;
}

std::optional<std::int64_t> task_start_ns(const Series& series) {
  const auto* const first = std::find_if(series.plan.begin(), series.plan.end(),
                                         [](const PlanRow& plan) { return plan.rolling; });
  if (first == series.plan.end()) return std::nullopt;
  return first->state_ns;
}

PathErrors path_errors(const Series& series, const task::Task& task, int object) {
  PathErrors errors{LongRows<double>(series.folder), LongRows<double>(series.folder)};
  const auto start = task_start_ns(series);
  if (!start) return errors;
  for (const SceneRow& row : series.scene) {
    if (row.time_ns < *start || object >= row.object_count) continue;
    const double elapsed = static_cast<double>(row.time_ns - *start) * 1e-9;
    const Eigen::Vector3d& p_WB = row.p_WB[static_cast<std::size_t>(object)];
    errors.time.push_back(elapsed);
    errors.error.push_back(task.error(elapsed, p_WB.head<2>(), object));
  }
  return errors;
}

}  // namespace c3rt::cli
