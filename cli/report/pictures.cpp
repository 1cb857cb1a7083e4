#include "cli/report/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "cli/report/course.hpp"
#include "cli/report/gnuplot.hpp"
#include "cli/report/path_plots.hpp"
#include "cli/report/tracking.hpp"

namespace c3rt::cli {
namespace {

using gnuplot::draw;
using gnuplot::quoted;
using gnuplot::terminal;

constexpr std::size_t kLargestPlot = 4000;  // points of one line

constexpr std::array<const char*, kMaxObjects> kObjectColours{
    "black", "#1b7837", "#b35806", "#7b3294", "#2166ac", "#b2182b", "#01665e", "#8c510a"};

std::size_t stride(std::size_t count) { return std::max<std::size_t>(1, count / kLargestPlot); }

/// Rows "time error" [s, mm], the largest of those that share a column of pixels: thinning must not
/// hide a peak.
std::string thinned(const LongRows<double>& time, const LongRows<double>& error) {
  std::string rows;
  const std::size_t step = stride(time.size());
  for (std::size_t i = 0; i < time.size(); i += step) {
    const std::size_t end = std::min(i + step, time.size());
    const double largest = *std::max_element(error.begin() + i, error.begin() + end);
    rows += fmt::format("{:.4f} {:.5f}\n", time[i], largest * 1e3);
  }
  return rows;
}

/// gnuplot refuses axes that no sample gives a range.
const char* axes(bool any) {
  return any ? "set xrange [0:*]\nset yrange [0:*]\nset nokey\n"
             : "set xrange [0:1]\nset yrange [0:1]\nset nokey\n";
}

/// The course of one object from the task's begin; with its first point in `start`.
std::string track(const Series& series, double from, std::size_t object, Eigen::AlignedBox2d& box,
                  std::string& start) {
  std::string rows;
  const std::size_t step = stride(series.scene.size());
  for (std::size_t i = 0; i < series.scene.size(); i += step) {
    const SceneRow& row = series.scene[i];
    if (static_cast<int>(object) >= row.object_count ||
        static_cast<double>(row.time_ns - start_ns(series)) * 1e-9 < from)
      continue;
    const Eigen::Vector2d p_WB = row.p_WB[object].head<2>();
    const std::string point = fmt::format("{:.6f} {:.6f}\n", p_WB.x(), p_WB.y());
    if (rows.empty()) start += point;
    rows += point;
    box.extend(p_WB);
  }
  return rows.empty() ? "NaN NaN\n" : rows;
}

std::string path_script(const Series& series, const task::Task& task, const Figures& figures,
                        const std::string& title) {
  const double from = std::isfinite(figures.task_start) ? figures.task_start : 0.0;
  const std::size_t objects = std::max<std::size_t>(1, figures.objects.size());
  Eigen::AlignedBox2d box;
  std::string script = terminal(720, 760), start, plots;
  for (std::size_t object = 0; object < objects; ++object) {
    script += fmt::format("$object{} << EOD\n", object) + track(series, from, object, box, start) +
              "EOD\n";
    const std::string name = objects > 1 ? fmt::format("object {}", object + 1) : "object";
    plots += fmt::format(", $object{} with lines lw 1.6 lc rgb '{}' title '{} (ground truth)'",
                         object, kObjectColours[object], name);
  }
  const std::vector<Eigen::Vector2d> corners = task.outline(box);
  box = shown_of(corners, box);
  const Eigen::Vector2d center = box.center();
  const double reach = 0.5 * box.sizes().maxCoeff() + 2.0 * kBand;
  script +=
      wanted_data(corners) + "$start << EOD\n" + (start.empty() ? "NaN NaN\n" : start) + "EOD\n";
  script += fmt::format(
      "set title {} noenhanced\nset xlabel 'x [m]'\nset ylabel 'y [m]'\nset size ratio -1\n",
      quoted(title));
  script += fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", center.x() - reach,
                        center.x() + reach, center.y() - reach, center.y() + reach);
  script += fmt::format(
      "set key below horizontal\nset grid front\n"
      "plot {}{}, $start with points pt 7 ps 1.3 lc rgb '#d04020' title 'start'\n",
      wanted_plot(), plots);
  return script;
}

std::string error_script(const Series& series, const task::Task& task, const Figures& figures,
                         const std::string& title) {
  std::string script = terminal(900, 420), plots;
  bool any = false;
  for (std::size_t object = 0; object < figures.objects.size(); ++object) {
    const PathErrors errors = path_errors(series, task, static_cast<int>(object));
    script +=
        fmt::format("$error{} << EOD\n", object) + thinned(errors.time, errors.error) + "EOD\n";
    any = any || !errors.time.empty();
    plots += fmt::format(", $error{} with lines lw 1.2 lc rgb '{}' title 'object {}'", object,
                         kObjectColours[object], object + 1);
  }
  return script + fmt::format("set title {} noenhanced\n", quoted(title)) +
         "set xlabel 'time since the task began [s]'\nset ylabel 'object to path [mm]'\n" +
         axes(any) +
         fmt::format(
             "set key below horizontal\nplot {} with lines dt 2 lc rgb '#d04020' title '2 cm'",
             kBand * 1e3) +
         (any ? plots : "") + "\n";
}

std::string tracking_script(const Series& series, const std::string& title) {
  const TrackingErrors tracking = tracking_errors(series);
  const std::string task = thinned(tracking.task.time, tracking.task.error);
  const std::string approach = thinned(tracking.approach.time, tracking.approach.error);
  const auto rows = [](const std::string& some) { return some.empty() ? "0 0\n" : some; };
  return terminal(900, 420) + "$task << EOD\n" + rows(task) + "EOD\n" + "$approach << EOD\n" +
         rows(approach) + "EOD\n" + fmt::format("set title {} noenhanced\n", quoted(title)) +
         "set xlabel 'time [s]'\nset ylabel 'end effector to desired position [mm]'\n" +
         axes(!task.empty() || !approach.empty()) +
         "set key below horizontal\nplot $approach with points pt 7 ps 0.3 lc rgb '#a0a0a0' title "
         "'approach', "
         "$task with points pt 7 ps 0.3 lc rgb '#1f5fd0' title 'task'\n";
}

/// Rows "value count" of a histogram up to the 99.9 % quantile [ms]; what is longer counts in the
/// last bin.
/// @param samples sorted
std::string histogram(const LongRows<double>& samples, double& width) {
  width = 1.0;
  if (samples.empty()) return "0 0\n";
  constexpr int kBins = 60;
  const double last =
      samples[static_cast<std::size_t>(0.999 * static_cast<double>(samples.size() - 1))] * 1e3;
  const double first = std::min(0.0, samples.front() * 1e3);
  width = std::max((last - first) / kBins, 1e-3);
  std::vector<int> counts(kBins, 0);
  for (const double sample : samples) {
    const int bin = static_cast<int>((sample * 1e3 - first) / width);
    ++counts[static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1))];
  }
  std::string rows;
  for (int i = 0; i < kBins; ++i)
    rows +=
        fmt::format("{:.6g} {}\n", first + (i + 0.5) * width, counts[static_cast<std::size_t>(i)]);
  return rows;
}

