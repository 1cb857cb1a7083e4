#include "cli/report/path_plots.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "cli/report/gnuplot.hpp"

namespace c3rt::cli {
namespace {

constexpr double kBand = 0.02;              // [m]
constexpr double kSpacing = 0.002;          // [m]
constexpr double kFarthest = 0.2;           // a lost ball must not shrink the path to a point [m]
constexpr std::size_t kLargestPlot = 6000;  // points of one line
constexpr int kSize = 520, kTitle = 60;     // pixels

std::string points(const std::vector<Eigen::Vector2d>& list, std::size_t step = 1) {
  std::string rows;
  for (std::size_t i = 0; i < list.size(); i += step)
    rows += fmt::format("{:.6f} {:.6f}\n", list[i].x(), list[i].y());
  return rows.empty() ? "NaN NaN\n" : rows;
}

Eigen::AlignedBox2d box_of(const PathPlot& plot) {
  Eigen::AlignedBox2d wanted, all;
  for (const Eigen::Vector2d& corner : plot.wanted) wanted.extend(corner);
  for (const Eigen::Vector2d& p : plot.ball) all.extend(p);
  const Eigen::Vector2d far = Eigen::Vector2d::Constant(kFarthest);
  all = all.intersection(Eigen::AlignedBox2d(wanted.min() - far, wanted.max() + far));
  all.extend(wanted);
  return all;
}

}  // namespace

std::vector<Eigen::Vector2d> dense(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Eigen::Vector2d> result;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d way = corners[i + 1] - corners[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(way.norm() / kSpacing)));
    for (int part = 0; part <= parts; ++part) result.push_back(corners[i] + way * part / parts);
  }
  return result;
}

std::string draw_paths(const std::filesystem::path& file, const std::string& title,
                       const std::vector<PathPlot>& plots) {
  double reach = 0.0;
  for (const PathPlot& plot : plots)
    reach = std::max(reach, 0.5 * box_of(plot).sizes().maxCoeff() + 1.5 * kBand);
  const int count = static_cast<int>(plots.size());
  std::string script =
      gnuplot::terminal(file, count * kSize, kSize + 2 * kTitle) +
      fmt::format("set multiplot layout 1,{} title {} noenhanced\n", count,
                  gnuplot::quoted(title)) +
      "set size ratio -1\nset xlabel 'x [m]'\nset ylabel 'y [m]'\nset key below horizontal\n"
      "set grid front\n";
  for (const PathPlot& plot : plots) {
    const Eigen::Vector2d center = box_of(plot).center();
    const std::size_t step = plot.ball.size() / kLargestPlot + 1;
    script += "$band << EOD\n" + points(dense(plot.wanted)) + "EOD\n";
    script += "$wanted << EOD\n" + points(plot.wanted) + "EOD\n";
    script += "$ball << EOD\n" + points(plot.ball, step) + "EOD\n";
    script += fmt::format("set title {} noenhanced\nset xrange [{}:{}]\nset yrange [{}:{}]\n",
                          gnuplot::quoted(plot.title), center.x() - reach, center.x() + reach,
                          center.y() - reach, center.y() + reach);
    script += fmt::format(
        "plot $band using 1:2:({}) with circles fc rgb '#f8cfdc' fs solid noborder title '2 cm "
        "band', $wanted with lines dt 2 lw 2 lc rgb '#1f5fd0' title 'desired path', $ball with "
        "lines lw 1.3 lc rgb 'black' title 'ball'\n",
        kBand);
  }
  script += "unset multiplot\n";
  return gnuplot::draw(script)
             ? ""
             : file.filename().string() +
                   " could not be drawn: gnuplot (package gnuplot-nox) is missing or failed";
}

}  // namespace c3rt::cli
