#pragma once
// A camera that can be made to see nothing, for tests of what comes after it.
#include <cstdint>

#include "vision/camera.hpp"

namespace c3rt::vision {

/// Passes a camera on until it is frozen.
class FaultyCamera : public Camera {
 public:
  explicit FaultyCamera(Camera& camera) : camera_(camera) {}

  const CameraModel& model() const override { return camera_.model(); }
  bool grab(std::int64_t exposure_ns, const Roi& roi, cv::Mat& image) override {
    return exposure_ns >= frozen_until_ns_ && camera_.grab(exposure_ns, roi, image);
  }
  /// Exposures before that time deliver no frame; 0 thaws it.
  void freeze(std::int64_t until_ns) { frozen_until_ns_ = until_ns; }

 private:
  Camera& camera_;
  std::int64_t frozen_until_ns_ = 0;
};

}  // namespace c3rt::vision
