#include "vision/track/detect.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>
#include <opencv2/core.hpp>

#include "controller/base/random.hpp"

using namespace c3rt::vision;

namespace {

constexpr double kRadius = 0.0315;

DetectorParameters parameters() {
  DetectorParameters p{};
  p.roi = 80;
  p.search_binning = 2;
  p.blur = 1.0;
  p.hough_resolution = 1.0;
  p.hough_edge = 60;
  p.hough_votes = 8;
  p.radius_tolerance = 0.25;
  p.search_radius_tolerance = 0.4;
  p.rays = 72;
  p.edge_contrast = 12;
  p.inlier = 0.7;
  p.visible = 0.4;
  p.position = PositionMethod::kPlane;
  return p;
}

CameraModel camera() {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.translation() = Eigen::Vector3d(1.2, 0.1, 0.7);
  X_WC.linear() = look_at(X_WC.translation(), {0.55, 0, 0.03});
  return centred_camera(640, 480, 0.8, X_WC);
}

struct Disc {
  Eigen::Vector2d centre;  // in the full image [px]
  double radius;           // [px]
};

/// A picture by brute force: 8 x 8 rays per pixel against the sphere itself, orange with the
/// shading of a lamp above, on a grey table; discs are dark things in front.
cv::Mat picture(const CameraModel& model, const Roi& roi, const std::vector<Eigen::Vector3d>& balls,
                const std::vector<Disc>& in_front, double noise) {
  cv::Mat image(roi.height / roi.binning, roi.width / roi.binning, CV_8UC3);
  c3rt::base::Random random(5);
  constexpr int kFine = 8;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int k = 0; k < kFine * kFine; ++k) {
        const double i = column + (k % kFine + 0.5) / kFine - 0.5;
        const double j = row + (k / kFine + 0.5) / kFine - 0.5;
        const Eigen::Vector2d pixel = to_full(roi, i, j);
        Eigen::Vector3d colour(175, 177, 180);
        for (const Eigen::Vector3d& p_WB : balls) {
          const Eigen::Vector3d c = model.X_WC.inverse() * p_WB;
          const Eigen::Vector3d d = unproject(model, pixel).normalized();
          const double middle = d.dot(c);
          const double inside = middle * middle - c.squaredNorm() + kRadius * kRadius;
          if (inside < 0.0) continue;
          const Eigen::Vector3d normal_W =
              model.X_WC.linear() * ((middle - std::sqrt(inside)) * d - c) / kRadius;
          colour = (0.35 + 0.55 * std::max(0.0, normal_W.z())) * Eigen::Vector3d(230, 84, 20);
        }
        for (const Disc& disc : in_front) {
          if ((pixel - disc.centre).norm() < disc.radius) colour.setConstant(25);
        }
        sum += colour;
      }
      cv::Vec3b& out = image.at<cv::Vec3b>(row, column);
      for (int c = 0; c < 3; ++c) {
        out[c] =
            cv::saturate_cast<std::uint8_t>(sum[c] / (kFine * kFine) + noise * random.normal());
      }
    }
  }
  return image;
}

struct Result {
  Detection detection;
  Eigen::Vector2d true_centre;  // of the outline [px]
};

Result look(const Eigen::Vector3d& p_WB, const std::vector<Disc>& relative_discs, double noise,
            const DetectorParameters& with = parameters()) {
  const CameraModel model = camera();
  const Eigen::Vector3d c = model.X_WC.inverse() * p_WB;
  const Outline outline = sphere_outline(c, kRadius);
  const Eigen::Vector2d centre =
      project(model, Eigen::Vector3d(outline.centre.x(), outline.centre.y(), 1.0));
  std::vector<Disc> discs = relative_discs;
  for (Disc& disc : discs) disc.centre += centre;
  // the expectation is a little off, as a prediction is
  const Expectation expected{p_WB + Eigen::Vector3d(0.004, -0.003, 0.0), kRadius, kRadius};
  Roi roi;
  REQUIRE(roi_around(model, expected, with.roi, roi));
  CircleDetector detector(with);
  return {detector.detect(model, picture(model, roi, {p_WB}, discs, noise), roi, expected), centre};
}

const std::vector<Eigen::Vector3d> kPlaces = {{0.55, 0.1, kRadius},      {0.6503, 0.0011, kRadius},
                                              {0.5517, -0.103, kRadius}, {0.4491, 0.0204, kRadius},
                                              {0.4, 0.3, kRadius},       {0.7, -0.25, kRadius}};

}  // namespace

