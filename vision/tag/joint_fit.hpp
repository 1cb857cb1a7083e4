#pragma once
// One pose from all corners of all tags in all cameras' images. Pure.
#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/scene/object.hpp"
#include "vision/track/sphere.hpp"

namespace c3rt::vision {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct JointFitParameters {
  double corner_noise;  // standard deviation of each coordinate of a seen corner [px]
  double inlier;  // a tag with a corner farther than this from where the pose puts it is an outlier
                  // of that view [px]
};

/// A tag of the body in the image of one camera.
struct TagView {
  int camera = 0;                       // of the list of cameras
  scene::Tag tag;                       // its place on the body
  std::array<Eigen::Vector2d, 4> seen;  // corners, in tag_corners()' order [px]
};

/// Of the black square, as one reads it: lower left, lower right, upper right, upper left. [m]
std::array<Eigen::Vector3d, 4> tag_corners(const scene::Tag& tag) noexcept;

struct JointFit {
  bool found = false;
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // [m]
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  // of (δp, δθ) with p = p_WB + δp [m] and R = exp(δθ×) R_WB [rad], both along W's axes
  Matrix6 covariance = Matrix6::Zero();
  std::vector<bool> used;  // by view
  int views_used = 0;
};

/// The pose that puts the corners of the most views where they are seen, and among those the one
/// with the least sum of squared distances [px²] in these views:
///
///   min Σ |π_c(X_CW X_WB p_B) − u|²,   covariance = σ² (Σ Jᵀ J)⁻¹
///
/// by Gauss and Newton's steps with Levenberg's damping. It begins from the expected pose; where
/// that does not explain three views of four, also from what each single view says alone (a square
/// has one pose but for two ways to tilt it).
///
/// Not found: no view, or one view alone and no expected pose (its tilt may be the other one), or
/// less than half of the views agree.
JointFit fit_pose(const std::vector<CameraModel>& cameras, const std::vector<TagView>& views,
                  const std::optional<Eigen::Isometry3d>& expected,
                  const JointFitParameters& parameters);

/// How large a tag must be for its corners to be seen there, were it on its place on that body: the
/// mean edge of the four points where its plane meets the lines of sight [m]. None: it would be
/// seen from behind.
std::optional<double> seen_size(const CameraModel& camera, const TagView& view,
                                const Eigen::Isometry3d& X_WB) noexcept;

}  // namespace c3rt::vision
