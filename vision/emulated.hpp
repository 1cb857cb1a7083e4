#pragma once
// The emulated sensor: ground truth at the exposure plus errors; white noise is that of the paper's
// simulation (VII-A).
#include <cstdint>
#include <deque>
#include <vector>

#include <Eigen/Geometry>

#include "controller/base/random.hpp"
#include "vision/parameters.hpp"

namespace c3rt::vision {

/// Where a body is.
struct BodyPose {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // [m]
  Eigen::Quaternion<double, Eigen::DontAlign> q_WB = Eigen::Quaterniond::Identity();
};

class EmulatedSensor {
 public:
  EmulatedSensor(const EmulatedParameters& parameters, std::uint64_t seed)
      : parameters_(parameters), random_(seed), drift_random_(seed ^ kDriftStream) {}

  /// The poses of all bodies at an instant, in order of time.
  void see(std::int64_t time_ns, std::vector<BodyPose> poses);

  /// A body at an exposure, which is one of the instants seen. x and y have N(0, noise)
  /// on them, clipped to ±clip, and the drift; z stays exact, as on a table of known height, and
  /// the orientation is turned about z.
  /// @param turned whether its orientation shows and is measured, too
  BodyPose measure(std::size_t body, std::int64_t exposure_ns, bool turned);

 private:
  /// x(t + Δt) = e^(−Δt/τ) x(t) + σ √(1 − e^(−2Δt/τ)) N(0, 1), on x and y [m] and about z [rad].
  struct Drift {
    std::int64_t time_ns = 0;  // 0: not drawn yet
    Eigen::Vector3d error = Eigen::Vector3d::Zero();
  };
  const Eigen::Vector3d& drift(std::size_t body, std::int64_t exposure_ns);
  /// Between the two instants about that time; the oldest one where none is that old.
  BodyPose pose_at(std::size_t body, std::int64_t time_ns) const;

  static constexpr double kLate = 1.0;  // an exposure is measured no later than this [s]
  // the white noise of a seed does not depend on whether there is drift
  static constexpr std::uint64_t kDriftStream = 0xA24BAED4963EE407;

  struct Instant {
    std::int64_t time_ns;
    std::vector<BodyPose> poses;
  };
  EmulatedParameters parameters_;
  base::Random random_, drift_random_;
  std::deque<Instant> seen_;
  std::vector<Drift> drifts_;
};

}  // namespace c3rt::vision
