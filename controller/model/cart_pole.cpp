#include "controller/model/cart_pole.hpp"

namespace c3rt::model {

CartPoleParameters CartPoleParameters::simulated() {
  return {0.978, 0.411, 0.6, 0.4267, 50.0, 0.35, 9.81};
}

CartPoleParameters CartPoleParameters::hardware() {
  return {0.978, 0.411, 0.6, 0.4267, 100.0, 0.39, 9.81};
}

ContactSystem cart_pole_system(const CartPoleParameters& parameters) {
  const double m_c = parameters.cart_mass, m_p = parameters.pole_mass;
  const double l_p = parameters.pole_length, l_c = parameters.center_length;
  const double g = parameters.gravity, d = parameters.wall_distance;

  ContactSystem system;
  system.q = Eigen::Vector2d::Zero();
  system.N_q = Eigen::Matrix2d::Identity();
  system.N_q_plus = Eigen::Matrix2d::Identity();
  // inverse of [m_c + m_p, −m_p l_c; −m_p l_c, m_p l_c²]
  system.M_inverse.resize(2, 2);
  system.M_inverse << 1.0 / m_c, 1.0 / (m_c * l_c), 1.0 / (m_c * l_c),
      (m_c + m_p) / (m_c * m_p * l_c * l_c);
  // gravity acts as m_p g l_c on the angle
  system.J_f_q = Eigen::Matrix2d::Zero();
  system.J_f_q.col(1) = system.M_inverse.col(1) * (m_p * g * l_c);
  system.J_f_v = Eigen::Matrix2d::Zero();
  system.J_f_u = system.M_inverse.col(0);
  system.d_v = Eigen::Vector2d::Zero();
  system.phi = system.distance = Eigen::Vector2d(d, d);
  system.J_n.resize(2, 2);
  system.J_n << -1.0, l_p, 1.0, -l_p;
  system.J_t.resize(0, 2);
  system.mu = Eigen::Vector2d::Zero();
  return system;
}

lcs::Lcs cart_pole(const CartPoleParameters& parameters, double dt) {
  return spring_contacts(cart_pole_system(parameters),
                         Eigen::Vector2d::Constant(parameters.wall_stiffness), dt);
}

CartPole::CartPole(const CartPoleParameters& parameters)
    : SystemModel(
          {{{"position", "m"}, {"angle", "rad"}, {"velocity", "m_per_s"}, {"rate", "rad_per_s"}},
           {{"force", "n"}},
           {{"right_wall", "n"}, {"left_wall", "n"}}}),
      parameters_(parameters) {}

lcs::Lcs CartPole::planning_system(const Eigen::VectorXd&, double dt) const {
  return cart_pole(parameters_, dt);
}

SystemKind cart_pole_kind() {
  return {"cart_pole",
          {{"cart_mass_kg", 1e-3, 1e3},
           {"pole_mass_kg", 1e-3, 1e3},
           {"pole_length_m", 1e-2, 1e2},
           {"center_length_m", 1e-2, 1e2},
           {"wall_stiffness_n_per_m", 1e-3, 1e9},
           {"wall_distance_m", 0, 1e2},
           {"gravity_m_per_s2", 0, 100}},
          [](const ModelValues& of) -> std::shared_ptr<const SystemModel> {
            return std::make_shared<CartPole>(CartPoleParameters{
                of["cart_mass_kg"], of["pole_mass_kg"], of["pole_length_m"], of["center_length_m"],
                of["wall_stiffness_n_per_m"], of["wall_distance_m"], of["gravity_m_per_s2"]});
          }};
}

}  // namespace c3rt::model
