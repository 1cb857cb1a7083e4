#pragma once
// Finds balls in one camera's image: circle Hough transform, then a sub-pixel fit of the sphere's
// outline.
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "vision/track/sphere.hpp"

namespace c3rt::vision {

/// The part of the sensor that is read out. binning 2 joins 2 x 2 pixels into one, as a camera does
/// for a faster frame; width and height count pixels of the full sensor and are multiples of it.
struct Roi {
  int x, y, width, height, binning;
};

/// How the position follows from the outline.
enum class PositionMethod {
  kPlane,   // the ball is on the table: only its place there is sought
  kRadius,  // distance from the size of the outline: needs no table, but noisier along the ray
};

struct DetectorParameters {
  int roi;                  // side of the square region of interest [px]
  int search_binning;       // of the full image in which a lost ball is searched
  double blur;              // standard deviation of the smoothing before edges are sought [px]
  double hough_resolution;  // accumulator's cell [px of the image]
  double hough_edge;        // threshold of the edge detector [grey levels]
  double hough_votes;       // threshold of the accumulator
  double radius_tolerance;  // relative deviation from the expected radius that the Hough transform
                            // allows ...
  double search_radius_tolerance;  // ... and in the search, where the distance is unknown
  int rays;                        // radial profiles for the sub-pixel fit
  double edge_contrast;            // drop of the profile below which there is no edge [grey levels]
  double inlier;   // distance from the outline within which an edge belongs to it [px]
  double visible;  // share of the rays that must end on the outline
  PositionMethod position;
};

/// What is known before looking.
struct Expectation {
  Eigen::Vector3d p_WB;  // [m]
  double ball_radius;    // [m]
  double ball_height;    // of the centre of a ball on the table, z in W [m]
};

struct Detection {
  bool found = false;
  Eigen::Vector2d centre =
      Eigen::Vector2d::Zero();  // of the outline's ellipse, in the full image [px]
  double radius = 0.0;          // its semi minor axis [px]
  double visible = 0.0;         // share of the rays that ended on the outline
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // [m]
};

/// Square region around the expected ball, moved to lie within the image; false if the ball is not
/// in the picture.
bool roi_around(const CameraModel& camera, const Expectation& expected, int side,
                Roi& roi) noexcept;
/// The whole sensor.
Roi full_roi(const CameraModel& camera, int binning) noexcept;
/// Centre of image pixel (i, j) of a region, in the full image, and back. [px]
Eigen::Vector2d to_full(const Roi& roi, double i, double j) noexcept;
Eigen::Vector2d to_image(const Roi& roi, const Eigen::Vector2d& full) noexcept;

/// Keeps its work space between images; the answer depends on the arguments alone.
class CircleDetector {
 public:
  explicit CircleDetector(const DetectorParameters& parameters) : parameters_(parameters) {}

  /// @param image  CV_8UC3 (red, green, blue): the ball is where red exceeds blue; CV_8UC1: the
  /// ball is bright
  /// @param roi    where the image lies on the sensor
  /// Of several circles the one nearest to the expectation is taken.
  Detection detect(const CameraModel& camera, const cv::Mat& image, const Roi& roi,
                   const Expectation& expected);
  /// All balls of that size in the image, the nearest to the expectation first, no more than
  /// `most`. Circles of one outline count once: the one of which more is visible stands for it.
  std::vector<Detection> detect_all(const CameraModel& camera, const cv::Mat& image, const Roi& roi,
                                    const Expectation& expected, std::size_t most);

 private:
  /// Smooths the image, then circles by the Hough transform, the nearest to the expectation first.
  std::vector<cv::Vec3f> circles(const CameraModel& camera, const cv::Mat& image, const Roi& roi,
                                 const Expectation& expected);
  /// Radial profiles around a circle in the image -> rays through their steepest descent.
  void find_edges(const CameraModel& camera, const Roi& roi, const Eigen::Vector2d& start,
                  double radius);
  Detection refine(const CameraModel& camera, const Roi& roi, const Eigen::Vector2d& start,
                   double radius, const Expectation& expected);

  DetectorParameters parameters_;
  cv::Mat channel_, other_, smooth_;
  std::vector<Eigen::Vector3d> edges_;  // unit rays in C
};

}  // namespace c3rt::vision
