#include "cli/series.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "cli/report/course.hpp"

namespace c3rt::cli {
namespace {

constexpr double kNs = 1e-9;  // [s]

/// The task itself and its other readings, by what a column's name ends with.
std::vector<std::pair<std::string, task::Task>> readings_of(const task::Task& task) {
  std::vector<std::pair<std::string, task::Task>> all{{"error", task}};
  for (const auto& reading : task.readings()) all.push_back(reading);
  return all;
}

std::string objects_csv(const Series& series, std::int64_t start, const task::Task& task) {
  const auto readings = readings_of(task);
  const int count = series.scene.empty() ? 0 : series.scene[0].object_count;
  std::string text = "t_s";
  for (int object = 0; object < count; ++object) {
    text += fmt::format(",object_{0}_x_m,object_{0}_y_m", object);
    for (const auto& reading : readings)
      text += fmt::format(",object_{}_{}_m", object, reading.first);
  }
  text += "\n";
  for (const SceneRow& row : series.scene) {
    if (row.time_ns < start) continue;
    const double elapsed = kNs * static_cast<double>(row.time_ns - start);
    text += fmt::format("{}", elapsed);
    for (int object = 0; object < count; ++object) {
      const Eigen::Vector2d at = row.p_WB[static_cast<std::size_t>(object)].head<2>();
      text += fmt::format(",{},{}", at.x(), at.y());
      for (const auto& reading : readings)
        text += fmt::format(",{}", reading.second.error(elapsed, at, object));
    }
    text += "\n";
  }
  return text;
}

std::string end_effector_csv(const Series& series, std::int64_t start) {
  std::string text = "t_s,x_m,y_m,z_m,desired_x_m,desired_y_m,desired_z_m\n";
  for (const CommandRow& command : series.command) {
    if (!command.tracking || command.state_ns < start) continue;
    const auto* const state =
        std::lower_bound(series.state.begin(), series.state.end(), command.state_ns,
                         [](const StateRow& row, std::int64_t t) { return row.time_ns < t; });
    if (state == series.state.end() || state->time_ns != command.state_ns) continue;
    const Eigen::Vector3d &at = state->p_WE, &desired = command.p_WE_desired;
    text +=
        fmt::format("{},{},{},{},{},{},{}\n", kNs * static_cast<double>(command.state_ns - start),
                    at.x(), at.y(), at.z(), desired.x(), desired.y(), desired.z());
  }
  return text;
}

std::string path_csv(const Series& series, std::int64_t start, const task::Task& task) {
  Eigen::AlignedBox2d tracks;
  for (const SceneRow& row : series.scene) {
    if (row.time_ns < start) continue;
    for (int object = 0; object < row.object_count; ++object)
      tracks.extend(Eigen::Vector2d(row.p_WB[static_cast<std::size_t>(object)].head<2>()));
  }
  std::string text = "x_m,y_m\n";
  if (tracks.isEmpty()) return text;
  for (const Eigen::Vector2d& corner : task.outline(tracks))
    text += fmt::format("{},{}\n", corner.x(), corner.y());
  return text;
}

}  // namespace

void write_series(const std::filesystem::path& folder, const Series& series,
                  const task::Task& task) {
  // without a beginning nothing is after it
  const std::int64_t start = task_start_ns(series).value_or(INT64_MAX);
  write_text(folder / "objects.csv", objects_csv(series, start, task));
  write_text(folder / "end_effector.csv", end_effector_csv(series, start));
  write_text(folder / "path.csv", path_csv(series, start, task));
}

}  // namespace c3rt::cli
