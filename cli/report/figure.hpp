#pragma once
// Pictures as data: panels of curves, shades and areas, which c3rt.pictures of the Python package
// draws.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "cli/report/series.hpp"

namespace c3rt::cli {

/// Colours that are told apart by who sees no red or no green, by Okabe and Ito; in Python the
/// PALETTE.
constexpr const char* kBlue = "#0072b2";
constexpr const char* kRed = "#d55e00";
constexpr const char* kAmber = "#e69f00";
constexpr const char* kInk = "#202020";
constexpr const char* kGrey = "#7f7f7f";

struct Curve {
  std::string name;      // empty: not in the legend
  std::string color;     // "#rrggbb"; empty: the palette's, by order
  Eigen::VectorXd x, y;  // of equal sizes; not finite: a gap
  bool dashed = false;
  bool points = false;     // with a mark at each point
  bool joined = true;      // by a line
  bool cross = false;      // the marks
  double width = 1.5;      // of the line, in points of print
  double mark_size = 4.0;  // in points of print
};

/// Where something is the case: intervals of x, shaded over a part of the panel's height.
struct Shade {
  std::string name;
  std::string color;
  double low, high;  // of the panel, 0 the bottom, 1 the top
  std::vector<std::pair<double, double>> intervals;
};

/// All that is as close to a path, of panels with `equal`.
struct Band {
  std::string name;
  std::string color;
  Eigen::VectorXd x, y;  // corners of the path
  double radius = 0.0;   // in the units of x and y
};

/// A histogram.
struct Bars {
  std::string color;
  Eigen::VectorXd edges, heights;  // one edge more than heights
};

/// A filled area.
struct Polygon {
  std::string name;
  std::string color, edge;  // of the area and of its outline; empty: no outline
  Eigen::VectorXd x, y;     // corners
};

/// From where to where an axis goes; kNone: all that is drawn, on that side.
using Limits = std::array<double, 2>;

struct Panel {
  std::string title, x_label, y_label;
  std::vector<Curve> curves;
  std::vector<Shade> shades = {};
  bool logarithmic = false;  // the y axis
  std::vector<Band> bands = {};
  std::vector<Bars> bars = {};
  std::vector<Polygon> polygons = {};
  Limits x_limits{kNone, kNone}, y_limits{kNone, kNone};
  bool equal = false;  // one unit is as long in x as in y
  bool axes = true;
  bool legend_below = false;  // in place of beside
};

struct Figure {
  std::string title;
  std::vector<Panel> panels;
  int columns = 1;            // of panels, row by row
  int width = 0, height = 0;  // pixels; 0: by the panels
};

/// A figure's PNG.
struct Picture {
  std::filesystem::path file;
  Figure figure;
};

/// The intervals in which `on` holds; `on[i]` of times[i] … times[i+1], times one longer.
std::vector<std::pair<double, double>> intervals(const Eigen::VectorXd& times,
                                                 const Eigen::Array<bool, Eigen::Dynamic, 1>& on);

/// As python/c3rt/pictures/__init__.py describes it.
nlohmann::ordered_json to_json(const Figure& figure);

/// Draws all in one process of Python. Each file comes to be whole or not at all. After Python was
/// found to lack matplotlib, or to hang, it is not tried again: a run of many pictures waits once.
/// @return what is missing and why, "no path.png: …"; empty if all are there
std::string draw(const std::vector<Picture>& pictures);

}  // namespace c3rt::cli
