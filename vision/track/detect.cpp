#include "vision/track/detect.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace c3rt::vision {
namespace {

// the profiles reach from (1 - kReach) to (1 + kReach) radii: Hough's centre is better than that
constexpr double kReach = 0.3;
constexpr double kProfileStep = 0.5;  // [px]
constexpr int kFitIterations = 8;
constexpr int kMinimumEdges = 8;

/// Bilinear; outside the image the border's value.
double sample(const cv::Mat& image, double i, double j) {
  i = std::clamp(i, 0.0, image.cols - 1.001);
  j = std::clamp(j, 0.0, image.rows - 1.001);
  const int column = static_cast<int>(i), row = static_cast<int>(j);
  const double a = i - column, b = j - row;
  const std::uint8_t* upper = image.ptr<std::uint8_t>(row) + column;
  const std::uint8_t* lower = image.ptr<std::uint8_t>(row + 1) + column;
  return (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
}

/// Outline's semi minor axis and centre in pixels of the full image (square pixels to first order).
double expected_radius_px(const CameraModel& camera, const Eigen::Vector3d& p_C, double radius) {
  return camera.fx * sphere_outline(p_C, radius).semi_minor;
}

}  // namespace

bool roi_around(const CameraModel& camera, const Expectation& expected, int side, Roi& roi) noexcept {
  const Eigen::Vector3d p_C = camera.X_WC.inverse() * expected.p_WB;
  if (!(p_C.z() > 2.0 * expected.ball_radius)) return false;
  const Eigen::Vector2d centre = project(camera, p_C);
  const double radius = expected_radius_px(camera, p_C, expected.ball_radius);
  // a ball cut by the image's border would be a wrong circle
  if (!(centre.x() > radius && centre.y() > radius && centre.x() < camera.width - 1 - radius &&
        centre.y() < camera.height - 1 - radius)) {
    return false;
  }
  roi.width = std::min(side, camera.width);
  roi.height = std::min(side, camera.height);
  roi.x = std::clamp(static_cast<int>(std::lround(centre.x())) - roi.width / 2, 0, camera.width - roi.width);
  roi.y = std::clamp(static_cast<int>(std::lround(centre.y())) - roi.height / 2, 0, camera.height - roi.height);
  roi.binning = 1;
  return true;
}

Roi full_roi(const CameraModel& camera, int binning) noexcept {
  return {0, 0, camera.width / binning * binning, camera.height / binning * binning, binning};
}

Eigen::Vector2d to_full(const Roi& roi, double i, double j) noexcept {
  return {roi.x + (i + 0.5) * roi.binning - 0.5, roi.y + (j + 0.5) * roi.binning - 0.5};
}

Eigen::Vector2d to_image(const Roi& roi, const Eigen::Vector2d& full) noexcept {
  return {(full.x() - roi.x + 0.5) / roi.binning - 0.5, (full.y() - roi.y + 0.5) / roi.binning - 0.5};
}

Detection CircleDetector::detect(const CameraModel& camera, const cv::Mat& image, const Roi& roi,
                                 const Expectation& expected) {
  if (image.type() == CV_8UC3) {
    // grey things have no difference between red and blue, whatever the light
    cv::extractChannel(image, channel_, 0);
    cv::extractChannel(image, other_, 2);
    cv::subtract(channel_, other_, channel_);
  } else {
    image.copyTo(channel_);
  }
  cv::GaussianBlur(channel_, smooth_, cv::Size(5, 5), parameters_.blur);

  const Eigen::Vector3d p_C = camera.X_WC.inverse() * expected.p_WB;
  if (!(p_C.z() > 2.0 * expected.ball_radius)) return {};
  const double radius = expected_radius_px(camera, p_C, expected.ball_radius) / roi.binning;
  const int smallest = static_cast<int>(std::floor(radius * (1.0 - parameters_.radius_tolerance)));
  const int largest = static_cast<int>(std::ceil(radius * (1.0 + parameters_.radius_tolerance)));
  std::vector<cv::Vec3f> circles;
  cv::HoughCircles(smooth_, circles, cv::HOUGH_GRADIENT, parameters_.hough_resolution, radius,
                   parameters_.hough_edge, parameters_.hough_votes, std::max(1, smallest), std::max(2, largest));

  const Eigen::Vector2d wanted = to_image(roi, project(camera, p_C));
  std::sort(circles.begin(), circles.end(), [&](const cv::Vec3f& a, const cv::Vec3f& b) {
    return std::hypot(a[0] - wanted.x(), a[1] - wanted.y()) < std::hypot(b[0] - wanted.x(), b[1] - wanted.y());
  });
  for (const cv::Vec3f& circle : circles) {
    const Detection detection = refine(camera, roi, {circle[0], circle[1]}, circle[2], expected);
    if (detection.found) return detection;
  }
  return {};
}

Detection CircleDetector::refine(const CameraModel& camera, const Roi& roi, const Eigen::Vector2d& start,
                                 double radius, const Expectation& expected) {
  edges_.clear();
  const int samples = static_cast<int>(std::ceil(2.0 * kReach * radius / kProfileStep)) + 5;
  for (int ray = 0; ray < parameters_.rays; ++ray) {
    const double angle = 2.0 * M_PI * ray / parameters_.rays;
    const double x = std::cos(angle), y = std::sin(angle);
    const double first = (1.0 - kReach) * radius;
    // steepest descent outwards; its neighbours give the parabola
    double best = 0.0, before = 0.0, after = 0.0, previous = 0.0;
    int at = -1;
    const auto drop = [&](int k) {
      const double s = first + k * kProfileStep;
      return sample(smooth_, start.x() + (s - 1.0) * x, start.y() + (s - 1.0) * y) -
             sample(smooth_, start.x() + (s + 1.0) * x, start.y() + (s + 1.0) * y);
    };
    for (int k = 0; k < samples; ++k) {
      const double now = drop(k);
      if (k == at + 1 && at >= 0) after = now;
      if (now > best) {
        best = now;
        before = previous;
        after = 0.0;
        at = k;
      }
      previous = now;
    }
    if (best < parameters_.edge_contrast || at <= 0 || at == samples - 1) continue;
    const double curvature = before - 2.0 * best + after;
    const double shift = curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0;
    const double s = first + (at + std::clamp(shift, -0.5, 0.5)) * kProfileStep;
    const double i = start.x() + s * x, j = start.y() + s * y;
    if (i < 0.0 || j < 0.0 || i > smooth_.cols - 1 || j > smooth_.rows - 1) continue;
    edges_.push_back(unproject(camera, to_full(roi, i, j)).normalized());
  }
  if (static_cast<int>(edges_.size()) < kMinimumEdges) return {};

  // d · n = 1 with n = direction / cos(half angle), re-weighted from the Hough circle towards the inliers; an edge of
  // what covers the ball lies inside the outline and loses its weight
  const Eigen::Vector2d centre_px = to_full(roi, start.x(), start.y());
  const Eigen::Vector3d axis = unproject(camera, centre_px).normalized();
  const double pixel = roi.binning / camera.fx * axis.z() * axis.z();  // angle of one pixel, about
  Eigen::Vector3d n = axis / std::cos(radius * pixel);
  const double finest = parameters_.inlier * pixel;
  double cutoff = std::max(4.0 * finest, 0.15 * radius * pixel);
  const auto distance = [&](const Eigen::Vector3d& d) {
    const double length = n.norm();
    const double sine = std::sqrt(std::max(1e-12, 1.0 - 1.0 / (length * length)));
    return (d.dot(n) - 1.0) / (length * sine);  // angle inside the cone
  };
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    int support = 0;
    for (const Eigen::Vector3d& d : edges_) {
      const double r = distance(d) / cutoff;
      if (std::abs(r) >= 1.0) continue;
      const double weight = (1.0 - r * r) * (1.0 - r * r);
      normal += weight * d * d.transpose();
      right += weight * d;
      ++support;
    }
    if (support < kMinimumEdges) return {};
    n = normal.ldlt().solve(right);
    if (!n.allFinite() || n.norm() <= 1.0) return {};
    cutoff = std::max(finest, 0.6 * cutoff);
  }
  int inliers = 0;
  for (const Eigen::Vector3d& d : edges_) inliers += std::abs(distance(d)) < finest ? 1 : 0;

  Detection detection;
  detection.visible = static_cast<double>(inliers) / parameters_.rays;
  if (detection.visible < parameters_.visible) return detection;
  const Cone cone{n.normalized(), 1.0 / n.norm()};
  const Eigen::Vector3d p_C = cone_distance(cone, expected.ball_radius) * cone.direction;
  if (p_C.z() <= expected.ball_radius) return detection;
  if (parameters_.position == PositionMethod::kPlane) {
    const auto p_WB = intersect_plane(camera, cone.direction, expected.ball_height);
    if (!p_WB) return detection;
    detection.p_WB = *p_WB;
  } else {
    detection.p_WB = camera.X_WC * p_C;
  }
  const Outline outline = sphere_outline(p_C, expected.ball_radius);
  detection.centre = project(camera, Eigen::Vector3d(outline.centre.x(), outline.centre.y(), 1.0));
  detection.radius = camera.fx * outline.semi_minor;
  detection.found = true;
  return detection;
}

}  // namespace c3rt::vision
