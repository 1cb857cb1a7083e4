#include "vision/track/fuse.hpp"

#include <Eigen/Cholesky>

namespace c3rt::vision {

Fusion fuse(const std::vector<CameraEstimate>& estimates, const Eigen::Vector3d& p_expected,
            const FusionParameters& parameters) {
  Fusion best;
  best.used.assign(estimates.size(), false);
  double best_distance = 0.0;
  for (const CameraEstimate& member : estimates) {
    if (!member.found) continue;
    Fusion candidate;
    candidate.found = true;
    candidate.used.assign(estimates.size(), false);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      if (!estimates[i].found || (estimates[i].p_WB - member.p_WB).norm() > parameters.outlier)
        continue;
      candidate.used[i] = true;
      candidate.p_WB += estimates[i].p_WB;
      ++candidate.cameras_used;
    }
    candidate.p_WB /= candidate.cameras_used;
    const double distance = (candidate.p_WB - p_expected).norm();
    if (candidate.cameras_used > best.cameras_used ||
        (candidate.cameras_used == best.cameras_used && distance < best_distance)) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

Eigen::Vector3d meeting_point(const std::vector<Ray>& rays) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Ray& ray : rays) {
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - ray.direction * ray.direction.transpose();
    normal += across;
    right += across * ray.origin;
  }
  return normal.ldlt().solve(right);
}

}  // namespace c3rt::vision