TEST_CASE(
    "detect: a ball in full view is found to a twentieth of a pixel and a tenth of a millimetre") {
  for (const Eigen::Vector3d& p_WB : kPlaces) {
    const Result result = look(p_WB, {}, 0.0);
    REQUIRE(result.detection.found);
    REQUIRE(result.detection.visible > 0.95);
    REQUIRE((result.detection.centre - result.true_centre).norm() < 0.05);
    REQUIRE((result.detection.p_WB - p_WB).norm() < 1e-4);
  }
}

TEST_CASE("detect: the position from the outline's size needs no table") {
  DetectorParameters with = parameters();
  with.position = PositionMethod::kRadius;
  for (const Eigen::Vector3d& p_WB : kPlaces) {
    const Eigen::Vector3d lifted = p_WB + Eigen::Vector3d(0, 0, 0.05);
    const Result result = look(lifted, {}, 0.0, with);
    REQUIRE(result.detection.found);
    // smoothing draws a round edge inwards by about a tenth of a pixel: of 19 pixels at 1 m, 5 mm
    REQUIRE((result.detection.p_WB - lifted).norm() < 8e-3);
  }
}

TEST_CASE(
    "detect: an end effector that hides a quarter of the outline shifts it by less than half a "
    "millimetre") {
  for (const Eigen::Vector3d& p_WB : kPlaces) {
    for (int direction = 0; direction < 8; ++direction) {
      const double angle = direction * M_PI / 4;
      // a sphere of 10 pixels across the rim of a ball of about 19
      const Disc disc{13.0 * Eigen::Vector2d(std::cos(angle), std::sin(angle)), 10.0};
      const Result result = look(p_WB, {disc}, 0.0);
      REQUIRE(result.detection.found);
      REQUIRE(result.detection.visible < 0.9);
      REQUIRE((result.detection.p_WB - p_WB).norm() < 5e-4);
    }
  }
}

TEST_CASE("detect: grey noise of 4 levels costs a fifth of a millimetre at most") {
  for (const Eigen::Vector3d& p_WB : kPlaces) {
    const Result result = look(p_WB, {}, 4.0);
    REQUIRE(result.detection.found);
    REQUIRE((result.detection.p_WB - p_WB).norm() < 2e-4);
  }
}

TEST_CASE("detect: no ball, or one that is nearly hidden, is not found") {
  const Eigen::Vector3d p_WB = kPlaces[0];
  REQUIRE_FALSE(look(p_WB, {{{0, 0}, 30.0}}, 2.0).detection.found);
  // of the outline, of about 19 pixels, a quarter is left
  REQUIRE_FALSE(look(p_WB, {{{-8, 0}, 25.0}}, 0.0).detection.found);
}

TEST_CASE("detect: of two balls the one nearer to the expectation is taken") {
  const CameraModel model = camera();
  const Eigen::Vector3d one(0.55, 0.03, kRadius), other(0.55, -0.04, kRadius);
  const Roi roi = full_roi(model, 2);
  const cv::Mat image = picture(model, roi, {one, other}, {}, 0.0);
  CircleDetector detector(parameters());
  for (const Eigen::Vector3d& wanted : {one, other}) {
    const Detection detection = detector.detect(
        model, image, roi, {wanted + Eigen::Vector3d(0.01, 0, 0), kRadius, kRadius});
    REQUIRE(detection.found);
    REQUIRE((detection.p_WB - wanted).norm() < 1e-3);
  }
}

TEST_CASE("detect: the region of interest stays inside the picture, and a ball outside has none") {
  const CameraModel model = camera();
  Roi roi;
  REQUIRE(roi_around(model, {{0.55, 0.0, kRadius}, kRadius, kRadius}, 80, roi));
  for (const Eigen::Vector3d& p_WB : kPlaces) {
    REQUIRE(roi_around(model, {p_WB, kRadius, kRadius}, 80, roi));
    REQUIRE(roi.x >= 0);
    REQUIRE(roi.y >= 0);
    REQUIRE(roi.x + roi.width <= model.width);
    REQUIRE(roi.y + roi.height <= model.height);
  }
  REQUIRE_FALSE(
      roi_around(model, {{-3.0, 0.0, kRadius}, kRadius, kRadius}, 80, roi));  // far outside
  REQUIRE_FALSE(
      roi_around(model, {{2.5, 0.0, 1.0}, kRadius, kRadius}, 80, roi));  // behind the camera
}

TEST_CASE("detect: pixels of a binned region and of the full image map onto each other") {
  const Roi roi{100, 60, 80, 80, 4};
  // image pixel 0 joins the pixels 100..103, whose middle is 101.5
  REQUIRE(to_full(roi, 0, 0) == Eigen::Vector2d(101.5, 61.5));
  REQUIRE((to_image(roi, to_full(roi, 3.25, 7.5)) - Eigen::Vector2d(3.25, 7.5)).norm() < 1e-12);
}
