#pragma once
// What the tracker needs of a camera. A driver of a machine-vision camera implements the same two
// functions.
#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "vision/track/detect.hpp"

namespace c3rt::vision {

class Camera {
 public:
  virtual ~Camera() = default;
  virtual const CameraModel& model() const = 0;
  /// Reads a region of the frame that was exposed at that time. May be called several times for one
  /// exposure.
  /// @param image  CV_8UC3, red green blue, (roi.height / binning) x (roi.width / binning); memory
  /// is reused
  /// @return false if there is no such frame (dropped, or the camera is gone)
  virtual bool grab(std::int64_t exposure_ns, const Roi& roi, cv::Mat& image) = 0;
};

}  // namespace c3rt::vision
