#pragma once
// One ball seen by several cameras: where to look, detection per camera, fusion.
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "vision/camera.hpp"
#include "vision/parameters.hpp"

namespace c3rt::vision {

/// What one camera contributed to an exposure.
struct View {
  bool frame = false;  // the camera delivered every frame that it was asked for
  bool used = false;   // detected and not rejected as an outlier
  Detection detection;
};

struct Sighting {
  Fusion fusion;
  std::vector<View> views;  // by camera
  bool searched = false;    // a full image was read
};

/// Finds the ball where it is expected, in a region of interest of each camera; where no camera
/// sees it there, searches the full image of one camera, another one at each exposure, and then
/// looks again around what that one found.
class Tracker {
 public:
  /// @param cameras      outlive the tracker; asked in this order
  /// @param ball_height  of the centre of a ball that lies on the table, z in W [m]
  Tracker(const Parameters& parameters, double ball_radius, double ball_height,
          std::vector<Camera*> cameras);

  /// @param p_expected  where the ball should be at this exposure
  /// @param known       false: p_expected is only the best guess, so the search starts at once
  Sighting observe(std::int64_t exposure_ns, const Eigen::Vector3d& p_expected, bool known);

 private:
  Sighting look_around(std::int64_t exposure_ns, const Eigen::Vector3d& p_expected);

  Parameters parameters_;
  double ball_radius_, ball_height_;
  std::vector<Camera*> cameras_;
  CircleDetector tracking_, searching_;
  std::size_t next_search_ = 0;
  cv::Mat image_;
};

}  // namespace c3rt::vision
