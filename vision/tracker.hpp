#pragma once
// Several spheres seen by several cameras: where to look, detection per camera, which detection is
// which sphere, fusion per sphere.
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vision/camera.hpp"
#include "vision/parameters.hpp"
#include "vision/track/colour.hpp"

namespace c3rt::vision {

/// What is known of a sphere before anyone looks.
struct SphereModel {
  double radius;           // [m]
  double height;           // of the centre of a sphere that lies on the table, z in W [m]
  Eigen::Vector3d colour;  // red green blue in 0..1; used where Parameters::colours is kDistinct
};

/// Where an object should be at an exposure.
struct Prediction {
  Eigen::Vector3d p_WB;  // [m]
  bool known;            // false: p_WB is only the best guess, so the search starts at once
  // of one whose orientation shows; none before it is seen
  std::optional<Eigen::Quaternion<double, Eigen::DontAlign>> q_WB = {};
};

/// What one camera contributed to an exposure.
struct View {
  bool frame = true;  // the camera delivered every frame that it was asked for
  bool used = false;  // detected and not rejected as an outlier
  Detection detection;
};

/// One sphere at one exposure.
struct Sighting {
  Fusion fusion;
  std::vector<View> views;  // by camera
};

/// Finds each sphere where it is expected, in a region of interest of each camera; for those that
/// no camera sees there, searches the full image of one camera, another one at each exposure, and
/// then looks again around what was found.
///
/// Which circle is which sphere: a detection belongs to a sphere only within the sphere's radius of
/// where it is expected (two spheres' centres are at least a diameter apart), each to at most one,
/// by one assignment over all spheres per camera. A sphere that was lost takes a circle that no
/// other sphere explains. Spheres of distinct colours are moreover sought each in its own colour.
class Tracker {
 public:
  /// @param cameras  outlive the tracker; asked in this order
  /// @throws std::invalid_argument if distinct colours are asked for and two are too much alike
  Tracker(const Parameters& parameters, std::vector<SphereModel> spheres,
          std::vector<Camera*> cameras);

  /// @param predictions  by sphere
  /// @return by sphere; valid until the next call
  const std::vector<Sighting>& observe(std::int64_t exposure_ns,
                                       const std::vector<Prediction>& predictions);
  /// A full image was read at the last exposure.
  bool searched() const { return searched_; }

 private:
  using Places = std::vector<std::optional<Eigen::Vector3d>>;  // by sphere; none: not to be seen

  /// Looks for the spheres of `wanted` about their places, with the other spheres' places in mind.
  void look_around(std::int64_t exposure_ns, const Places& places, const std::vector<bool>& wanted);
  void look_with(std::size_t camera, std::int64_t exposure_ns, const Places& places,
                 const std::vector<bool>& wanted);
  /// One full image: a place for each missing sphere that is in it.
  Places search(std::int64_t exposure_ns, const std::vector<Prediction>& predictions);
  void drop_impossible(const std::vector<Prediction>& predictions);
  /// Circles in image_ that may be that sphere, the nearest to the expectation first.
  std::vector<Detection> detect(CircleDetector& detector, const CameraModel& model,
                                std::size_t sphere, const Roi& roi, const Expectation& expected,
                                std::size_t most);
  Expectation expectation(std::size_t index, const Eigen::Vector3d& p_WB) const;

  Parameters parameters_;
  std::vector<SphereModel> spheres_;
  std::vector<ColourKey> keys_;  // by sphere; empty: all look alike
  std::vector<Camera*> cameras_;
  CircleDetector tracking_, searching_;
  std::vector<Sighting> sightings_;
  std::size_t next_search_ = 0;
  bool searched_ = false;
  cv::Mat image_, channel_;
};

}  // namespace c3rt::vision
