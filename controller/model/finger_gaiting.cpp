#include "controller/model/finger_gaiting.hpp"

#include <algorithm>

namespace c3rt::model {
namespace {

/// Added to the γ rows, which without normal force would ask 0 ≥ friction.
constexpr double kRegularisation = 1e-4;

}  // namespace

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

FingerGaiting::FingerGaiting(const FingerGaitingParameters& parameters)
    : SystemModel({{{"object", "m"},
                    {"object_rate", "m_per_s"},
                    {"finger_1", "m"},
                    {"finger_1_rate", "m_per_s"},
                    {"finger_2", "m"},
                    {"finger_2_rate", "m_per_s"}},
                   {{"acceleration_1", "m_per_s2"},
                    {"acceleration_2", "m_per_s2"},
                    {"normal_1", "n"},
                    {"normal_2", "n"}},
                   {{"gamma_1", "m_per_s"},
                    {"up_1", "n"},
                    {"down_1", "n"},
                    {"gamma_2", "m_per_s"},
                    {"up_2", "n"},
                    {"down_2", "n"}}}),
      parameters_(parameters) {}

lcs::Lcs FingerGaiting::planning_system(const Eigen::VectorXd&, double dt) const {
  return finger_gaiting(parameters_, dt);
}

lcs::Lcs FingerGaiting::simulation_system(const Eigen::VectorXd& x, double dt) const {
  lcs::Lcs lcs = planning_system(x, dt);
  lcs.c[FingerGaitingLayout::gamma_1] += kRegularisation;
  lcs.c[FingerGaitingLayout::gamma_2] += kRegularisation;
  return lcs;
}

void FingerGaiting::clip(Eigen::Ref<Eigen::VectorXd> u) const {
  for (const int normal : {FingerGaitingLayout::normal_1, FingerGaitingLayout::normal_2})
    u[normal] = std::max(u[normal], 0.0);
}

SystemKind finger_gaiting_kind() {
  return {"finger_gaiting",
          {{"friction", 0, 100}, {"gravity_m_per_s2", 0, 100}},
          [](const ModelValues& of) -> std::shared_ptr<const SystemModel> {
            return std::make_shared<FingerGaiting>(
                FingerGaitingParameters{of["friction"], of["gravity_m_per_s2"]});
          }};
}

}  // namespace c3rt::model
