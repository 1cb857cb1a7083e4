#include "cli/report/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "cli/report/course.hpp"
#include "cli/report/figure.hpp"
#include "cli/report/tracking.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Index;

constexpr std::size_t kLargestPlot = 4000;  // points of one line
constexpr double kFarthest = 0.2;           // a lost object must not shrink the path to a point [m]

constexpr std::array<const char*, kMaxObjects> kObjectColours{
    kInk, "#009e73", kAmber, "#cc79a7", "#56b4e9", "#7f3b08", kGrey, "#aa4499"};

std::size_t stride(std::size_t count) { return std::max<std::size_t>(1, count / kLargestPlot); }

/// Errors over time [s, mm], the largest of those that share a column of pixels: thinning must not
/// hide a peak.
void set_thinned(Curve& curve, const LongRows<double>& time, const LongRows<double>& error) {
  const std::size_t step = stride(time.size());
  const std::size_t count = (time.size() + step - 1) / step;
  curve.x.resize(static_cast<Index>(count));
  curve.y.resize(static_cast<Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t begin = i * step, end = std::min(begin + step, time.size());
    curve.x[static_cast<Index>(i)] = time[begin];
    curve.y[static_cast<Index>(i)] =
        1e3 * *std::max_element(error.begin() + begin, error.begin() + end);
  }
}

void set_points(Curve& curve, const std::vector<Eigen::Vector2d>& points) {
  const Eigen::Map<const Eigen::Matrix2Xd> all(points.empty() ? nullptr : points.front().data(), 2,
                                               static_cast<Index>(points.size()));
  curve.x = all.row(0);
  curve.y = all.row(1);
}

/// What is shown of a desired path and of where objects went.
Eigen::AlignedBox2d shown_of(const std::vector<Eigen::Vector2d>& wanted,
                             const Eigen::AlignedBox2d& objects) {
  Eigen::AlignedBox2d path;
  for (const Eigen::Vector2d& corner : wanted) path.extend(corner);
  const Eigen::Vector2d far = Eigen::Vector2d::Constant(kFarthest);
  Eigen::AlignedBox2d box =
      objects.intersection(Eigen::AlignedBox2d(path.min() - far, path.max() + far));
  box.extend(path);
  return box;
}

/// A desired path and its 2 cm band.
Panel top_view(const std::vector<Eigen::Vector2d>& wanted, const Eigen::AlignedBox2d& objects) {
  Curve path;
  path.name = "desired path";
  path.color = kBlue;
  path.dashed = true;
  path.width = 2.0;
  set_points(path, wanted);
  Panel panel{"", "x [m]", "y [m]", {path}};
  panel.bands = {{"2 cm band", "#f5d3e3", path.x, path.y, kBand}};
  const Eigen::AlignedBox2d box = shown_of(wanted, objects);
  const Eigen::Vector2d center = box.center();
  const double reach = 0.5 * box.sizes().maxCoeff() + 2.0 * kBand;
  panel.x_limits = {center.x() - reach, center.x() + reach};
  panel.y_limits = {center.y() - reach, center.y() + reach};
  panel.equal = true;
  panel.legend_below = true;
  return panel;
}

/// The course of one object from the task's begin.
std::vector<Eigen::Vector2d> track(const Series& series, double from, std::size_t object) {
  std::vector<Eigen::Vector2d> course;
  const std::size_t step = stride(series.scene.size());
  for (std::size_t i = 0; i < series.scene.size(); i += step) {
    const SceneRow& row = series.scene[i];
    if (static_cast<int>(object) >= row.object_count ||
        static_cast<double>(row.time_ns - start_ns(series)) * 1e-9 < from)
      continue;
    course.emplace_back(row.p_WB[object].head<2>());
  }
  return course;
}

Figure path_figure(const Series& series, const task::Task& task, const Figures& figures,
                   const std::string& title) {
  const double from = std::isfinite(figures.task_start) ? figures.task_start : 0.0;
  const std::size_t objects = std::max<std::size_t>(1, figures.objects.size());
  Eigen::AlignedBox2d box;
  std::vector<Curve> curves;
  std::vector<Eigen::Vector2d> starts;
  for (std::size_t object = 0; object < objects; ++object) {
    const std::vector<Eigen::Vector2d> course = track(series, from, object);
    for (const Eigen::Vector2d& point : course) box.extend(point);
    if (!course.empty()) starts.push_back(course.front());
    Curve curve;
    curve.name =
        objects > 1 ? fmt::format("object {} (ground truth)", object + 1) : "object (ground truth)";
    curve.color = kObjectColours[object];
    set_points(curve, course);
    curves.push_back(curve);
  }
  Curve start;
  start.name = "start";
  start.color = kRed;
  start.points = true;
  start.joined = false;
  start.mark_size = 8.0;
  set_points(start, starts);
  Panel panel = top_view(task.outline(box), box);
  panel.curves.insert(panel.curves.end(), curves.begin(), curves.end());
  panel.curves.push_back(start);
  return {title, {panel}, 1, 720, 760};
}

