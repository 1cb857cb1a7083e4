// Figure 11: one object on the circle, slow without noise, fast with 1 mm of it.
#include <fmt/format.h>

#include "cli/reproduce/rolling.hpp"

namespace c3rt::cli::reproduce {
namespace {

struct Side {
  const char *name, *scenario, *title;
  double paper_loop;  // seconds a circle
  double paper_band;  // share of the time in the 2 cm band
};

constexpr Side kSides[] = {{"slow", "circle_slow", "slow, no noise", 30.0, 1.0},
                           {"fast", "circle_fast", "fast, 1 mm noise", 21.0, 0.75}};

}  // namespace

void fig11(const Context& context) {
  std::vector<RunSpec> specs;
  for (const Side& side : kSides) {
    RunSpec spec{side.name, side.scenario};
    spec.logs = true;
    specs.push_back(spec);
  }
  const auto runs = context.runs(specs);

  ordered_json results{{"what", "fig11"}};
  std::vector<PathPlot> plots;
  Rows rows{{"", "slow", "paper", "fast", "paper"},
            {"circles"},
            {"seconds a circle"},
            {"in the 2 cm band [%]"},
            {"in a 1 cm band [%]"},
            {"ball to path, rms [mm]"},
            {"ball to path, largest [mm]"},
            {"end effector error, p95 [mm]"},
            {"end effector error, largest [mm]"},
            {"planner [Hz]"},
            {"solve time, p50 [ms]"}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Side& side = kSides[i];
    const ordered_json& report = runs[i].report;
    plots.push_back(path_plot(side.title, runs[i]));
    const auto value = [&report](const char* path, double factor) {
      return shown(figure(report, path) * factor);
    };
    const std::vector<std::pair<std::string, std::string>> column{
        {value("loops_completed", 1), "-"},
        {loop_times(report), fmt::format("{:g}", side.paper_loop)},
        {value("objects.0.in_band_2cm", 100), fmt::format("{:g}", 100.0 * side.paper_band)},
        {value("objects.0.in_band_1cm", 100), "-"},
        {value("objects.0.rms_error_m", 1e3), "-"},
        {value("objects.0.max_error_m", 1e3), "-"},
        {value("end_effector.tracking_error_m.p95", 1e3), "-"},
        {value("end_effector.tracking_error_m.max", 1e3), "< 3 (hardware)"},
        {value("planner.rate_hz", 1), "73"},
        {value("planner.solve_time_s.p50", 1e3), "-"}};
    for (std::size_t row = 0; row < column.size(); ++row) {
      rows[row + 1].push_back(column[row].first);
      rows[row + 1].push_back(column[row].second);
    }
    results[side.name] = {
        {"paper", {{"loop_time_s", side.paper_loop}, {"in_band_2cm", side.paper_band}}},
        {"command", runs[i].command},
        {"report", report}};
  }
  fmt::print(
      "Figure 11: one ball on the circle of 0.1 m, lockstep, seed 1; the paper: simulation in "
      "Drake\n\n");
  print_table(rows);
  context.finish(results,
                 draw_paths(context.picture(), "Figure 11: one ball on the circle", plots));
}

}  // namespace c3rt::cli::reproduce
