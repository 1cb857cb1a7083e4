#include "vision/tag/pose_filter.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>

#include "controller/base/time.hpp"

namespace c3rt::vision {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Eigen::Matrix3d;

/// How long a velocity acts within dt.
double effective(double dt, double memory) { return -memory * std::expm1(-dt / memory); }

/// exp(θ + δ) = exp(J(θ) δ) exp(θ) to first order in δ:
///
///   J(θ) = I + (1 − cos a)/a² θ× + (a − sin a)/a³ θ×²,   a = |θ|
Matrix3d rotation_jacobian(const Eigen::Vector3d& theta) {
  const double a = theta.norm();
  Matrix3d cross;
  cross << 0.0, -theta.z(), theta.y(), theta.z(), 0.0, -theta.x(), -theta.y(), theta.x(), 0.0;
  // by their series where the quotients would lose their digits
  const double first = a > 1e-3 ? (1.0 - std::cos(a)) / (a * a) : 0.5 - a * a / 24.0;
  const double second = a > 1e-3 ? (a - std::sin(a)) / (a * a * a) : 1.0 / 6.0 - a * a / 120.0;
  return Matrix3d::Identity() + first * cross + second * cross * cross;
}

}  // namespace

PoseFilter::PoseFilter(const PoseFilterParameters& parameters) : parameters_(parameters) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  require(parameters.speed > 0.0, "pose filter: speed is not positive");
  require(parameters.angular_speed > 0.0, "pose filter: angular_speed is not positive");
  require(parameters.memory > 0.0, "pose filter: memory is not positive");
  require(parameters.gate > 0.0, "pose filter: gate is not positive");
  require(parameters.gate_misses >= 0, "pose filter: gate_misses is negative");
  require(parameters.lost_after > 0.0, "pose filter: lost_after is not positive");
}

PoseFilter::Matrix12 PoseFilter::transition(const PoseFilterParameters& parameters,
                                            const Eigen::Vector3d& omega_WB, double dt) noexcept {
  const double s = effective(dt, parameters.memory), left = std::exp(-dt / parameters.memory);
  const Eigen::Vector3d turn = s * omega_WB;
  Matrix12 F = Matrix12::Identity();
  F.block<3, 3>(0, 6) = s * Matrix3d::Identity();
  F.block<3, 3>(3, 3) =
      integrate_rotation(Eigen::Quaterniond::Identity(), turn, 1.0).toRotationMatrix();
  F.block<3, 3>(3, 9) = s * rotation_jacobian(turn);
  F.block<6, 6>(6, 6) = left * Matrix6::Identity();
  return F;
}

PoseFilter::Matrix12 PoseFilter::process_noise(const PoseFilterParameters& parameters,
                                               double dt) noexcept {
  // dv = −v/τ dt + √(2/τ) σ dw: v has the variance σ² for ever, p what is the integral of it
  const double tau = parameters.memory, h = dt / tau;
  const double gone = -std::expm1(-h), gone_twice = -std::expm1(-2.0 * h);
  const double vv = gone_twice, pv = tau * gone * gone,
               pp = tau * tau * (2.0 * h - 4.0 * gone + gone_twice);
  Matrix12 Q = Matrix12::Zero();
  for (int axis = 0; axis < 6; ++axis) {
    const double sigma = axis < 3 ? parameters.speed : parameters.angular_speed;
    Q(axis, axis) = sigma * sigma * pp;
    Q(axis, axis + 6) = Q(axis + 6, axis) = sigma * sigma * pv;
    Q(axis + 6, axis + 6) = sigma * sigma * vv;
  }
  return Q;
}

