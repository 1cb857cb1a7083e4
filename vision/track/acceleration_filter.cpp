#include "vision/track/acceleration_filter.hpp"

#include <cmath>

namespace c3rt::vision {
namespace {

constexpr double kUnknownSpeed = 1.0;  // what a contact may leave [m/s]
constexpr double kLongestPause = 0.2;  // between positions of one stretch [s]
constexpr double kGate = 6.0;          // standard deviations: farther off, somebody pushed the body

}  // namespace

AccelerationFilter::AccelerationFilter(const AccelerationFilterParameters& parameters)
    : parameters_(parameters) {
  covariance_(2, 2) = parameters.limit * parameters.limit;
}

void AccelerationFilter::start_stretch(const Eigen::Vector2d& p_WB) noexcept {
  mean_.row(0) = p_WB.transpose();
  mean_.row(1).setZero();
  const double of_acceleration = covariance_(2, 2);
  covariance_.setZero();
  covariance_(0, 0) = parameters_.noise * parameters_.noise;
  covariance_(1, 1) = kUnknownSpeed * kUnknownSpeed;
  covariance_(2, 2) = of_acceleration;
}

void AccelerationFilter::observe(double time, const Eigen::Vector2d& p_WB, bool touched) noexcept {
  if (!std::isfinite(time) || !p_WB.allFinite() || (time_ >= 0.0 && time <= time_)) return;
  const double dt = time - time_;
  const bool first = time_ < 0.0;
  time_ = time;
  if (first || touched || dt > kLongestPause) {
    start_stretch(p_WB);
    return;
  }

  Eigen::Matrix3d step = Eigen::Matrix3d::Identity();
  step(0, 1) = step(1, 2) = dt;
  step(0, 2) = 0.5 * dt * dt;
  mean_ = step * mean_;
  covariance_ = step * covariance_ * step.transpose();
  // what was seen long ago counts for less, and nothing for less than nothing was known
  const double limit = parameters_.limit * parameters_.limit;
  covariance_(2, 2) += std::fmin(covariance_(2, 2) * 2.0 * dt / parameters_.memory,
                                 std::fmax(0.0, limit - covariance_(2, 2)));

  const Eigen::RowVector2d surprise = p_WB.transpose() - mean_.row(0);
  const double variance = covariance_(0, 0) + parameters_.noise * parameters_.noise;
  if (surprise.squaredNorm() > kGate * kGate * variance) {
    start_stretch(p_WB);
    return;
  }
  const Eigen::Vector3d gain = covariance_.col(0) / variance;
  mean_ += gain * surprise;
  covariance_ -= gain * gain.transpose() * variance;

  acceleration_ = mean_.row(2).transpose();
  const double size = acceleration_.norm();
  if (size > parameters_.limit) acceleration_ *= parameters_.limit / size;
}

}  // namespace c3rt::vision
