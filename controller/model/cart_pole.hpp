#pragma once
// The cart-pole between two soft walls [C3, section VI-C].
#include "controller/lcs/lcs.hpp"
#include "controller/model/contact_system.hpp"
#include "controller/model/registry.hpp"

namespace c3rt::model {

struct CartPoleParameters {
  double cart_mass;       // m_c [kg]
  double pole_mass;       // m_p, pole and rod as a point mass [kg]
  double pole_length;     // l_p, from the hinge to the tip that meets the walls [m]
  double center_length;   // l_c, from the hinge to the point mass [m]
  double wall_stiffness;  // k [N/m]
  double wall_distance;   // d of either wall from the origin [m]
  double gravity;         // [m/s²]

  /// The numerical example: k = 50 N/m, d = 0.35 m.
  static CartPoleParameters simulated();
  /// The experiment: k = 100 N/m, d = 0.39 m.
  static CartPoleParameters hardware();
};

/// x = [cart position; pole angle; their rates], u = force on the cart [N], λ = forces of the right
/// and the left wall on the tip [N]. The angle is positive where the pole leans to −x: the tip is
/// at position − l_p sin(angle).
struct CartPoleLayout {
  static constexpr int n_x = 4, n_lambda = 2, n_u = 1;
  static constexpr int position = 0, angle = 1, velocity = 2, rate = 3;
  static constexpr int right_wall = 0, left_wall = 1;
};

/// Linearised at the upright pole; contact 0 is the right wall, 1 the left one, without friction.
ContactSystem cart_pole_system(const CartPoleParameters& parameters);

/// The example's LCS: `cart_pole_system` with `spring_contacts` of the walls' stiffness.
/// @param dt step of the explicit Euler method [s]
lcs::Lcs cart_pole(const CartPoleParameters& parameters, double dt);

class CartPole final : public SystemModel {
 public:
  explicit CartPole(const CartPoleParameters& parameters);
  const CartPoleParameters& parameters() const noexcept { return parameters_; }
  lcs::Lcs planning_system(const Eigen::VectorXd& x, double dt) const override;

 private:
  CartPoleParameters parameters_;
};
SystemKind cart_pole_kind();

}  // namespace c3rt::model
