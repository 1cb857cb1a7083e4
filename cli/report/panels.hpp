#pragma once
// Pictures of curves over a shared axis, one panel below the other.
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace c3rt::cli {

struct Curve {
  std::string name;      // empty: not in the key
  std::string color;     // "#rrggbb"
  Eigen::VectorXd x, y;  // of equal sizes; not finite: a gap
  bool dashed = false;
  bool points = false;  // with a mark at each point
};

/// Where something is the case: intervals of x, shaded over a part of the panel's height.
struct Shade {
  std::string name;
  std::string color;
  double low, high;  // of the panel, 0 the bottom, 1 the top
  std::vector<std::pair<double, double>> intervals;
};

struct Panel {
  std::string title, x_label, y_label;
  std::vector<Curve> curves;
  std::vector<Shade> shades = {};
  bool logarithmic = false;  // the y axis
};

/// The intervals in which `on` holds; `on[i]` of times[i] … times[i+1], times one longer.
std::vector<std::pair<double, double>> intervals(const Eigen::VectorXd& times,
                                                 const Eigen::Array<bool, Eigen::Dynamic, 1>& on);

/// Draws a PNG with gnuplot.
/// @return what is missing and why; empty if it is there
std::string draw_panels(const std::filesystem::path& file, const std::string& title,
                        const std::vector<Panel>& panels);

}  // namespace c3rt::cli