void PoseFilter::restart(const Measurement& measurement) noexcept {
  estimate_.seen = estimate_.valid = estimate_.measured = estimate_.restarted = true;
  estimate_.p_WB = measurement.p_WB;
  estimate_.q_WB = *measurement.q_WB;
  estimate_.v_WB.setZero();
  estimate_.omega_WB.setZero();
  P_.setZero();
  P_.topLeftCorner<6, 6>() = *measurement.covariance;
  P_.diagonal().segment<3>(6).setConstant(parameters_.speed * parameters_.speed);
  P_.diagonal().segment<3>(9).setConstant(parameters_.angular_speed * parameters_.angular_speed);
  measured_ns_ = measurement.exposure_ns;
  misses_ = 0;
}

void PoseFilter::advance(double dt) noexcept {
  const Matrix12 F = transition(parameters_, estimate_.omega_WB, dt);
  P_ = F * P_ * F.transpose() + process_noise(parameters_, dt);
  const double s = effective(dt, parameters_.memory), left = std::exp(-dt / parameters_.memory);
  estimate_.p_WB += s * estimate_.v_WB;
  estimate_.q_WB = integrate_rotation(estimate_.q_WB, estimate_.omega_WB, s);
  estimate_.v_WB *= left;
  estimate_.omega_WB *= left;
}

Eigen::Isometry3d PoseFilter::predict(std::int64_t exposure_ns) const noexcept {
  const double dt =
      std::clamp(base::seconds(exposure_ns - estimate_.exposure_ns), 0.0, parameters_.lost_after);
  const double s = effective(dt, parameters_.memory);
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = integrate_rotation(estimate_.q_WB, estimate_.omega_WB, s).toRotationMatrix();
  X_WB.translation() = estimate_.p_WB + s * estimate_.v_WB;
  return X_WB;
}

const Estimate& PoseFilter::step(const Measurement& measurement) noexcept {
  const std::int64_t now_ns = measurement.exposure_ns;
  if (estimate_.seen && now_ns <= estimate_.exposure_ns) return estimate_;
  if (estimate_.valid) advance(base::seconds(now_ns - estimate_.exposure_ns));
  estimate_.exposure_ns = now_ns;
  estimate_.measured = false;
  estimate_.restarted = false;
  if (estimate_.seen && base::seconds(now_ns - measured_ns_) > parameters_.lost_after)
    estimate_.valid = false;

  const bool found = measurement.found && measurement.q_WB && measurement.covariance &&
                     measurement.p_WB.allFinite() && measurement.q_WB->coeffs().allFinite() &&
                     measurement.covariance->allFinite();
  if (!found) return estimate_;
  if (!estimate_.valid) {
    restart(measurement);
    return estimate_;
  }
  Vector6 surprise;
  surprise << measurement.p_WB - estimate_.p_WB,
      rotation_between(estimate_.q_WB, *measurement.q_WB);
  const Matrix6 S = P_.topLeftCorner<6, 6>() + *measurement.covariance;
  const Eigen::LLT<Matrix6> factors(S);
  const bool believed = factors.info() == Eigen::Success && surprise.dot(factors.solve(surprise)) <=
                                                                parameters_.gate * parameters_.gate;
  if (!believed) {
    // one wild pose is an error of the cameras; many are a body that was moved
    if (++misses_ > parameters_.gate_misses) restart(measurement);
    return estimate_;
  }
  const Eigen::Matrix<double, 12, 6> K =
      factors.solve(P_.topRows<6>()).transpose();  // P Hᵀ S⁻¹, of symmetric P and S
  const Vector12 by = K * surprise;
  estimate_.p_WB += by.head<3>();
  estimate_.q_WB = integrate_rotation(estimate_.q_WB, by.segment<3>(3), 1.0);
  estimate_.v_WB += by.segment<3>(6);
  estimate_.omega_WB += by.tail<3>();
  // Joseph's form keeps it symmetric and positive
  Matrix12 left = Matrix12::Identity();
  left.leftCols<6>() -= K;
  P_ = left * P_ * left.transpose() + K * *measurement.covariance * K.transpose();
  estimate_.measured = true;
  measured_ns_ = now_ns;
  misses_ = 0;
  return estimate_;
}

}  // namespace c3rt::vision
