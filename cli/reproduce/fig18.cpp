// Figure 18: the object's error over time on three paths in time.
#include <fmt/format.h>

#include "cli/reproduce/timed_paths.hpp"

namespace c3rt::cli::reproduce {
namespace {

/// The error to the desired point of the time, and to the way-point that is held then [mm].
Panel error_panel(const TimedPath& path, const Run& run) {
  const auto readings = scenario_of(run.spec).task.motion.readings();
  const task::Task &held = readings.at(0).second, &moving = readings.at(1).second;
  const ObjectTrack track = object_track(run);
  const auto count = static_cast<Eigen::Index>(track.time.size());
  Eigen::VectorXd time(count), to_moving(count), to_held(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto row = static_cast<std::size_t>(i);
    time[i] = track.time[row];
    to_moving[i] = 1e3 * moving.error(time[i], track.position[row]);
    to_held[i] = 1e3 * held.error(time[i], track.position[row]);
  }
  const Eigen::Vector2d ends(0.0, count > 0 ? time[count - 1] : 1.0);
  return {path.name,
          "",
          "error [mm]",
          {{"to the held way-point", "#c8c8c8", time, to_held},
           {"to x_d(t)", "#1f5fd0", time, to_moving},
           {"2 cm", "#d04020", ends, Eigen::Vector2d::Constant(1e3 * kBand), true}}};
}

}  // namespace

void fig18(const Context& context) {
  const auto runs = timed_path_runs(context);
  std::vector<Panel> panels;
  for (std::size_t i = 0; i < runs.size(); ++i)
    panels.push_back(error_panel(kTimedPaths[i], runs[i]));
  panels.back().x_label = "time since C3 took over [s]";
  fmt::print(
      "Figure 18: error of the ball on paths in time with three rendered cameras, lockstep, seed "
      "1; the paper: hardware\n\n");
  print_table(timed_path_rows(runs));
  fmt::print(
      "\nx_d(t) moves between the way-points at constant speed; held way-points jump by 20 to 40 "
      "mm, and a ball that\nmoves steadily is up to that far from them.\n");
  context.finish(timed_path_results("fig18", runs), "Figure 18: error on paths in time", panels);
}

}  // namespace c3rt::cli::reproduce
