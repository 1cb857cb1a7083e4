#include "plant_emulator/motion.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "plant_emulator/guard.hpp"

namespace c3rt::plant {
namespace {

// how far from the arm a motion may begin; ours, FCI does not publish its own
constexpr double kStartJoint = 0.01;      // each joint, and the elbow [rad]
constexpr double kStartPosition = 2e-3;   // of the end effector [m]
constexpr double kStartAngle = 0.01;      // [rad]
constexpr double kFrameTolerance = 1e-3;  // of the quaternion's norm; ours
constexpr double kRounding = 1.0 + 1e-6;  // of a third difference over a millisecond
// inverse kinematics: Newton's method, of which a cycle's motion takes two or three steps
constexpr int kNewtonSteps = 8;
constexpr double kNewtonEnd = 1e-11;       // [rad]
constexpr double kSingularDamping = 1e-6;  // keeps its steps finite [m]

/// The rotation about W's axes that leads from a to b, by its shorter way [rad].
Eigen::Vector3d turn(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) noexcept {
  const Eigen::AngleAxisd way(b * a.conjugate());
  return way.angle() * way.axis();
}

Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Eigen::Vector3d& by) noexcept {
  const double angle = by.norm();
  if (angle < 1e-300) return q;
  return (Eigen::AngleAxisd(angle, by / angle) * q).normalized();
}

/// Translation, and rotation, by their sizes.
void judge_twist(Error error, const Vector6d& twist, double linear_max, double angular_max,
                 const char* linear_unit, const char* angular_unit, Findings& findings) noexcept {
  const double linear = twist.head<3>().norm(), angular = twist.tail<3>().norm();
  if (linear > kRounding * linear_max) findings.add({error, 0, linear, linear_max, linear_unit});
  if (angular > kRounding * angular_max)
    findings.add({error, 0, angular, angular_max, angular_unit});
}

bool is_joints(MotionKind kind) noexcept {
  return kind == MotionKind::kJointPosition || kind == MotionKind::kJointVelocity;
}

}  // namespace

bool is_finite(const MotionCommand& command) noexcept {
  const bool elbow = !command.elbow || std::isfinite(command.elbow->q3 + command.elbow->sign);
  return elbow && command.joints.allFinite() && command.p_WE.allFinite() &&
         command.q_WE.allFinite() && command.V_WE.allFinite();
}

void MotionGenerator::begin(MotionKind kind, const Vector7d& q, Kinematics& kinematics) noexcept {
  *this = {};
  kind_ = kind;
  q_ = q;
  const Reach reach = kinematics.at(q);
  p_WE_ = reach.p_WE;
  q_WE_ = reach.q_WE;
}

void MotionGenerator::step(const MotionCommand* command, const Parameters& parameters,
                           Kinematics& kinematics, Findings& findings) noexcept {
  if (is_joints(kind_)) {
    step_joints(command, parameters, findings);
  } else {
    step_pose(command, parameters, kinematics, findings);
  }
  first_ = false;
}

void MotionGenerator::step_joints(const MotionCommand* command, const Parameters& parameters,
                                  Findings& findings) noexcept {
  constexpr JointErrors kErrors{Error::kJointMotionGeneratorPositionLimitsViolation,
                                Error::kJointMotionGeneratorVelocityLimitsViolation,
                                Error::kJointMotionGeneratorVelocityDiscontinuity,
                                Error::kJointMotionGeneratorAccelerationDiscontinuity};
  Vector7d q = q_ + kCycle * (dq_ + kCycle * ddq_);
  if (command != nullptr)
    q = kind_ == MotionKind::kJointPosition ? command->joints : q_ + kCycle * command->joints;
  if (first_ && kind_ == MotionKind::kJointPosition) {
    judge_sizes(Error::kJointPositionMotionGeneratorStartPoseInvalid, "rad", Vector7d(q - q_),
                Vector7d::Constant(kStartJoint), findings);
    if (findings.errors == 0) q_ = q;  // it begins here, at rest
    return;
  }
  move_joints(q, kErrors, parameters, findings);
}

void MotionGenerator::move_joints(const Vector7d& q, const JointErrors& errors,
                                  const Parameters& parameters, Findings& findings) noexcept {
  const MotionLimits& limits = parameters.safety.motion;
  const Vector7d dq = (q - q_) / kCycle, ddq = (dq - dq_) / kCycle, jerk = (ddq - ddq_) / kCycle;
  judge_range(errors.position, "rad", q, parameters.limits.q_min, parameters.limits.q_max,
              findings);
  judge_sizes(errors.velocity, "rad/s", dq, Vector7d(kRounding * parameters.limits.dq_max),
              findings);
  judge_sizes(errors.velocity_step, "rad/s2", ddq, Vector7d(kRounding * limits.joint_acceleration),
              findings);
  judge_sizes(errors.acceleration_step, "rad/s3", jerk, Vector7d(kRounding * limits.joint_jerk),
              findings);
  q_ = q;
  dq_ = dq;
  ddq_ = ddq;
}

