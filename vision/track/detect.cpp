#include "vision/track/detect.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

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
constexpr double kFirstCutoff = 0.15;   // of the radius: Hough's circle is that good
constexpr double kCutoffShrinks = 0.6;  // per iteration
constexpr double kSizeWeight = 9.0;     // the known size counts as much as this many rays

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

/// Tukey's weight of an edge: an edge of what covers the ball lies inside the outline and loses it.
double weight_of(double error, double cutoff) {
  const double r = error / cutoff;
  return std::abs(r) < 1.0 ? (1.0 - r * r) * (1.0 - r * r) : 0.0;
}

/// Angles: an inlier's distance from the outline, and the distance that counts at the start. [rad]
struct Precision {
  double finest, first;
  double cutoff(int iteration) const {
    return std::max(finest, first * std::pow(kCutoffShrinks, iteration));
  }
};

struct Fit {
  Eigen::Vector3d p_C;  // of the sphere's centre [m]
  int inliers;
};

/// The cone of directions through the edges, nothing known of its size: d · n = 1 with n =
/// direction / cos(half angle).
std::optional<Fit> fit_cone(const std::vector<Eigen::Vector3d>& edges, const Eigen::Vector3d& axis,
                            double half_angle, double ball_radius, const Precision& precision) {
  Eigen::Vector3d n = axis / std::cos(half_angle);
  const auto error = [&](const Eigen::Vector3d& d) {
    const double length = n.norm();
    return (d.dot(n) - 1.0) / std::sqrt(length * length - 1.0);  // angle inside the cone
  };
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    int support = 0;
    for (const Eigen::Vector3d& d : edges) {
      const double weight = weight_of(error(d), precision.cutoff(iteration));
      if (weight == 0.0) continue;
      normal += weight * d * d.transpose();
      right += weight * d;
      ++support;
    }
    if (support < kMinimumEdges) return std::nullopt;
    n = normal.ldlt().solve(right);
    if (!n.allFinite() || n.norm() <= 1.0) return std::nullopt;
  }
  const Cone cone{n.normalized(), 1.0 / n.norm()};
  const auto inlier = [&](const Eigen::Vector3d& d) {
    return std::abs(error(d)) < precision.finest;
  };
  return Fit{cone_distance(cone, ball_radius) * cone.direction,
             static_cast<int>(std::count_if(edges.begin(), edges.end(), inlier))};
}

/// A sphere on the table: place (x, y) of its centre and a small angle δ by which the picture shows
/// it too large, so that a partly hidden outline cannot trade its size for its place.
///
///   error of a ray d:  angle(d, c) − asin(r / |c|) − δ,   c = X_CW (x, y, height)
std::optional<Fit> fit_on_plane(const CameraModel& camera,
                                const std::vector<Eigen::Vector3d>& edges,
                                const Eigen::Vector3d& axis, const Expectation& expected,
                                const Precision& precision) {
  const std::optional<Eigen::Vector3d> start = intersect_plane(camera, axis, expected.ball_height);
  if (!start) return std::nullopt;
  const Eigen::Isometry3d X_CW = camera.X_WC.inverse();
  const Eigen::Matrix<double, 3, 2> plane = X_CW.linear().leftCols<2>();
  Eigen::Vector3d p_W = *start;
  double delta = 0.0;
  int inliers = 0;
  Eigen::Vector3d c = X_CW * p_W;
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    const double L = c.norm();
    if (!(L > 2.0 * expected.ball_radius)) return std::nullopt;
    const Eigen::Vector3d direction = c / L;
    const double half_angle = std::asin(expected.ball_radius / L);
    const Eigen::Vector3d half_angle_by_c = -std::tan(half_angle) / L * direction;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    int support = 0;
    inliers = 0;
    for (const Eigen::Vector3d& d : edges) {
      const double cosine = d.dot(direction);
      const double sine = std::sqrt(std::max(1e-12, 1.0 - cosine * cosine));
      const double error = std::atan2(sine, cosine) - half_angle - delta;
      if (std::abs(error) < precision.finest) ++inliers;
      const double weight = weight_of(error, precision.cutoff(iteration));
      if (weight == 0.0) continue;
      const Eigen::Vector3d by_c = (cosine * direction - d) / (sine * L) - half_angle_by_c;
      Eigen::Vector3d row;
      row << plane.transpose() * by_c, -1.0;
      normal += weight * row * row.transpose();
      gradient += weight * error * row;
      ++support;
    }
    if (support < kMinimumEdges) return std::nullopt;
    normal(2, 2) += kSizeWeight;
    gradient[2] += kSizeWeight * delta;
    const Eigen::Vector3d step = normal.ldlt().solve(gradient);
    if (!step.allFinite()) return std::nullopt;
    p_W.head<2>() -= step.head<2>();
    delta -= step[2];
    c = X_CW * p_W;
  }
  return Fit{c, inliers};
}

}  // namespace

