#include "cli/report/excursions.hpp"

#include <algorithm>
#include <cmath>

#include "cli/report/course.hpp"
#include "cli/report/metrics.hpp"
#include "controller/base/time.hpp"

namespace c3rt::cli {
namespace {

constexpr double kLastTime = 1.0;  // in the band for that long at the end [s]

using base::seconds;

struct Row {
  double time;   // since the recording's start [s]
  double error;  // of the worst object [m]
};

LongRows<Row> judged_rows(const Series& series, const task::Task& task, double judged_from) {
  LongRows<Row> rows(series.folder);
  const auto task_start = task_start_ns(series);
  if (!task_start) return rows;
  for (const SceneRow& row : series.scene) {
    const double elapsed = seconds(row.time_ns - *task_start);
    if (elapsed >= judged_from && row.object_count > 0)
      rows.push_back({seconds(row.time_ns - start_ns(series)), worst_error(task, elapsed, row)});
  }
  return rows;
}

}  // namespace

ExcursionFigures excursion_figures(const Series& series, const task::Task& task, double judged_from,
                                   const std::vector<plant::Push>& pushes) {
  ExcursionFigures figures;
  const LongRows<Row> rows = judged_rows(series, task, judged_from);
  if (rows.empty()) return figures;
  const double end = rows.back().time;
  figures.longest = figures.largest = 0.0;
  bool out = false;
  for (const Row& row : rows) {
    if (row.error > kBand) {
      if (!out) figures.excursions.push_back({row.time, 0.0, 0.0, false});
      Excursion& excursion = figures.excursions.back();
      excursion.duration = row.time - excursion.start;
      excursion.largest = std::max(excursion.largest, row.error);
    } else if (out) {
      Excursion& excursion = figures.excursions.back();
      excursion.duration = row.time - excursion.start;
      excursion.returned = true;
    }
    out = row.error > kBand;
  }
  for (const Excursion& excursion : figures.excursions) {
    figures.longest = std::max(figures.longest, excursion.duration);
    figures.largest = std::max(figures.largest, excursion.largest);
  }
  figures.ended_in_band = std::all_of(rows.begin(), rows.end(), [&](const Row& row) {
    return row.time < end - kLastTime || row.error <= kBand;
  });

  for (std::size_t i = 0; i < pushes.size(); ++i) {
    const double from = pushes[i].time;
    const double until = i + 1 < pushes.size() ? std::min(end, pushes[i + 1].time) : end;
    if (from < rows.front().time || from >= end) continue;
    PushFigures push{pushes[i], 0.0, 0.0, false};
    for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
      if (rows[k].time < from || rows[k].time >= until) continue;
      push.largest = std::max(push.largest, rows[k].error);
      if (rows[k].error > kBand) push.out_of_band += rows[k + 1].time - rows[k].time;
      push.returned = rows[k].error <= kBand;
    }
    figures.pushes.push_back(push);
  }
  return figures;
}

}  // namespace c3rt::cli
