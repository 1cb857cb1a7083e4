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
  system.phi = Eigen::Vector2d(d, d);
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

}  // namespace c3rt::model
