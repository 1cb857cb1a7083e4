#pragma once
// What accelerates a body that rolls freely: a table that is tilted, and that planners know as
// level. Pure; times are the exposures' stamps.
#include <Eigen/Core>

namespace c3rt::vision {

struct AccelerationFilterParameters {
  double noise;   // of a seen position, standard deviation [m]
  double memory;  // what was seen longer ago than this, of untouched rolling, fades [s]
  double limit;   // the acceleration is never longer than this [m/s²]
  double gap;     // an end effector nearer than this may touch the body [m]
  double settle;  // nor is the body looked at for this long after a touch [s]
};

/// Kalman filter of (p, v, a) for x and y alike: a is constant, and v is known anew whenever the
/// body was touched, as a contact may change it by any amount but leaves a as it is. So a is drawn
/// together from many short stretches of rolling freely.
class AccelerationFilter {
 public:
  explicit AccelerationFilter(const AccelerationFilterParameters& parameters);

  /// One seen position of the body. Not finite, or not newer than the last one: nothing changes.
  /// @param time of the exposure [s]  @param p_WB (x, y) [m]
  /// @param touched the body may have been touched since the last one
  /// RT: no heap, no lock, no throw.
  void observe(double time, const Eigen::Vector2d& p_WB, bool touched) noexcept;

  /// Never longer than AccelerationFilterParameters::limit [m/s²].
  const Eigen::Vector2d& acceleration() const noexcept { return acceleration_; }

 private:
  void start_stretch(const Eigen::Vector2d& p_WB) noexcept;

  AccelerationFilterParameters parameters_;
  double time_ = -1.0;  // of the last position [s]; negative: none yet
  Eigen::Matrix<double, 3, 2> mean_ = Eigen::Matrix<double, 3, 2>::Zero();  // p, v, a of x and of y
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();                    // of both alike
  Eigen::Vector2d acceleration_ = Eigen::Vector2d::Zero();
};

}  // namespace c3rt::vision
