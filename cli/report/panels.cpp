#include "cli/report/panels.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cli/report/gnuplot.hpp"

namespace c3rt::cli {
namespace {

constexpr int kPlotWidth = 760, kPanelHeight = 300, kTitleHeight = 40, kLetterWidth = 8;  // pixels

std::string rows(const Curve& curve) {
  std::string text;
  for (Eigen::Index i = 0; i < curve.x.size(); ++i) {
    // an empty line is where gnuplot lifts its pen
    text += std::isfinite(curve.x[i]) && std::isfinite(curve.y[i])
                ? fmt::format("{:.9g} {:.9g}\n", curve.x[i], curve.y[i])
                : "\n";
  }
  return text;
}

/// Letters of the widest entry of the keys.
int key_width(const std::vector<Panel>& panels) {
  std::ptrdiff_t widest = 0;
  const auto see = [&widest](const std::string& name) {
    widest = std::max(widest, std::count_if(name.begin(), name.end(), [](char c) {
                        return (c & 0xC0) != 0x80;  // the first byte of a letter in UTF-8
                      }));
  };
  for (const Panel& panel : panels) {
    for (const Curve& curve : panel.curves) see(curve.name);
    for (const Shade& shade : panel.shades) see(shade.name);
  }
  return static_cast<int>(widest);
}

bool any_point(const Curve& curve) {
  return (curve.x.array().isFinite() && curve.y.array().isFinite()).any();
}

std::string panel_script(const Panel& panel, int number) {
  std::string script, plots, shapes;
  int index = 0;
  for (const Curve& curve : panel.curves) {
    if (!any_point(curve)) continue;
    const std::string name = fmt::format("$c{}_{}", number, index++);
    script += name + " << EOD\n" + rows(curve) + "EOD\n";
    plots += fmt::format("{} {} with {} lw 1.5 lc rgb '{}'{}{} {}", plots.empty() ? "plot" : ",",
                         name, curve.points ? "linespoints" : "lines", curve.color,
                         curve.dashed ? " dt 2" : "", curve.points ? " pt 7 ps 0.7" : "",
                         curve.name.empty() ? "notitle" : "title " + gnuplot::quoted(curve.name));
  }
  // gnuplot refuses a panel that nothing gives a range
  if (index == 0) plots = "plot NaN notitle";
  for (const Shade& shade : panel.shades) {
    for (const auto& [from, to] : shade.intervals) {
      shapes += fmt::format(
          "set object rectangle from first {:.9g}, graph {} to first {:.9g}, graph {} fc rgb '{}' "
          "fs solid noborder behind\n",
          from, shade.low, to, shade.high, shade.color);
    }
    plots += fmt::format(", keyentry with boxes fs solid noborder fc rgb '{}' title {}",
                         shade.color, gnuplot::quoted(shade.name));
  }
  script += "unset object\nset offsets 0, 0, 0, 0\n" + shapes;
  script += fmt::format(
      "set title {} noenhanced\nset xlabel {} noenhanced\nset ylabel {} noenhanced\n",
      gnuplot::quoted(panel.title), gnuplot::quoted(panel.x_label), gnuplot::quoted(panel.y_label));
  script += panel.logarithmic ? "set logscale y\nset format y '10^{%L}'\n"
                              : "unset logscale y\nset format y\n";
  if (index == 0) {
    script += "set xrange [0:1]\nset yrange [0:1]\n";
  } else {
    script += "set autoscale x\nset autoscale y\n";
    if (!panel.logarithmic) script += "set offsets 0, 0, graph 0.05, graph 0.05\n";
  }
  return script + plots + "\n";
}

}  // namespace

std::vector<std::pair<double, double>> intervals(const Eigen::VectorXd& times,
                                                 const Eigen::Array<bool, Eigen::Dynamic, 1>& on) {
  std::vector<std::pair<double, double>> found;
  for (Eigen::Index i = 0; i < on.size(); ++i) {
    if (!on[i]) continue;
    if (i > 0 && on[i - 1]) {
      found.back().second = times[i + 1];
    } else {
      found.emplace_back(times[i], times[i + 1]);
    }
  }
  return found;
}

std::string draw_panels(const std::filesystem::path& file, const std::string& title,
                        const std::vector<Panel>& panels) {
  const int count = static_cast<int>(panels.size());
  const int margin = key_width(panels) + 6;
  std::string script =
      gnuplot::terminal(kPlotWidth + margin * kLetterWidth, kTitleHeight + count * kPanelHeight);
  script += fmt::format(
      "set key at graph 1.02, graph 1 left top vertical Left reverse samplen 2 noenhanced\n"
      "set lmargin 10\nset rmargin {}\n",
      margin);
  script +=
      fmt::format("set multiplot layout {},1 title {} noenhanced\n", count, gnuplot::quoted(title));
  for (int i = 0; i < count; ++i) script += panel_script(panels[static_cast<std::size_t>(i)], i);
  script += "unset multiplot\n";
  return gnuplot::missing(file.filename().string(), gnuplot::draw(file, script));
}

}  // namespace c3rt::cli
