#include "cli/report/path_plots.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "cli/report/course.hpp"
#include "cli/report/gnuplot.hpp"

namespace c3rt::cli {
namespace {

constexpr double kSpacing = 0.002;          // [m]
constexpr double kFarthest = 0.2;           // a lost object must not shrink the path to a point [m]
constexpr std::size_t kLargestPlot = 6000;  // points of one line
constexpr int kSize = 520, kTitle = 60;     // pixels

std::string points(const std::vector<Eigen::Vector2d>& list, std::size_t step = 1) {
  std::string rows;
  for (std::size_t i = 0; i < list.size(); i += step)
    rows += fmt::format("{:.6f} {:.6f}\n", list[i].x(), list[i].y());
  return rows.empty() ? "NaN NaN\n" : rows;
}

Eigen::AlignedBox2d box_of(const PathPlot& plot) {
  Eigen::AlignedBox2d object;
  for (const Eigen::Vector2d& p : plot.object) object.extend(p);
  return shown_of(plot.wanted, object);
}

std::vector<Eigen::Vector2d> dense(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Eigen::Vector2d> result;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d way = corners[i + 1] - corners[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(way.norm() / kSpacing)));
    for (int part = 0; part <= parts; ++part) result.emplace_back(corners[i] + way * part / parts);
  }
  return result;
}

}  // namespace

std::string wanted_plot() {
  return fmt::format(
      "$band using 1:2:({}) with circles fc rgb '#f8cfdc' fs solid noborder title '2 cm band', "
      "$wanted with lines dt 2 lw 2 lc rgb '#1f5fd0' title 'desired path'",
      kBand);
}

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

std::string wanted_data(const std::vector<Eigen::Vector2d>& wanted) {
  return "$band << EOD\n" + points(dense(wanted)) + "EOD\n$wanted << EOD\n" + points(wanted) +
         "EOD\n";
}

std::string draw_paths(const std::filesystem::path& file, const std::string& title,
                       const std::vector<PathPlot>& plots) {
  double reach = 0.0;
  for (const PathPlot& plot : plots)
    reach = std::max(reach, 0.5 * box_of(plot).sizes().maxCoeff() + 1.5 * kBand);
  const int count = static_cast<int>(plots.size());
  std::string script =
      gnuplot::terminal(count * kSize, kSize + 2 * kTitle) +
      fmt::format("set multiplot layout 1,{} title {} noenhanced\n", count,
                  gnuplot::quoted(title)) +
      "set size ratio -1\nset xlabel 'x [m]'\nset ylabel 'y [m]'\nset key below horizontal\n"
      "set grid front\n";
  for (const PathPlot& plot : plots) {
    const Eigen::Vector2d center = box_of(plot).center();
    const std::size_t step = plot.object.size() / kLargestPlot + 1;
    script += wanted_data(plot.wanted) + "$object << EOD\n" + points(plot.object, step) + "EOD\n";
    script += fmt::format("set title {} noenhanced\nset xrange [{}:{}]\nset yrange [{}:{}]\n",
                          gnuplot::quoted(plot.title), center.x() - reach, center.x() + reach,
                          center.y() - reach, center.y() + reach);
    script +=
        "plot " + wanted_plot() + ", $object with lines lw 1.3 lc rgb 'black' title 'object'\n";
  }
  script += "unset multiplot\n";
  return gnuplot::missing(file.filename().string(), gnuplot::draw(file, script));
}

}  // namespace c3rt::cli
