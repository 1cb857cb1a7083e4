// Figure 17: the circle with three cameras, over several rounds.
#include <fmt/format.h>

#include "cli/reproduce/rolling.hpp"

namespace c3rt::cli::reproduce {

void fig17(const Context& context) {
  RunSpec spec{"vision", "circle_vision"};
  spec.overrides = {"task.loops=5", "task.duration_s=240"};
  spec.logs = true;
  const Run run = context.runs({spec}).front();
  const ordered_json& report = run.report;
  const ObjectTrack track = object_track(run);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : track.position)
    mean += p / static_cast<double>(track.position.size());
  const Eigen::Vector2d offset = mean - scenario_of(run.spec).task.motion.middle();

  const auto value = [&report](const char* path, double factor) {
    return shown(figure(report, path) * factor);
  };
  const double mean_time = mean_loop_time(report);
  fmt::print(
      "Figure 17: the circle with three rendered cameras, lockstep, seed 1; the paper: "
      "hardware, on a table slightly tilted\n\n");
  print_table({{"", "here", "paper"},
               {"circles", value("loops_completed", 1), "-"},
               {"seconds a circle", loop_times(report), ""},
               {"mean seconds a circle", shown(mean_time), "35"},
               {"in the 2 cm band [%]", value("objects.0.in_band_2cm", 100), "-"},
               {"ball to path, rms [mm]", value("objects.0.rms_error_m", 1e3), "-"},
               {"ball to path, largest [mm]", value("objects.0.max_error_m", 1e3), "nearly 50"},
               {"mean of the path from its centre, x [mm]", shown(1e3 * offset.x()), "-"},
               {"mean of the path from its centre, y [mm]", shown(1e3 * offset.y()), "> 0"},
               {"vision [Hz]", value("vision.rate_hz", 1), "80 to 90"},
               {"vision error, p95 [mm]", value("vision.error_m.p95", 1e3), "1"},
               {"planner [Hz]", value("planner.rate_hz", 1), "70 to 80"}});
  const ordered_json results{
      {"what", "fig17"},
      {"command", run.command},
      {"paper", {{"loop_time_s", 35.0}, {"max_error_m", 0.05}, {"vision_error_m", 0.001}}},
      {"mean_loop_time_s", cli::number(mean_time)},
      {"mean_offset_m", {offset.x(), offset.y()}},
      {"report", report}};
  context.finish(results, draw_paths(context.picture(), "Figure 17: the circle with three cameras",
                                     {path_plot("", run)}));
}

}  // namespace c3rt::cli::reproduce
