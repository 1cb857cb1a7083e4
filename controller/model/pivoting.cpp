#include "controller/model/pivoting.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace c3rt::model {
namespace {

using L = PivotingLayout;
constexpr double kRegularisation = 1e-12;  // of F
constexpr int kVelocities = 5;             // x, y, α, finger 1, finger 2
enum Velocity { kX, kY, kAlpha, kFinger1, kFinger2 };

/// Puts `row` at `plus` and its negative at `minus`: a friction pair on the slip and its opposite.
void set_pair(Eigen::Ref<Eigen::MatrixXd> block, int plus, int minus,
              const Eigen::RowVectorXd& row) {
  block.row(plus) = row;
  block.row(minus) = -row;
}

}  // namespace

PivotingParameters PivotingParameters::paper() {
  return {0.1, 0.1, 0.1, 1.0, 9.81, PivotingEquations::kCorrected};
}

lcs::Lcs pivoting(const PivotingParameters& parameters, const Eigen::VectorXd& x, double dt) {
  assert(x.size() == L::n_x);
  const double alpha = x[L::alpha], f_1 = x[L::finger_1], f_2 = x[L::finger_2];
  const double s = std::sin(alpha), c = std::cos(alpha), h = parameters.half_size;
  const bool published = parameters.equations == PivotingEquations::kAsPublished;
  const double normal_lever = h * (s - c);  // of the ground's normal force, and dφ/dα
  const double tangential_lever = -h * (s + c);

  // v⁺ = v + dt (W_u u + W_lambda λ + W_d), a column for each force: on x, y, α, fingers
  Eigen::MatrixXd W_u = Eigen::MatrixXd::Zero(kVelocities, L::n_u);
  W_u(kFinger1, L::acceleration_1) = 1.0;
  W_u(kFinger2, L::acceleration_2) = 1.0;
  W_u.col(L::normal_1) << -c, s, -f_1, 0.0, 0.0;
  W_u.col(L::normal_2) << s, c, f_2, 0.0, 0.0;
  Eigen::MatrixXd W_lambda = Eigen::MatrixXd::Zero(kVelocities, L::n_lambda);
  W_lambda.col(L::t1_plus) << s, c, -h, -1.0, 0.0;
  W_lambda.col(L::t2_plus) << -c, s, h, 0.0, -1.0;
  W_lambda.col(L::t3_plus) << 1.0, 0.0, tangential_lever, 0.0, 0.0;
  W_lambda.col(L::normal_ground) << 0.0, 1.0, normal_lever, 0.0, 0.0;
  for (const int plus : {L::t1_plus, L::t2_plus, L::t3_plus})
    W_lambda.col(plus + 1) = -W_lambda.col(plus);
  Eigen::VectorXd W_d = Eigen::VectorXd::Zero(kVelocities);
  W_d[kY] = -parameters.gravity;

  lcs::Lcs lcs;
  lcs.A = Eigen::MatrixXd::Identity(L::n_x, L::n_x);
  lcs.B.resize(L::n_x, L::n_u);
  lcs.D.resize(L::n_x, L::n_lambda);
  lcs.d.resize(L::n_x);
  for (int velocity = 0; velocity < kVelocities; ++velocity) {
    const int position = 2 * velocity, rate = position + 1;
    lcs.A(position, rate) = dt;
    lcs.B.row(position) = dt * dt * W_u.row(velocity);
    lcs.D.row(position) = dt * dt * W_lambda.row(velocity);
    lcs.d[position] = dt * dt * W_d[velocity];
    lcs.B.row(rate) = dt * W_u.row(velocity);
    lcs.D.row(rate) = dt * W_lambda.row(velocity);
    lcs.d[rate] = dt * W_d[velocity];
  }
  if (published) lcs.D(L::y_rate, L::t2_plus) = dt * dt * s;

  lcs.E = Eigen::MatrixXd::Zero(L::n_lambda, L::n_x);
  lcs.F = Eigen::MatrixXd::Zero(L::n_lambda, L::n_lambda);
  lcs.H = Eigen::MatrixXd::Zero(L::n_lambda, L::n_u);
  lcs.c = Eigen::VectorXd::Zero(L::n_lambda);

  // 0 ≤ γ ⊥ μ n − t⁺ − t⁻ ≥ 0
  lcs.H(L::gamma_1, L::normal_1) = parameters.friction_1;
  lcs.H(L::gamma_2, L::normal_2) = parameters.friction_2;
  lcs.F(L::gamma_3, L::normal_ground) = parameters.friction_3;

  // 0 ≤ t± ⊥ γ ± v_t⁺ ≥ 0, v_t the slip against which t⁺ is directed: −ḟ of a finger on its face,
  // and of the corner on the ground ẋ − √2 h α̇
  Eigen::MatrixXd slip = Eigen::MatrixXd::Zero(3, kVelocities);
  slip(0, kFinger1) = -1.0;
  slip(1, kFinger2) = -1.0;
  slip(2, kX) = 1.0;
  slip(2, kAlpha) = -std::sqrt(2.0) * h;
  if (published) slip.row(2) *= -1.0;
  Eigen::MatrixXd rates = Eigen::MatrixXd::Zero(kVelocities, L::n_x);
  for (int velocity = 0; velocity < kVelocities; ++velocity) rates(velocity, 2 * velocity + 1) = 1;
  for (int contact = 0; contact < 3; ++contact) {
    const int gamma = 3 * contact, plus = gamma + 1, minus = gamma + 2;
    set_pair(lcs.E, plus, minus, slip.row(contact) * rates);
    set_pair(lcs.F, plus, minus, dt * slip.row(contact) * W_lambda);
    set_pair(lcs.H, plus, minus, dt * slip.row(contact) * W_u);
    set_pair(lcs.c, plus, minus, dt * slip.row(contact) * W_d);
    lcs.F(plus, gamma) = lcs.F(minus, gamma) = 1.0;
    lcs.F(gamma, plus) = lcs.F(gamma, minus) = -1.0;
  }

  // 0 ≤ n ⊥ gap of the corner at the end of the step, y⁺ − h (cos α + sin α) + lever Δt α̇⁺
  lcs.E(L::normal_ground, L::y) = 1.0;
  Eigen::RowVectorXd gap_rate = Eigen::RowVectorXd::Zero(kVelocities);
  gap_rate[kY] = 1.0;
  gap_rate[kAlpha] = normal_lever;
  lcs.E.row(L::normal_ground) += dt * gap_rate * rates;
  lcs.F.row(L::normal_ground) = dt * dt * gap_rate * W_lambda;
  lcs.H.row(L::normal_ground) = dt * dt * gap_rate * W_u;
  lcs.c[L::normal_ground] = -h * (c + s) + dt * dt * gap_rate.dot(W_d);
  return lcs;
}

