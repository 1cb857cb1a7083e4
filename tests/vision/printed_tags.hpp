#pragma once
// A camera that is no renderer's: it draws printed tags by the homography of each, which is all
// that a pinhole does to a plane.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "controller/scene/object.hpp"
#include "vision/apriltag.hpp"
#include "vision/camera.hpp"

namespace c3rt::vision::test {

/// A tag somewhere in the world: tag.p_BT and R_BT are those in W.
using PrintedTags = std::vector<scene::Tag>;

inline PrintedTags printed(const std::vector<scene::Tag>& tags, const Eigen::Isometry3d& X_WB) {
  PrintedTags in_world = tags;
  for (scene::Tag& tag : in_world) {
    tag.p_BT = X_WB * tag.p_BT;
    tag.R_BT = X_WB.linear() * tag.R_BT;
  }
  return in_world;
}

class PrintedCamera : public Camera {
 public:
  explicit PrintedCamera(const CameraModel& model) : model_(model) {}
  const CameraModel& model() const override { return model_; }

  bool grab(std::int64_t, const Roi& roi, cv::Mat& image) override {
    if (blind) return false;
    const cv::Size fine(roi.width / roi.binning * kFine, roi.height / roi.binning * kFine);
    const double scale = static_cast<double>(kFine) / roi.binning;
    cv::Mat grey(fine, CV_8UC1, cv::Scalar(170));
    for (const scene::Tag& tag : tags) {
      const plant::TagPicture picture = tag_picture(tag.id);
      cv::Mat cells(picture.side, picture.side, CV_8UC1);
      std::copy(picture.cells.begin(), picture.cells.end(), cells.data);
      cv::Mat paper;
      cv::resize(cells, paper, {}, kPixels, kPixels, cv::INTER_NEAREST);
      const double half = 0.5 * tag.size * picture.side / (picture.side - 2 * picture.border);
      const auto side = static_cast<float>(paper.cols);
      const std::array<cv::Point2f, 4> from{
          cv::Point2f(-0.5F, side - 0.5F), cv::Point2f(side - 0.5F, side - 0.5F),
          cv::Point2f(side - 0.5F, -0.5F), cv::Point2f(-0.5F, -0.5F)};
      std::array<cv::Point2f, 4> to;
      const std::array<Eigen::Vector2d, 4> at{
          Eigen::Vector2d(-half, -half), {half, -half}, {half, half}, {-half, half}};
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d p_W =
            tag.p_BT + tag.R_BT * Eigen::Vector3d(at[k].x(), at[k].y(), 0.0);
        const Eigen::Vector2d full = project(model_, model_.X_WC.inverse() * p_W);
        to[k] = cv::Point2f(static_cast<float>((full.x() - roi.x + 0.5) * scale - 0.5),
                            static_cast<float>((full.y() - roi.y + 0.5) * scale - 0.5));
      }
      cv::warpPerspective(paper, grey, cv::getPerspectiveTransform(from.data(), to.data()), fine,
                          cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
    }
    cv::Mat coarse;
    cv::resize(grey, coarse, {}, 1.0 / kFine, 1.0 / kFine, cv::INTER_AREA);
    cv::cvtColor(coarse, image, cv::COLOR_GRAY2RGB);
    return true;
  }

  PrintedTags tags;
  bool blind = false;

 private:
  static constexpr int kFine = 4;     // as many times finer it is drawn
  static constexpr int kPixels = 16;  // of a cell on paper
  CameraModel model_;
};

inline CameraModel table_camera(const Eigen::Vector3d& p_WC) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() = look_at(p_WC, {0.55, 0, 0.03});
  X_WC.translation() = p_WC;
  return centred_camera(1280, 960, 0.8, X_WC);
}

}  // namespace c3rt::vision::test
