#pragma once
// Several cameras' positions of one ball -> one position.
#include <vector>

#include <Eigen/Core>

namespace c3rt::vision {

struct FusionParameters {
  double outlier;     // estimates farther apart than this do not agree [m]
  bool rays = false;  // of two cameras or more: where their rays meet, not the mean of their
                      // positions, so that the table's height need not be known
};

/// One camera's estimate of the ball's centre.
struct CameraEstimate {
  bool found = false;
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // [m]
};

struct Fusion {
  bool found = false;
  int cameras_used = 0;
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // mean of those used [m]
  std::vector<bool> used;                          // by camera
};

/// Compares the cameras' estimates, rejects outliers and averages the rest [C3, VII-C].
///
/// The largest set of cameras that agree with one of its members within `outlier` is used. Where
/// two such sets are equally large (two cameras that contradict each other), the one nearest to
/// `p_expected` is.
Fusion fuse(const std::vector<CameraEstimate>& estimates, const Eigen::Vector3d& p_expected,
            const FusionParameters& parameters);

/// A camera's centre and the direction in which it sees the ball's centre, in W.
struct Ray {
  Eigen::Vector3d origin;     // [m]
  Eigen::Vector3d direction;  // unit
};

/// The point with the least sum of squared distances to the rays' lines; they must not all be
/// parallel.
///
///   Σ (I − dᵢ dᵢᵀ) (p − oᵢ) = 0
Eigen::Vector3d meeting_point(const std::vector<Ray>& rays);

}  // namespace c3rt::vision
