#pragma once
// A body's pose and twist from measured poses: a Kalman filter whose error lives in the tangent
// space of SE(3). Pure; times are the exposures' stamps.
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vision/track/estimator.hpp"

namespace c3rt::vision {

struct PoseFilterParameters {
  // what contacts do to the body: its velocity is drawn anew, with these standard deviations, and
  // forgotten after the memory
  double speed;          // [m/s]
  double angular_speed;  // [rad/s]
  double memory;         // 1/e of a velocity is left after it [s]
  double gate;           // a measurement farther than this many standard deviations is not believed
  int gate_misses;       // ... unless that happens more than this many times in a row
  double lost_after;     // without a measurement for longer than this, the body is lost [s]
};

/// The mean is (p, R, v, ω) in W, the error ξ = (δp, δθ, δv, δω) with R_true = exp(δθ×) R, all
/// along W's axes. Velocities die out under friction and are set anew by contacts
/// (Ornstein–Uhlenbeck), so after Δt, with s = τ (1 − e^(−Δt/τ)),
///
///   p + s v,   exp(s ω×) R,   e^(−Δt/τ) v,   e^(−Δt/τ) ω
///
/// and a measured pose corrects by K (p_meas − p, log(R_meas Rᵀ)).
class PoseFilter {
 public:
  using Matrix12 = Eigen::Matrix<double, 12, 12>;

  /// @throws std::invalid_argument for a parameter that is not positive
  explicit PoseFilter(const PoseFilterParameters& parameters);

  /// One exposure, found or not; a found one has an orientation and a covariance. Exposures that
  /// are not newer than the last one change nothing. RT: no heap, no lock, no throw.
  const Estimate& step(const Measurement& measurement) noexcept;

  /// Where the body is expected at an exposure, at most lost_after on.
  /// RT: no heap, no lock, no throw.
  Eigen::Isometry3d predict(std::int64_t exposure_ns) const noexcept;

  const Estimate& estimate() const noexcept { return estimate_; }
  const Matrix12& covariance() const noexcept { return P_; }

  /// How the error and its covariance go on over a time; of a body that turns with ω.
  static Matrix12 transition(const PoseFilterParameters& parameters,
                             const Eigen::Vector3d& omega_WB, double dt) noexcept;
  static Matrix12 process_noise(const PoseFilterParameters& parameters, double dt) noexcept;

 private:
  void restart(const Measurement& measurement) noexcept;
  void advance(double dt) noexcept;

  PoseFilterParameters parameters_;
  Estimate estimate_;
  Matrix12 P_ = Matrix12::Zero();
  std::int64_t measured_ns_ = 0;  // exposure of the last measurement that was used
  int misses_ = 0;
};

}  // namespace c3rt::vision