bool roi_around(const CameraModel& camera, const Expectation& expected, int side,
                Roi& roi) noexcept {
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
  roi.x = std::clamp(static_cast<int>(std::lround(centre.x())) - roi.width / 2, 0,
                     camera.width - roi.width);
  roi.y = std::clamp(static_cast<int>(std::lround(centre.y())) - roi.height / 2, 0,
                     camera.height - roi.height);
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
  return {(full.x() - roi.x + 0.5) / roi.binning - 0.5,
          (full.y() - roi.y + 0.5) / roi.binning - 0.5};
}

std::vector<cv::Vec3f> CircleDetector::circles(const CameraModel& camera, const cv::Mat& image,
                                               const Roi& roi, const Expectation& expected) {
  const Eigen::Vector3d p_C = camera.X_WC.inverse() * expected.p_WB;
  if (!(p_C.z() > 2.0 * expected.ball_radius)) return {};
  if (image.type() == CV_8UC3) {
    // grey things have no difference between red and blue, whatever the light
    cv::extractChannel(image, channel_, 0);
    cv::extractChannel(image, other_, 2);
    cv::subtract(channel_, other_, channel_);
  } else {
    image.copyTo(channel_);
  }
  cv::GaussianBlur(channel_, smooth_, cv::Size(5, 5), parameters_.blur);

  const double radius = expected_radius_px(camera, p_C, expected.ball_radius) / roi.binning;
  const int smallest = static_cast<int>(std::floor(radius * (1.0 - parameters_.radius_tolerance)));
  const int largest = static_cast<int>(std::ceil(radius * (1.0 + parameters_.radius_tolerance)));
  std::vector<cv::Vec3f> found;
  cv::HoughCircles(smooth_, found, cv::HOUGH_GRADIENT, parameters_.hough_resolution, radius,
                   parameters_.hough_edge, parameters_.hough_votes, std::max(1, smallest),
                   std::max(2, largest));

  const Eigen::Vector2d wanted = to_image(roi, project(camera, p_C));
  std::sort(found.begin(), found.end(), [&](const cv::Vec3f& a, const cv::Vec3f& b) {
    return std::hypot(a[0] - wanted.x(), a[1] - wanted.y()) <
           std::hypot(b[0] - wanted.x(), b[1] - wanted.y());
  });
  return found;
}

Detection CircleDetector::detect(const CameraModel& camera, const cv::Mat& image, const Roi& roi,
                                 const Expectation& expected) {
  for (const cv::Vec3f& circle : circles(camera, image, roi, expected)) {
    Detection detection = refine(camera, roi, {circle[0], circle[1]}, circle[2], expected);
    if (detection.found) return detection;
  }
  return {};
}

std::vector<Detection> CircleDetector::detect_all(const CameraModel& camera, const cv::Mat& image,
                                                  const Roi& roi, const Expectation& expected,
                                                  std::size_t most) {
  std::vector<Detection> found;
  for (const cv::Vec3f& circle : circles(camera, image, roi, expected)) {
    Detection detection = refine(camera, roi, {circle[0], circle[1]}, circle[2], expected);
    if (!detection.found) continue;
    // two balls cannot be in one place
    const auto same = std::find_if(found.begin(), found.end(), [&](const Detection& other) {
      return (other.p_WB - detection.p_WB).norm() < expected.ball_radius;
    });
    if (same == found.end()) {
      if (found.size() == most) break;
      found.push_back(detection);
    } else if (detection.visible > same->visible) {
      *same = detection;
    }
  }
  return found;
}

void CircleDetector::find_edges(const CameraModel& camera, const Roi& roi,
                                const Eigen::Vector2d& start, double radius) {
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
}

Detection CircleDetector::refine(const CameraModel& camera, const Roi& roi,
                                 const Eigen::Vector2d& start, double radius,
                                 const Expectation& expected) {
  find_edges(camera, roi, start, radius);
  const Eigen::Vector3d axis = unproject(camera, to_full(roi, start.x(), start.y())).normalized();
  const double pixel = roi.binning / camera.fx * axis.z() * axis.z();  // angle of one pixel, about
  const Precision precision{parameters_.inlier * pixel,
                            std::max(4.0 * parameters_.inlier, kFirstCutoff * radius) * pixel};
  const std::optional<Fit> fit =
      parameters_.position == PositionMethod::kPlane
          ? fit_on_plane(camera, edges_, axis, expected, precision)
          : fit_cone(edges_, axis, radius * pixel, expected.ball_radius, precision);
  if (!fit || fit->p_C.z() <= expected.ball_radius) return {};

  Detection detection;
  detection.visible = static_cast<double>(fit->inliers) / parameters_.rays;
  if (detection.visible < parameters_.visible) return detection;
  detection.found = true;
  detection.p_WB = camera.X_WC * fit->p_C;
  const Outline outline = sphere_outline(fit->p_C, expected.ball_radius);
  detection.centre = project(camera, Eigen::Vector3d(outline.centre.x(), outline.centre.y(), 1.0));
  detection.radius = camera.fx * outline.semi_minor;
  return detection;
}

}  // namespace c3rt::vision
