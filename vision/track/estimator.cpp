#include "vision/track/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "controller/base/time.hpp"

namespace c3rt::vision {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

}  // namespace

Eigen::Vector3d rolling_angular_velocity(const Eigen::Vector3d& v_WB, double radius) noexcept {
  return {-v_WB.y() / radius, v_WB.x() / radius, 0.0};
}

Eigen::Quaterniond integrate_rotation(const Eigen::Quaterniond& q_WB,
                                      const Eigen::Vector3d& omega_WB, double dt) noexcept {
  const Eigen::Vector3d half = 0.5 * dt * omega_WB;
  const double angle = half.norm();
  // sin(a)/a by its series where the quotient would lose all digits
  const double scale = angle > 1e-6 ? std::sin(angle) / angle : 1.0 - angle * angle / 6.0;
  Eigen::Quaterniond turn;
  turn.w() = std::cos(angle);
  turn.vec() = scale * half;
  return (turn * q_WB).normalized();
}

Eigen::Vector3d rotation_between(const Eigen::Quaterniond& from,
                                 const Eigen::Quaterniond& to) noexcept {
  Eigen::Quaterniond turn = to * from.conjugate();
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();  // the shorter way
  const double sine = turn.vec().norm();
  if (sine < 1e-9) return 2.0 * turn.vec();
  return 2.0 * std::atan2(sine, turn.w()) / sine * turn.vec();
}

Estimator::Estimator(const EstimatorParameters& parameters, std::optional<double> rolling_radius)
    : parameters_(parameters), radius_(rolling_radius) {
  const auto weight = [](double w) { return w > 0.0 && w <= 1.0; };
  require(weight(parameters.position_weight), "estimator: position_weight is not in (0, 1]");
  require(weight(parameters.velocity_weight), "estimator: velocity_weight is not in (0, 1]");
  require(parameters.lost_after > 0.0, "estimator: lost_after is not positive");
  require(parameters.gate > 0.0, "estimator: gate is not positive");
  require(parameters.gate_misses >= 0, "estimator: gate_misses is negative");
  require(!rolling_radius || *rolling_radius > 0.0, "estimator: ball_radius is not positive");
}

void Estimator::restart(const Measurement& measurement) noexcept {
  estimate_.seen = true;
  estimate_.valid = true;
  estimate_.measured = true;
  estimate_.restarted = true;
  estimate_.p_WB = measurement.p_WB;
  // a difference across the gap would be a velocity that the ball never had
  estimate_.v_WB.setZero();
  estimate_.omega_WB.setZero();
  if (measurement.q_WB) estimate_.q_WB = *measurement.q_WB;
  difference_.setZero();
  p_measured_ = measurement.p_WB;
  measured_ns_ = measurement.exposure_ns;
  misses_ = 0;
}

const Estimate& Estimator::step(const Measurement& measurement) noexcept {
  if (estimate_.seen && measurement.exposure_ns <= estimate_.exposure_ns) return estimate_;
  const Eigen::Vector3d p_expected = predict(measurement.exposure_ns);
  estimate_.exposure_ns = measurement.exposure_ns;
  estimate_.measured = false;
  estimate_.restarted = false;

  const bool turned = !measurement.q_WB || measurement.q_WB->coeffs().allFinite();
  const bool found = measurement.found && measurement.p_WB.allFinite() && turned;
  const double dt = base::seconds(measurement.exposure_ns - measured_ns_);
  if (estimate_.seen && dt > parameters_.lost_after) estimate_.valid = false;

  if (!found) return estimate_;
  if (!estimate_.valid) {
    restart(measurement);
    return estimate_;
  }
  if ((measurement.p_WB - p_expected).norm() > parameters_.gate) {
    // one wild measurement is an error of the cameras; many are a ball that was moved
    if (++misses_ > parameters_.gate_misses) restart(measurement);
    return estimate_;
  }

  const double a = parameters_.position_weight;
  const double b = parameters_.velocity_weight;
  Eigen::Vector3d p, v;
  if (parameters_.velocity_filter == VelocityFilter::kPredicting) {
    const Eigen::Vector3d surprise = measurement.p_WB - p_expected;
    p = p_expected + a * surprise;
    v = estimate_.v_WB + b / dt * surprise;
  } else {
    p = (1.0 - a) * p_measured_ + a * measurement.p_WB;
    const Eigen::Vector3d difference = (p - estimate_.p_WB) / dt;
    const Eigen::Vector3d& previous =
        parameters_.velocity_filter == VelocityFilter::kTwoTap ? difference_ : estimate_.v_WB;
    v = (1.0 - b) * previous + b * difference;
    difference_ = difference;
  }

  estimate_.p_WB = p;
  estimate_.v_WB = v;
  turn(measurement, dt);
  estimate_.measured = true;
  p_measured_ = measurement.p_WB;
  measured_ns_ = measurement.exposure_ns;
  misses_ = 0;
  return estimate_;
}

void Estimator::turn(const Measurement& measurement, double dt) noexcept {
  if (radius_) estimate_.omega_WB = rolling_angular_velocity(estimate_.v_WB, *radius_);
  estimate_.q_WB = integrate_rotation(estimate_.q_WB, estimate_.omega_WB, dt);
  if (radius_ || !measurement.q_WB) return;
  const Eigen::Vector3d e = rotation_between(estimate_.q_WB, *measurement.q_WB);
  estimate_.q_WB = integrate_rotation(estimate_.q_WB, e, parameters_.position_weight);
  estimate_.omega_WB += parameters_.velocity_weight / dt * e;
}

Eigen::Vector3d Estimator::predict(std::int64_t exposure_ns) const noexcept {
  const double dt =
      std::clamp(base::seconds(exposure_ns - measured_ns_), 0.0, parameters_.lost_after);
  return estimate_.p_WB + dt * estimate_.v_WB;
}

}  // namespace c3rt::vision
