#include "controller/impedance/law.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace c3rt::impedance {

Vector6d pose_error(const Eigen::Isometry3d& X_WE, const Eigen::Vector3d& p_WE_desired,
                    const Eigen::Quaterniond& q_WE_desired) noexcept {
  const Eigen::Quaterniond q_WE(X_WE.linear());
  const Eigen::Quaterniond q_error = q_WE_desired * q_WE.conjugate();
  const double short_way = q_error.w() < 0.0 ? -1.0 : 1.0;
  Vector6d e;
  e << p_WE_desired - X_WE.translation(), short_way * q_error.vec();
  return e;
}

TaskInertia task_inertia(const ArmState& arm) noexcept {
  const Eigen::Matrix<double, 7, 6> M_inverse_JT = arm.M.llt().solve(arm.J_WE.transpose());
  const Matrix6d mobility = arm.J_WE * M_inverse_JT;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(mobility);
  const Vector6d inertia = eigen.eigenvalues().cwiseMax(kSmallestMobility).cwiseInverse();

  TaskInertia result;
  result.Lambda = eigen.eigenvectors() * inertia.asDiagonal() * eigen.eigenvectors().transpose();
  const Eigen::Matrix<double, 7, 6> J_bar = M_inverse_JT * result.Lambda;
  result.N = Matrix7d::Identity() - arm.J_WE.transpose() * J_bar.transpose();
  return result;
}

namespace {

Matrix6d weight(Inertia inertia, const Matrix6d& Lambda) noexcept {
  if (inertia == Inertia::kDiagonal) return Lambda.diagonal().asDiagonal();
  return inertia == Inertia::kUncoupled ? uncoupled(Lambda) : Lambda;
}

}  // namespace

Matrix6d uncoupled(const Matrix6d& Lambda) noexcept {
  Eigen::Matrix3d Lambda_v =
      Lambda.topLeftCorner<3, 3>() -
      Lambda.topRightCorner<3, 3>() * Lambda.bottomRightCorner<3, 3>().llt().solve(
                                          Eigen::Matrix3d(Lambda.bottomLeftCorner<3, 3>()));
  Lambda_v.diagonal().setZero();
  Matrix6d result = Lambda;
  result.topLeftCorner<3, 3>() -= 0.5 * (Lambda_v + Lambda_v.transpose());
  return result;
}

Vector7d feed_forward_torque(const Matrix67d& J_WE, const Eigen::Vector3d& force_E) noexcept {
  return -J_WE.topRows<3>().transpose() * force_E;
}

Torque torque(const Gains& gains, const ArmState& arm, const Vector7d& q, const Vector7d& dq,
              const Goal& goal) noexcept {
  const TaskInertia task = task_inertia(arm);
  const Matrix6d Lambda = weight(gains.inertia, task.Lambda);
  Vector6d asked = gains.stiffness.cwiseProduct(pose_error(arm.X_WE, goal.p_WE, goal.q_WE));
  asked.head<3>() += gains.damping.head<3>().cwiseProduct(goal.v_WE);
  const Vector6d damped = -gains.damping.cwiseProduct(arm.V_WE);
  const Vector7d posture =
      gains.null_space_stiffness * (gains.null_space_q - q) - gains.null_space_damping * dq;
  Torque torque;
  torque.of_goal =
      arm.J_WE.transpose() * (Lambda * asked) + feed_forward_torque(arm.J_WE, goal.force_E);
  torque.of_arm = arm.J_WE.transpose() * (Lambda * damped) + arm.coriolis + task.N * posture;
  return torque;
}

}  // namespace c3rt::impedance
