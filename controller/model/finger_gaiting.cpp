#include "controller/model/finger_gaiting.hpp"

namespace c3rt::model {

FingerGaitingParameters FingerGaitingParameters::paper() { return {1.0, 9.81}; }

lcs::Lcs finger_gaiting(const FingerGaitingParameters& parameters, double dt) {
  using L = FingerGaitingLayout;
  constexpr int kFingers = 2, kBodies = 3, kPerFinger = 3;

  // v⁺ = v + V_u u + V_lambda λ + V_d for the velocities of object, finger 1, finger 2
  Eigen::MatrixXd V_u = Eigen::MatrixXd::Zero(kBodies, L::n_u);
  Eigen::MatrixXd V_lambda = Eigen::MatrixXd::Zero(kBodies, L::n_lambda);
  Eigen::VectorXd V_d = Eigen::VectorXd::Zero(kBodies);
  V_d[0] = -parameters.gravity * dt;
  for (int finger = 0; finger < kFingers; ++finger) {
    const int up = L::up_1 + kPerFinger * finger, down = up + 1;
    V_u(1 + finger, L::acceleration_1 + finger) = dt;
    V_lambda(0, up) = dt;
    V_lambda(0, down) = -dt;
    V_lambda(1 + finger, up) = -dt;
    V_lambda(1 + finger, down) = dt;
  }

  lcs::Lcs lcs;
  lcs.A = Eigen::MatrixXd::Identity(L::n_x, L::n_x);
  lcs.B = Eigen::MatrixXd::Zero(L::n_x, L::n_u);
  lcs.D = Eigen::MatrixXd::Zero(L::n_x, L::n_lambda);
  lcs.d = Eigen::VectorXd::Zero(L::n_x);
  for (int body = 0; body < kBodies; ++body) {
    const int position = 2 * body, rate = position + 1;
    lcs.A(position, rate) = dt;
    lcs.B.row(rate) = V_u.row(body);
    lcs.D.row(rate) = V_lambda.row(body);
    lcs.d[rate] = V_d[body];
    lcs.B.row(position) = dt * V_u.row(body);
    lcs.D.row(position) = dt * V_lambda.row(body);
    lcs.d[position] = dt * V_d[body];
  }

  lcs.E = Eigen::MatrixXd::Zero(L::n_lambda, L::n_x);
  lcs.F = Eigen::MatrixXd::Zero(L::n_lambda, L::n_lambda);
  lcs.H = Eigen::MatrixXd::Zero(L::n_lambda, L::n_u);
  lcs.c = Eigen::VectorXd::Zero(L::n_lambda);
  for (int finger = 0; finger < kFingers; ++finger) {
    const int gamma = L::gamma_1 + kPerFinger * finger, up = gamma + 1, down = gamma + 2;
    // 0 ≤ γ ⊥ μ N − up − down ≥ 0
    lcs.H(gamma, L::normal_1 + finger) = parameters.friction;
    lcs.F(gamma, up) = -1.0;
    lcs.F(gamma, down) = -1.0;
    // 0 ≤ up ⊥ γ + v_slip⁺ ≥ 0, 0 ≤ down ⊥ γ − v_slip⁺ ≥ 0 with v_slip = object − finger
    lcs.E(up, L::object_rate) = 1.0;
    lcs.E(up, L::finger_1_rate + 2 * finger) = -1.0;
    lcs.F.row(up) = V_lambda.row(0) - V_lambda.row(1 + finger);
    lcs.H.row(up) = V_u.row(0) - V_u.row(1 + finger);
    lcs.c[up] = V_d[0] - V_d[1 + finger];
    lcs.E.row(down) = -lcs.E.row(up);
    lcs.F.row(down) = -lcs.F.row(up);
    lcs.H.row(down) = -lcs.H.row(up);
    lcs.c[down] = -lcs.c[up];
    lcs.F(up, gamma) = 1.0;
    lcs.F(down, gamma) = 1.0;
  }
  return lcs;
}

}  // namespace c3rt::model
