#pragma once
// Tags of the family tag36h11: what is printed, and where they are in an image.
#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "plant_emulator/scene.hpp"

namespace c3rt::vision {

/// A tag as one image shows it.
struct SeenTag {
  int id = 0;
  // of the black square, as one reads it: lower left, lower right, upper right, upper left; the
  // centre of the top left pixel is (0, 0) [px]
  std::array<Eigen::Vector2d, 4> corners;
};

/// The answer depends on the image alone.
class TagDetector {
 public:
  TagDetector();
  ~TagDetector();
  TagDetector(const TagDetector&) = delete;
  TagDetector& operator=(const TagDetector&) = delete;

  /// @param grey  CV_8UC1
  /// @return by id; an id as often as it is seen
  std::vector<SeenTag> detect(const cv::Mat& grey);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// @throws std::invalid_argument for an id that the family has not
plant::TagPicture tag_picture(int id);

}  // namespace c3rt::vision
