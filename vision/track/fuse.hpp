#pragma once
// Several cameras' positions of one ball -> one position.
#include <vector>

#include <Eigen/Core>

namespace c3rt::vision {

struct FusionParameters {
  double outlier;  // estimates farther apart than this do not agree [m]
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

}  // namespace c3rt::vision
