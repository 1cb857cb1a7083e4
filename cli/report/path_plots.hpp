#pragma once
// Pictures of where a ball went, seen from above, as in Figures 11, 16 and 17 of the paper.
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace c3rt::cli {

/// One path beside the others.
struct PathPlot {
  std::string title;
  std::vector<Eigen::Vector2d>
      wanted;  // corners of the desired path; closed if the last is the first
  std::vector<Eigen::Vector2d> ball;  // true positions [m]
};

/// Points at most 2 mm apart along the corners: discs about them make the band of a path.
std::vector<Eigen::Vector2d> dense(const std::vector<Eigen::Vector2d>& corners);

/// Draws a PNG with gnuplot: each path with its 2 cm band, all at one scale, side by side.
/// @return what is missing and why; empty if it is there
std::string draw_paths(const std::filesystem::path& file, const std::string& title,
                       const std::vector<PathPlot>& plots);

}  // namespace c3rt::cli
