#include "plant_emulator/guard.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace c3rt::plant {
namespace {

constexpr double kFilter = 0.01;           // time constant of the low-pass; ours [s]
constexpr double kAccelerates = 0.5;       // a joint, filtered; ours [rad/s²]
constexpr double kSingularDamping = 0.01;  // of the wrench near singular poses; ours [m]

template <typename Values, typename Limits>
std::uint32_t above(const Values& values, const Limits& limits) noexcept {
  std::uint32_t bits = 0;
  for (int i = 0; i < static_cast<int>(values.size()); ++i)
    bits |= static_cast<std::uint32_t>(std::abs(values[i]) > limits[i]) << i;
  return bits;
}

}  // namespace

void judge_limits(const Measured& measured, const Parameters& parameters,
                  Findings& findings) noexcept {
  const JointLimits& limits = parameters.limits;
  judge_range(Error::kJointPositionLimitsViolation, "rad", measured.q, limits.q_min, limits.q_max,
              findings);
  judge_sizes(Error::kJointVelocityViolation, "rad/s", measured.dq, limits.dq_max, findings);
  const Safety& safety = parameters.safety;
  judge_sizes(Error::kTauJRangeViolation, "N m", measured.tau_sensor, safety.tau_sensor_max,
              findings);
  const double v = measured.V_WE.head<3>().norm(), omega = measured.V_WE.tail<3>().norm();
  if (v > safety.velocity_max)
    findings.add({Error::kCartesianVelocityViolation, 0, v, safety.velocity_max, "m/s"});
  if (omega > safety.angular_velocity_max)
    findings.add(
        {Error::kCartesianVelocityViolation, 0, omega, safety.angular_velocity_max, "rad/s"});
  const double power = measured.tau.dot(measured.dq);
  if (power > safety.power_max)
    findings.add({Error::kPowerLimitViolation, 0, power, safety.power_max, "W"});
  if (measured.clearance < safety.clearance_min)
    findings.add({Error::kSelfCollisionAvoidanceViolation, 0, measured.clearance,
                  safety.clearance_min, "m"});
  if (!parameters.walls) return;
  judge_range(Error::kCartesianPositionLimitsViolation, "m", measured.p_WE, parameters.walls->min,
              parameters.walls->max, findings);
}

void judge_contacts(const External& external, const CollisionBehavior& behavior, Contacts& contacts,
                    Findings& findings) noexcept {
  const Thresholds& at = external.accelerates ? behavior.acceleration : behavior.nominal;
  contacts.joint = above(external.tau, at.contact_torque);
  contacts.cartesian = above(external.wrench_E, at.contact_force);
  contacts.joint_collision |= above(external.tau, at.collision_torque);
  contacts.cartesian_collision |= above(external.wrench_E, at.collision_force);
  judge_sizes(Error::kJointReflex, "N m", external.tau, at.collision_torque, findings);
  judge_sizes(Error::kCartesianReflex, "N", external.wrench_E.head<3>(),
              at.collision_force.head<3>(), findings);
  for (int i = 3; i < 6; ++i) {
    if (std::abs(external.wrench_E[i]) > at.collision_force[i])
      findings.add(
          {Error::kCartesianReflex, i + 1, external.wrench_E[i], at.collision_force[i], "N m"});
  }
}

void judge_torque_step(const Vector7d& before, const Vector7d& command, double rate_max,
                       double cycle, Findings& findings) noexcept {
  // the limit itself is allowed, whatever its rounding
  constexpr double kRounding = 1e-9;
  const Vector7d rate = (command - before) / cycle;
  judge_sizes(Error::kControllerTorqueDiscontinuity, "N m/s", rate,
              Vector7d::Constant(rate_max * (1.0 + kRounding)), findings);
}

double segment_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& c, const Eigen::Vector3d& d) noexcept {
  const Eigen::Vector3d u = b - a, v = d - c, w = a - c;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), uw = u.dot(w), vw = v.dot(w);
  constexpr double kPoint = 1e-12;  // shorter than a micrometre: a point [m²]
  const auto cut = [](double share) { return std::clamp(share, 0.0, 1.0); };
  const double determinant = uu * vv - uv * uv;
  double s = determinant > kPoint * uu * vv ? cut((uv * vw - vv * uw) / determinant) : 0.0;
  const double t = vv > kPoint ? cut((uv * s + vw) / vv) : 0.0;
  // the best point of the first for that of the second
  if (uu > kPoint) s = cut((uv * t - uw) / uu);
  return (w + s * u - t * v).norm();
}

const External& ExternalEstimator::step(const Vector7d& residual, const Vector7d& acceleration,
                                        const Eigen::Matrix<double, 6, kJoints>& J_WE,
                                        const Eigen::Quaterniond& q_WE, double cycle) noexcept {
  const double share = cycle / (kFilter + cycle);
  external_.tau += share * (residual - external_.tau);
  acceleration_ += share * (acceleration - acceleration_);
  external_.accelerates = acceleration_.cwiseAbs().maxCoeff() > kAccelerates;
  // τ = Jᵀ F, least squares: F = (J Jᵀ + damping)⁻¹ J τ
  Eigen::Matrix<double, 6, 6> JJt = J_WE * J_WE.transpose();
  JJt.diagonal().array() += kSingularDamping * kSingularDamping;
  external_.wrench_W = JJt.ldlt().solve(J_WE * external_.tau);
  external_.wrench_E.head<3>() = q_WE.conjugate() * external_.wrench_W.head<3>();
  external_.wrench_E.tail<3>() = q_WE.conjugate() * external_.wrench_W.tail<3>();
  return external_;
}

void ExternalEstimator::clear() noexcept {
  external_ = {};
  acceleration_.setZero();
}

}  // namespace c3rt::plant
