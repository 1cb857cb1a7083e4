#pragma once
// Balls of several colours in one picture: a grey image for each, in which that ball alone is
// bright.
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace c3rt::vision {

/// With d_j the direction of ball j's colour across the grey axis, the value of a pixel c is
///
///   max(0, d_own · c − max(0, max_j≠own d_j · c)),
///
/// scaled so that the ball's own colour in full light gives its largest minus its smallest
/// component. Grey gives 0 in any light, another ball's colour gives 0, and a pixel that the ball
/// covers by a share gives that share: the edge stays where it is.
class ColourKey {
 public:
  /// @param colours of all balls, red green blue in 0..1
  /// @throws std::invalid_argument if a ball is grey, or of the colour of another one
  ColourKey(const std::vector<Eigen::Vector3d>& colours, std::size_t own);

  /// @param image    CV_8UC3, red green blue
  /// @param channel  CV_8UC1 of the same size; memory is reused
  void extract(const cv::Mat& image, cv::Mat& channel) const;

 private:
  Eigen::Vector3f own_;                  // scaled
  std::vector<Eigen::Vector3f> others_;  // scaled
};

}  // namespace c3rt::vision
