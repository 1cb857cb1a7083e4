#pragma once
// Pictures of where an object went, seen from above, as in Figures 11, 16 and 17 of the paper.
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace c3rt::cli {

/// One path beside the others.
struct PathPlot {
  std::string title;
  std::vector<Eigen::Vector2d>
      wanted;  // corners of the desired path; closed if the last is the first
  std::vector<Eigen::Vector2d> object;  // true positions [m]
};

/// What is shown of a desired path and of where objects went: a lost one must not shrink the path
/// to a point.
Eigen::AlignedBox2d shown_of(const std::vector<Eigen::Vector2d>& wanted,
                             const Eigen::AlignedBox2d& objects);

/// gnuplot's blocks $wanted, the desired path, and $band, points at most 2 mm apart along it: discs
/// about them make its band. And how they are plotted.
std::string wanted_data(const std::vector<Eigen::Vector2d>& wanted);
std::string wanted_plot();

/// Draws a PNG with gnuplot: each path with its 2 cm band, all at one scale, side by side.
/// @return what is missing and why; empty if it is there
std::string draw_paths(const std::filesystem::path& file, const std::string& title,
                       const std::vector<PathPlot>& plots);

}  // namespace c3rt::cli
