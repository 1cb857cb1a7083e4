#include "cli/report/pictures.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cli/report/gnuplot.hpp"

namespace c3rt::cli {
namespace {

using gnuplot::draw;
using gnuplot::quoted;
using gnuplot::terminal;

constexpr double kBand = 0.02;              // [m]
constexpr std::size_t kLargestPlot = 4000;  // points of one line

std::size_t stride(std::size_t count) { return std::max<std::size_t>(1, count / kLargestPlot); }

/// gnuplot refuses axes that no sample gives a range.
const char* axes(bool any) {
  return any ? "set xrange [0:*]\nset yrange [0:*]\nset nokey\n"
             : "set xrange [0:1]\nset yrange [0:1]\nset nokey\n";
}

std::string circle_points(const Circle& circle, double radius) {
  std::string points;
  for (int i = 0; i <= 240; ++i) {
    const double angle = 2.0 * M_PI * i / 240.0;
    points += fmt::format("{:.6f} {:.6f}\n", circle.center.x() + radius * std::cos(angle),
                          circle.center.y() + radius * std::sin(angle));
  }
  return points;
}

std::string path_script(const std::filesystem::path& file, const Series& series,
                        const Circle& circle, const Figures& figures, const std::string& title) {
  const double from = std::isfinite(figures.task_start) ? figures.task_start : 0.0;
  std::string ball, start;
  const std::size_t step = stride(series.scene.size());
  double reach = circle.radius + 2.0 * kBand;
  for (std::size_t i = 0; i < series.scene.size(); i += step) {
    const SceneRow& row = series.scene[i];
    if (row.ball_count == 0 || static_cast<double>(row.time_ns - start_ns(series)) * 1e-9 < from)
      continue;
    const Eigen::Vector2d p_WB = row.p_WB[0].head<2>();
    ball += fmt::format("{:.6f} {:.6f}\n", p_WB.x(), p_WB.y());
    if (start.empty()) start = ball;
    // a lost ball must not shrink the circle to a point
    reach = std::max(reach, std::min((p_WB - circle.center).norm() + kBand, 3.0 * circle.radius));
  }
  std::string script = terminal(file, 720, 760);
  script += "$outer << EOD\n" + circle_points(circle, circle.radius + kBand) + "EOD\n";
  script +=
      "$inner << EOD\n" + circle_points(circle, std::max(0.0, circle.radius - kBand)) + "EOD\n";
  script += "$wanted << EOD\n" + circle_points(circle, circle.radius) + "EOD\n";
  script += "$ball << EOD\n" + (ball.empty() ? "NaN NaN\n" : ball) + "EOD\n";
  script += "$start << EOD\n" + (start.empty() ? "NaN NaN\n" : start) + "EOD\n";
  script += fmt::format(
      "set title {} noenhanced\nset xlabel 'x [m]'\nset ylabel 'y [m]'\nset size ratio -1\n",
      quoted(title));
  script +=
      fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", circle.center.x() - reach,
                  circle.center.x() + reach, circle.center.y() - reach, circle.center.y() + reach);
  script +=
      "set key below horizontal\nset grid front\n"
      "plot $outer with filledcurves closed fc rgb '#f8cfdc' fs solid noborder title '2 cm band',"
      " $inner with filledcurves closed fc rgb 'white' fs solid noborder notitle,"
      " $wanted with lines dt 2 lw 2 lc rgb '#1f5fd0' title 'desired path',"
      " $ball with lines lw 1.6 lc rgb 'black' title 'ball (ground truth)',"
      " $start with points pt 7 ps 1.3 lc rgb '#d04020' title 'start'\n";
  return script;
}

std::string tracking_script(const std::filesystem::path& file, const Series& series,
                            const std::string& title) {
  const TrackingError tracking = tracking_error(series);
  std::string rows;
  const std::size_t step = stride(tracking.time.size());
  for (std::size_t i = 0; i < tracking.time.size(); i += step) {
    // the largest of those that share a column of pixels: thinning must not hide a peak
    const std::size_t end = std::min(i + step, tracking.time.size());
    const double largest =
        *std::max_element(tracking.error.begin() + static_cast<std::ptrdiff_t>(i),
                          tracking.error.begin() + static_cast<std::ptrdiff_t>(end));
    rows += fmt::format("{:.4f} {:.5f}\n", tracking.time[i], largest * 1e3);
  }
  return terminal(file, 900, 420) + "$error << EOD\n" + (rows.empty() ? "0 0\n" : rows) + "EOD\n" +
         fmt::format("set title {} noenhanced\n", quoted(title)) +
         "set xlabel 'time [s]'\nset ylabel 'end effector to desired position [mm]'\n" +
         axes(!rows.empty()) + "plot $error with lines lw 1.1 lc rgb '#1f5fd0'\n";
}

/// Rows "value count" of a histogram up to the 99.9 % quantile [ms]; what is longer counts in the
/// last bin.
std::string histogram(std::vector<double> samples, double& width) {
  width = 1.0;
  if (samples.empty()) return "0 0\n";
  std::sort(samples.begin(), samples.end());
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
                            const std::vector<double>& samples) {
  double width = 1.0;
  const Spread figures = spread(samples);
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
                          const Circle& circle, const Figures& figures, const std::string& title) {
  const Latencies measured = latencies(series);
  std::vector<double> solve_times;
  for (const PlanRow& plan : series.plan) {
    if (plan.solve_time > 0.0) solve_times.push_back(plan.solve_time);
  }
  const std::string latency_script =
      terminal(directory / "latency.png", 820, 980) + "set multiplot layout 3,1\n" +
      histogram_panel("state", "robot state to command", measured.state_to_command) +
      histogram_panel("plan", "exposure to plan", measured.exposure_to_plan) +
      histogram_panel("torque", "exposure to torque", measured.exposure_to_torque) +
      "unset multiplot\n";
  const std::vector<std::pair<std::string, std::string>> pictures{
      {"path.png", path_script(directory / "path.png", series, circle, figures, title)},
      {"end_effector_error.png",
       tracking_script(directory / "end_effector_error.png", series, title)},
      {"solve_time.png", terminal(directory / "solve_time.png", 820, 420) +
                             histogram_panel("solve", "C3 solve time, " + title, solve_times)},
      {"latency.png", latency_script}};
  std::string missing;
  for (const auto& [name, script] : pictures) {
    if (!draw(script)) missing += (missing.empty() ? "" : ", ") + name;
  }
  return missing.empty()
             ? ""
             : missing + " could not be drawn: gnuplot (package gnuplot-nox) is missing or failed";
}

}  // namespace c3rt::cli