void MotionGenerator::step_pose(const MotionCommand* command, const Parameters& parameters,
                                Kinematics& kinematics, Findings& findings) noexcept {
  constexpr JointErrors kErrors{Error::kCartesianMotionGeneratorJointPositionLimitsViolation,
                                Error::kCartesianMotionGeneratorJointVelocityLimitsViolation,
                                Error::kCartesianMotionGeneratorJointVelocityDiscontinuity,
                                Error::kCartesianMotionGeneratorJointAccelerationDiscontinuity};
  const bool pose = kind_ == MotionKind::kCartesianPose;
  Vector6d V = V_WE_ + kCycle * A_WE_;
  if (command != nullptr && !pose) V = command->V_WE;
  Eigen::Vector3d p_WE = p_WE_ + kCycle * V.head<3>();
  Eigen::Quaterniond q_WE = turned(q_WE_, kCycle * V.tail<3>());
  if (command != nullptr && pose) {
    const double norm = command->q_WE.norm();
    if (std::abs(norm - 1.0) > kFrameTolerance) {
      findings.add(
          {Error::kCartesianPositionMotionGeneratorInvalidFrame, 0, norm, 1.0, "of a rotation"});
      return;
    }
    p_WE = command->p_WE;
    q_WE =
        Eigen::Quaterniond(command->q_WE[0], command->q_WE[1], command->q_WE[2], command->q_WE[3])
            .normalized();
  }
  if (command != nullptr && command->elbow) judge_elbow(*command, parameters, findings);
  if (first_ && pose) {
    constexpr Error kError = Error::kCartesianPositionMotionGeneratorStartPoseInvalid;
    const double away = (p_WE - p_WE_).norm(), turn_away = turn(q_WE_, q_WE).norm();
    if (away > kStartPosition) findings.add({kError, 0, away, kStartPosition, "m"});
    if (turn_away > kStartAngle) findings.add({kError, 0, turn_away, kStartAngle, "rad"});
    if (findings.errors != 0) return;
    p_WE_ = p_WE;  // it begins here, at rest
    q_WE_ = q_WE;
    q_ = joints_of_pose(kinematics);
    return;
  }
  move_pose(p_WE, q_WE, parameters, findings);
  // what breaks a limit by itself is not asked of the joints
  if (findings.errors != 0) return;
  move_joints(joints_of_pose(kinematics), kErrors, parameters, findings);
}

void MotionGenerator::judge_elbow(const MotionCommand& command, const Parameters& parameters,
                                  Findings& findings) noexcept {
  constexpr int kJoint3 = 2, kJoint4 = 3;
  const Elbow& elbow = *command.elbow;
  const double low = parameters.limits.q_min[kJoint3], high = parameters.limits.q_max[kJoint3];
  if (elbow.q3 < low || elbow.q3 > high) {
    findings.add({Error::kCartesianMotionGeneratorElbowLimitViolation, kJoint3 + 1, elbow.q3,
                  elbow.q3 < low ? low : high, "rad"});
  }
  const double sign = q_[kJoint4] < 0.0 ? -1.0 : 1.0;
  if (elbow.sign != sign) {
    findings.add({Error::kCartesianMotionGeneratorElbowSignInconsistent, kJoint4 + 1, elbow.sign,
                  sign, "its sign"});
  }
  if (!elbow_ && std::abs(elbow.q3 - q_[kJoint3]) > kStartJoint) {
    findings.add({Error::kCartesianMotionGeneratorStartElbowInvalid, kJoint3 + 1,
                  elbow.q3 - q_[kJoint3], kStartJoint, "rad"});
  }
  elbow_ = elbow;
}

void MotionGenerator::move_pose(const Eigen::Vector3d& p_WE, const Eigen::Quaterniond& q_WE,
                                const Parameters& parameters, Findings& findings) noexcept {
  const Safety& safety = parameters.safety;
  const MotionLimits& limits = safety.motion;
  Vector6d V;
  V << (p_WE - p_WE_) / kCycle, turn(q_WE_, q_WE) / kCycle;
  const Vector6d A = (V - V_WE_) / kCycle, jerk = (A - A_WE_) / kCycle;
  judge_twist(Error::kCartesianMotionGeneratorVelocityLimitsViolation, V, safety.velocity_max,
              safety.angular_velocity_max, "m/s", "rad/s", findings);
  judge_twist(Error::kCartesianMotionGeneratorVelocityDiscontinuity, A, limits.acceleration,
              limits.angular_acceleration, "m/s2", "rad/s2", findings);
  judge_twist(Error::kCartesianMotionGeneratorAccelerationDiscontinuity, jerk, limits.jerk,
              limits.angular_jerk, "m/s3", "rad/s3", findings);
  p_WE_ = p_WE;
  q_WE_ = q_WE;
  V_WE_ = V;
  A_WE_ = A;
}

/// The pose's joints near those before: by the shortest way, or with the elbow where it is asked
/// for.
Vector7d MotionGenerator::joints_of_pose(Kinematics& kinematics) const noexcept {
  Vector7d q = q_;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Reach reach = kinematics.at(q);
    Vector6d off;
    off << p_WE_ - reach.p_WE, turn(reach.q_WE, q_WE_);
    Vector7d step;
    if (elbow_) {
      Eigen::Matrix<double, kJoints, kJoints> rows;
      rows << reach.J_WE, Eigen::Matrix<double, 1, kJoints>::Unit(2);
      Vector7d of_rows;
      of_rows << off, elbow_->q3 - q[2];
      step = rows.partialPivLu().solve(of_rows);
    } else {
      Eigen::Matrix<double, 6, 6> JJt = reach.J_WE * reach.J_WE.transpose();
      JJt.diagonal().array() += kSingularDamping * kSingularDamping;
      step = reach.J_WE.transpose() * JJt.ldlt().solve(off);
    }
    if (!step.allFinite()) return q;
    q += step;
    if (step.cwiseAbs().maxCoeff() < kNewtonEnd) break;
  }
  return q;
}

}  // namespace c3rt::plant
