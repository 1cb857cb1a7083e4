#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/c3/problem.hpp"
#include "controller/lcs/lcs.hpp"

/// A C3 problem of the size and the conditioning of the single-ball task: a point mass pushes a
/// ball that rests on a table (n_x 19, n_lambda 12, n_u 3), Stewart–Trinkle contacts, forces
/// scaled, weights of the "after fix" column in its two phases. x = [p_E; q_B; p_B; v_E; ω_B; v_B],
/// λ = [γ (2); normal (2); tangential (4 each)]; contact 0 is point–ball, 1 ball–table.
namespace rolling_ball {

constexpr int kN = 5;
constexpr double kBallRadius = 0.0315, kPointRadius = 0.0195;

inline c3rt::c3::Sizes sizes() { return {19, 12, 3, kN}; }

/// The ball a little in front of and below the point, `gap` metres from touching it.
inline Eigen::VectorXd state(double gap = 0.002, double slip = 0.03) {
  const Eigen::Vector3d direction = Eigen::Vector3d(0.55, 0.25, -0.8).normalized();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(19);
  x.segment<3>(7) << 0.55, 0.1, kBallRadius;
  x.head<3>() = x.segment<3>(7) - (kBallRadius + kPointRadius + gap) * direction;
  x[3] = 1.0;
  x.segment<3>(16) << slip, -0.02, 0.0;
  x.segment<3>(13) << 0.0, slip / kBallRadius, 0.0;
  return x;
}

/// Linearised about `x` with the step dt; forces not yet scaled.
inline c3rt::lcs::Lcs unscaled_lcs(const Eigen::VectorXd& x, double dt, double mu = 1.0) {
  using Eigen::MatrixXd;
  using Eigen::Vector3d;
  using Eigen::VectorXd;
  const double point_mass = 0.01, ball_mass = 0.132, gravity = 9.81;
  const double inertia = 0.4 * ball_mass * kBallRadius * kBallRadius;
  const Vector3d p_E = x.head<3>(), p_B = x.segment<3>(7);

  VectorXd inverse_mass(9);
  inverse_mass << Vector3d::Constant(1 / point_mass), Vector3d::Constant(1 / inertia),
      Vector3d::Constant(1 / ball_mass);
  VectorXd gravity_v = VectorXd::Zero(9);
  gravity_v[2] = gravity_v[8] = -gravity;
  MatrixXd B_v = MatrixXd::Zero(9, 3);
  B_v.topRows<3>() = Eigen::Matrix3d::Identity();

  // q̇ = N v, v = N⁺ q̇
  MatrixXd N_q = MatrixXd::Zero(10, 9), N_plus = MatrixXd::Zero(9, 10);
  N_q.block<3, 3>(0, 0).setIdentity();
  N_q.block<3, 3>(7, 6).setIdentity();
  const double w = x[3], a = x[4], b = x[5], c = x[6];
  N_q.block<4, 3>(3, 3) << -a, -b, -c, w, c, -b, -c, w, a, b, -a, w;
  N_q.block<4, 3>(3, 3) *= 0.5;
  N_plus.block<3, 3>(0, 0).setIdentity();
  N_plus.block<3, 3>(6, 7).setIdentity();
  N_plus.block<3, 4>(3, 3) = 4.0 * N_q.block<4, 3>(3, 3).transpose();

  const double distance = (p_B - p_E).norm();
  const Vector3d normals[2] = {(p_B - p_E) / distance, Vector3d::UnitZ()};
  Eigen::Vector2d phi(distance - kBallRadius - kPointRadius, p_B.z() - kBallRadius);
  MatrixXd J_n = MatrixXd::Zero(2, 9), J_t = MatrixXd::Zero(8, 9);
  for (int i = 0; i < 2; ++i) {
    const Vector3d& n = normals[i];
    const Vector3d t = n.cross(Vector3d::UnitX()).normalized(), s = n.cross(t);
    const auto row_of = [&](const Vector3d& along) {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(9);
      if (i == 0) row.head<3>() = -along.transpose();
      row.segment<3>(3) = (-kBallRadius * n).cross(along).transpose();
      row.tail<3>() = along.transpose();
      return row;
    };
    J_n.row(i) = row_of(n);
    const Vector3d edges[4] = {t, -t, s, -s};
    for (int e = 0; e < 4; ++e) J_t.row(4 * i + e) = row_of(edges[e]);
  }
  MatrixXd E_t = MatrixXd::Zero(2, 8);
  E_t.row(0).head<4>().setOnes();
  E_t.row(1).tail<4>().setOnes();

  const MatrixXd M_inverse = inverse_mass.asDiagonal();
  MatrixXd J_lambda = MatrixXd::Zero(9, 12);  // M⁻¹ Jᵀ of all λ
  J_lambda.middleCols(2, 2) = M_inverse * J_n.transpose();
  J_lambda.rightCols(8) = M_inverse * J_t.transpose();

  // v⁺ = v + dt (g + M⁻¹ B u + J_lambda λ), q⁺ = q + dt N v⁺
  c3rt::lcs::Lcs lcs;
  lcs.A = MatrixXd::Identity(19, 19);
  lcs.A.topRightCorner(10, 9) = dt * N_q;
  lcs.B.resize(19, 3);
  lcs.B << dt * dt * N_q * M_inverse * B_v, dt * M_inverse * B_v;
  lcs.D.resize(19, 12);
  lcs.D << dt * dt * N_q * J_lambda, dt * J_lambda;
  lcs.d.resize(19);
  lcs.d << dt * dt * N_q * gravity_v, dt * gravity_v;

  MatrixXd gap_rows = MatrixXd::Zero(2, 19), slip_rows = MatrixXd::Zero(8, 19);
  gap_rows.leftCols(10) = J_n * N_plus;
  gap_rows.rightCols(9) = dt * J_n;
  slip_rows.rightCols(9) = J_t;
  lcs.E = MatrixXd::Zero(12, 19);
  lcs.E.middleRows(2, 2) = gap_rows;
  lcs.E.bottomRows(8) = slip_rows;
  lcs.F = MatrixXd::Zero(12, 12);
  lcs.F.block(0, 2, 2, 2) = mu * Eigen::Matrix2d::Identity();
  lcs.F.block(0, 4, 2, 8) = -E_t;
  lcs.F.block(2, 0, 2, 12) = dt * dt * J_n * J_lambda;
  lcs.F.block(4, 0, 8, 12) = dt * J_t * J_lambda;
  lcs.F.block(4, 0, 8, 2) = E_t.transpose();
  lcs.H = MatrixXd::Zero(12, 3);
  lcs.H.middleRows(2, 2) = dt * dt * J_n * M_inverse * B_v;
  lcs.H.bottomRows(8) = dt * J_t * M_inverse * B_v;
  lcs.c = VectorXd::Zero(12);
  lcs.c.segment(2, 2) = phi - J_n * N_plus * x.head(10) + dt * dt * J_n * gravity_v;
  lcs.c.tail(8) = dt * J_t * gravity_v;
  return lcs;
}

inline c3rt::lcs::Lcs lcs(const Eigen::VectorXd& x, double dt = 0.1) {
  c3rt::lcs::Lcs system = unscaled_lcs(x, dt);
  c3rt::lcs::scale_forces(system, c3rt::lcs::force_scale(system));
  return system;
}

enum class Phase { kRoll, kReturn };

inline c3rt::c3::Costs costs(Phase phase) {
  using Eigen::VectorXd;
  const bool roll = phase == Phase::kRoll;
  VectorXd Q(19), G(34), U(34);
  Q << VectorXd::Constant(3, roll ? 500.0 : 1e9), VectorXd::Zero(4),
      VectorXd::Constant(2, roll ? 5000.0 : 0.0), roll ? 1000.0 : 5.0, VectorXd::Constant(3, 10.0),
      VectorXd::Constant(6, 0.1);
  // λ: γ, normal and tangential of the point's contact weigh 1e-3, the table's nearly nothing
  G.setConstant(0.001);
  G[19 + 3] = 1e-7;
  G.segment(19 + 8, 4).setConstant(roll ? 1e-7 : 0.001);
  U << VectorXd::Constant(19, 100.0), VectorXd::Constant(15, 1.0);
  c3rt::c3::Costs costs;
  costs.Q = Q.asDiagonal();
  costs.Q_N = Q.asDiagonal();
  costs.R = Eigen::Matrix3d(0.01 * Eigen::Matrix3d::Identity());
  costs.G = G.asDiagonal();
  costs.U = U.asDiagonal();
  return costs;
}

/// The ball 20° further on its circle, the point above it.
inline Eigen::MatrixXd x_desired(const Eigen::VectorXd& x) {
  Eigen::VectorXd target = Eigen::VectorXd::Zero(19);
  target.head<3>() << x[7], x[8], 0.0865;
  target[3] = 1.0;
  target.segment<3>(7) << 0.55 + 0.1 * std::sin(0.35), 0.1 * std::cos(0.35), kBallRadius;
  return target.replicate(1, kN + 1);
}

}  // namespace rolling_ball