std::string histogram_panel(const std::string& name, const std::string& label,
                            LongRows<double>& samples) {
  double width = 1.0;
  const Spread figures = spread_of(samples);
  std::string script = "$" + name + " << EOD\n" + histogram(samples, width) + "EOD\n";
  const std::string quantiles =
      samples.empty() ? "no samples"
                      : fmt::format("n {}   p50 {:.2f}   p95 {:.2f}   p99 {:.2f}   max {:.2f} ms",
                                    samples.size(), figures.p50 * 1e3, figures.p95 * 1e3,
                                    figures.p99 * 1e3, figures.max * 1e3);
  script += fmt::format("set title {} noenhanced\nset xlabel 'ms'\nset ylabel 'samples'\n",
                        quoted(label + "\n" + quantiles));
  script += fmt::format("set boxwidth {:.6g}\nset style fill solid 0.75 noborder\n", width * 0.92);
  script += axes(!samples.empty());
  script += "plot $" + name + " with boxes lc rgb '#1f5fd0'\n";
  return script;
}

}  // namespace

std::string draw_pictures(const std::filesystem::path& directory, const Series& series,
                          const task::Task& task, const Figures& figures,
                          const std::string& title) {
  Latencies measured = latencies(series);
  LongRows<double> solve_times(series.folder);
  for (const PlanRow& plan : series.plan) {
    if (plan.solve_time > 0.0) solve_times.push_back(plan.solve_time);
  }
  const std::string latency_script =
      terminal(820, 980) + "set multiplot layout 3,1\n" +
      histogram_panel("state", "robot state to command", measured.state_to_command) +
      histogram_panel("plan", "exposure to plan", measured.exposure_to_plan) +
      histogram_panel("torque", "exposure to torque", measured.exposure_to_torque) +
      "unset multiplot\n";
  const std::vector<std::pair<std::string, std::string>> pictures{
      {"path.png", path_script(series, task, figures, title)},
      {"path_error.png", error_script(series, task, figures, title)},
      {"end_effector_error.png", tracking_script(series, title)},
      {"solve_time.png",
       terminal(820, 420) + histogram_panel("solve", "C3 solve time, " + title, solve_times)},
      {"latency.png", latency_script}};
  std::string missing, reason;
  for (const auto& [name, script] : pictures) {
    const std::string refused = draw(directory / name, script);
    if (refused.empty()) continue;
    missing += (missing.empty() ? "" : ", ") + name;
    reason = refused;
  }
  return gnuplot::missing(missing, reason);
}

}  // namespace c3rt::cli