Pivoting::Pivoting(const PivotingParameters& parameters)
    : SystemModel({{{"x", "m"},
                    {"x_rate", "m_per_s"},
                    {"y", "m"},
                    {"y_rate", "m_per_s"},
                    {"alpha", "rad"},
                    {"alpha_rate", "rad_per_s"},
                    {"finger_1", "m"},
                    {"finger_1_rate", "m_per_s"},
                    {"finger_2", "m"},
                    {"finger_2_rate", "m_per_s"}},
                   {{"acceleration_1", "m_per_s2"},
                    {"acceleration_2", "m_per_s2"},
                    {"normal_1", "n"},
                    {"normal_2", "n"}},
                   {{"gamma_1", "m_per_s"},
                    {"t1_plus", "n"},
                    {"t1_minus", "n"},
                    {"gamma_2", "m_per_s"},
                    {"t2_plus", "n"},
                    {"t2_minus", "n"},
                    {"gamma_3", "m_per_s"},
                    {"t3_plus", "n"},
                    {"t3_minus", "n"},
                    {"normal_ground", "n"}}}),
      parameters_(parameters) {}

lcs::Lcs Pivoting::planning_system(const Eigen::VectorXd& x, double dt) const {
  return pivoting(parameters_, x, dt);
}

lcs::Lcs Pivoting::simulation_system(const Eigen::VectorXd& x, double dt) const {
  lcs::Lcs lcs = planning_system(x, dt);
  lcs.F.diagonal().array() += kRegularisation;
  return lcs;
}

void Pivoting::clip(Eigen::Ref<Eigen::VectorXd> u) const {
  for (const int normal : {L::normal_1, L::normal_2}) u[normal] = std::max(u[normal], 0.0);
}

SystemKind pivoting_kind() {
  return {"pivoting",
          {{"friction_1", 0, 100},
           {"friction_2", 0, 100},
           {"friction_3", 0, 100},
           {"half_size_m", 1e-2, 1e2},
           {"gravity_m_per_s2", 0, 100},
           {"equations", 0, 0, {"corrected", "as_published"}}},
          [](const ModelValues& of) -> std::shared_ptr<const SystemModel> {
            return std::make_shared<Pivoting>(
                PivotingParameters{of["friction_1"], of["friction_2"], of["friction_3"],
                                   of["half_size_m"], of["gravity_m_per_s2"],
                                   of["equations"] == 0.0 ? PivotingEquations::kCorrected
                                                          : PivotingEquations::kAsPublished});
          }};
}

}  // namespace c3rt::model
