#pragma once
// A body's state from its positions, and of a body that does not roll from its orientations. Pure;
// times are the exposures' stamps.
#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace c3rt::vision {

enum class VelocityFilter {
  kTwoTap,     // v = (1 - b) d(previous) + b d(new)
  kRecursive,  // v = (1 - b) v(previous) + b d(new): smoother, slower
  // With e = p_meas - (p + v dt)(previous): p = p_expected + a e, v = v(previous) + b e / dt. Of
  // the three it carries the least noise for the same lag, and none of a ball that rolls freely.
  kPredicting,
};

struct EstimatorParameters {
  double position_weight;  // a in (0, 1]: of the newest measurement
  double velocity_weight;  // b in (0, 1]: of the newest difference
  VelocityFilter velocity_filter;
  double lost_after;  // without a measurement for longer than this, the ball is lost [s]
  double gate;        // a measurement farther than this from the prediction is not believed ... [m]
  int gate_misses;    // ... unless that happens more than this many times in a row
};

/// What the cameras say about one exposure.
struct Measurement {
  std::int64_t exposure_ns = 0;
  bool found = false;
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // used only if found [m]
  // of a body whose orientation shows; of a ball it does not
  std::optional<Eigen::Quaternion<double, Eigen::DontAlign>> q_WB = {};
  // of (δp, δθ) along W's axes, where the source knows it [m, rad]
  std::optional<Eigen::Matrix<double, 6, 6, Eigen::DontAlign>> covariance = {};
};

struct Estimate {
  std::int64_t exposure_ns = 0;
  bool seen = false;       // at least once
  bool valid = false;      // false: never seen, or lost; the numbers are then the last good ones
  bool measured = false;   // the measurement of this exposure was used
  bool restarted = false;  // the filters started anew with this measurement
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();      // filtered [m]
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();      // [m/s]
  Eigen::Vector3d omega_WB = Eigen::Vector3d::Zero();  // in W [rad/s]
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
};

/// Angular velocity of a ball that rolls on a horizontal table without slipping [C3, VII-A]:
///
///   ω = (r × v) / r²,   r = (0, 0, radius)
///
/// RT: no heap, no lock, no throw.
Eigen::Vector3d rolling_angular_velocity(const Eigen::Vector3d& v_WB, double radius) noexcept;

/// exp(ω dt) q: the orientation after turning with ω (in W) for dt. Normalised. RT: no heap, no
/// lock, no throw.
Eigen::Quaterniond integrate_rotation(const Eigen::Quaterniond& q_WB,
                                      const Eigen::Vector3d& omega_WB, double dt) noexcept;

/// The rotation vector, in W, that turns one orientation into another, 0 … π [rad].
/// RT: no heap, no lock, no throw.
Eigen::Vector3d rotation_between(const Eigen::Quaterniond& from,
                                 const Eigen::Quaterniond& to) noexcept;

/// Low-pass filter of the position, velocity by finite differences of the filtered position over
/// the exposures' stamps, angular velocity and orientation by rolling without slipping [C3, VII-A
/// and VII-C]:
///
///   p = (1 − a) p_meas(previous) + a p_meas(new)
///   d = (p − p(previous)) / dt
///   v = (1 − b) d(previous) + b d(new)          (kTwoTap)
///
/// The orientation of a body that does not roll is corrected as the position by kPredicting, with
/// the same weights, whatever the filter:
///
///   e = log(q_meas q_expected⁻¹),   q = exp(a e) q_expected,   ω = ω(previous) + b e / dt
class Estimator {
 public:
  /// @throws std::invalid_argument if a weight is outside (0, 1], or a length or time is not
  /// positive
  /// @param rolling_radius of a ball; none: a body that lies on its face and is turned [m]
  Estimator(const EstimatorParameters& parameters, std::optional<double> rolling_radius);

  /// One exposure, found or not. Exposures that are not newer than the last one change nothing.
  /// RT: no heap, no lock, no throw.
  const Estimate& step(const Measurement& measurement) noexcept;

  /// Where the ball is expected at an exposure: the last position, carried on with the last
  /// velocity for at most lost_after. RT: no heap, no lock, no throw.
  Eigen::Vector3d predict(std::int64_t exposure_ns) const noexcept;

  const Estimate& estimate() const noexcept { return estimate_; }

 private:
  void restart(const Measurement& measurement) noexcept;
  /// Of a used measurement, dt after the one before it.
  void turn(const Measurement& measurement, double dt) noexcept;

  EstimatorParameters parameters_;
  std::optional<double> radius_;
  Estimate estimate_;
  std::int64_t measured_ns_ = 0;  // exposure of the last measurement that was used
  Eigen::Vector3d p_measured_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d difference_ = Eigen::Vector3d::Zero();
  int misses_ = 0;  // measurements in a row outside the gate
};

}  // namespace c3rt::vision