/// Distances over time, which begin at 0.
Panel distances(const std::string& x_label, const std::string& y_label) {
  Panel panel{"", x_label, y_label, {}};
  panel.x_limits[0] = panel.y_limits[0] = 0.0;
  panel.legend_below = true;
  return panel;
}

Figure error_figure(const Series& series, const task::Task& task, const Figures& figures,
                    const std::string& title) {
  Panel panel = distances("time since the task began [s]", "object to path [mm]");
  double last = 0.0;
  for (std::size_t object = 0; object < figures.objects.size(); ++object) {
    const PathErrors errors = path_errors(series, task, static_cast<int>(object));
    if (errors.time.empty()) continue;
    Curve curve;
    curve.name = fmt::format("object {}", object + 1);
    curve.color = kObjectColours[object];
    set_thinned(curve, errors.time, errors.error);
    last = std::max(last, curve.x.maxCoeff());
    panel.curves.push_back(curve);
  }
  if (!panel.curves.empty()) {
    const double limit = kBand * 1e3;
    panel.curves.insert(panel.curves.begin(), {"2 cm", kRed, Eigen::Vector2d(0.0, last),
                                               Eigen::Vector2d(limit, limit), true});
  }
  return {title, {panel}, 1, 900, 420};
}

Figure tracking_figure(const Series& series, const std::string& title) {
  const TrackingErrors tracking = tracking_errors(series);
  Panel panel = distances("time [s]", "end effector to desired position [mm]");
  const auto add = [&panel](const char* name, const char* color, const LongRows<double>& time,
                            const LongRows<double>& error) {
    if (time.empty()) return;
    Curve curve;
    curve.name = name;
    curve.color = color;
    curve.points = true;
    curve.joined = false;
    curve.mark_size = 2.0;
    set_thinned(curve, time, error);
    panel.curves.push_back(curve);
  };
  add("approach", "#a0a0a0", tracking.approach.time, tracking.approach.error);
  add("task", kBlue, tracking.task.time, tracking.task.error);
  return {title, {panel}, 1, 900, 420};
}

/// A histogram up to the 99.9 % quantile [ms]; what is longer counts in the last bin.
/// @param samples sorted
Bars histogram(const LongRows<double>& samples) {
  constexpr Index kBins = 60;
  const double last =
      samples[static_cast<std::size_t>(0.999 * static_cast<double>(samples.size() - 1))] * 1e3;
  const double first = std::min(0.0, samples.front() * 1e3);
  const double width = std::max((last - first) / kBins, 1e-3);
  Bars bars{kBlue, Eigen::VectorXd::LinSpaced(kBins + 1, first, first + kBins * width),
            Eigen::VectorXd::Zero(kBins)};
  for (const double sample : samples) {
    const auto bin = static_cast<Index>((sample * 1e3 - first) / width);
    ++bars.heights[std::clamp<Index>(bin, 0, kBins - 1)];
  }
  return bars;
}

Panel histogram_panel(const std::string& label, LongRows<double>& samples) {
  const Spread figures = spread_of(samples);
  Panel panel{label, "time [ms]", "samples", {}};
  if (samples.empty()) return panel;
  panel.title +=
      fmt::format("\nn {}   p50 {:.2f}   p95 {:.2f}   p99 {:.2f}   max {:.2f} ms", samples.size(),
                  figures.p50 * 1e3, figures.p95 * 1e3, figures.p99 * 1e3, figures.max * 1e3);
  panel.bars = {histogram(samples)};
  panel.y_limits[0] = 0.0;
  return panel;
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
  return draw({{directory / "path.png", path_figure(series, task, figures, title)},
               {directory / "path_error.png", error_figure(series, task, figures, title)},
               {directory / "end_effector_error.png", tracking_figure(series, title)},
               {directory / "solve_time.png",
                {"", {histogram_panel("C3 solve time, " + title, solve_times)}, 1, 820, 420}},
               {directory / "latency.png",
                {title,
                 {histogram_panel("robot state to command", measured.state_to_command),
                  histogram_panel("exposure to plan", measured.exposure_to_plan),
                  histogram_panel("exposure to torque", measured.exposure_to_torque)},
                 1,
                 820,
                 980}}});
}

}  // namespace c3rt::cli
