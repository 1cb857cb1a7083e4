#pragma once
// The cart-pole between two soft walls, not linearised: the plant of the experiment of [C3, section
// VI-C]. No network, no clock, no files.
#include <memory>

#include <Eigen/Core>

namespace c3rt::plant {

struct CartPoleParameters {
  double cart_mass;       // [kg]
  double pole_mass;       // pole and rod [kg]
  double pole_length;     // from the hinge to the tip that meets the walls [m]
  double center_length;   // from the hinge to the pole's centre of mass [m]
  double pole_inertia;    // about the centre of mass [kg m²]; 0: a point mass
  double cart_damping;    // of the cart on its rail [N s/m]
  double wall_stiffness;  // [N/m]
  double wall_damping;    // [N s/m]; the walls never pull
  double wall_distance;   // of either wall from the origin [m]
  double gravity;         // [m/s²]
  double step;            // of the integration [s]

  /// The experiment's numbers; inertia, friction and damping are not published and zero. 1 ms.
  static CartPoleParameters hardware();
};

/// States are [cart position [m]; pole angle [rad]; cart velocity [m/s]; pole rate [rad/s]]. The
/// angle is 0 upright and positive where the pole leans to −x: the tip is at position −
/// pole_length sin(angle). The pole turns freely and nothing but the walls limits the cart.
///
/// The walls are horizontal springs that the plant applies to the tip itself. MuJoCo's own soft
/// contacts set the acceleration of the constraint, not its force: their stiffness [N/m] would
/// change with the effective mass at the tip, and k could not be met.
class CartPole {
 public:
  /// Upright at rest at the origin.
  /// @throws std::invalid_argument naming the parameter that is out of range
  explicit CartPole(const CartPoleParameters& parameters);
  ~CartPole();
  CartPole(CartPole&&) noexcept;
  CartPole& operator=(CartPole&&) noexcept;

  /// @throws std::invalid_argument if x is not finite
  void reset(const Eigen::Vector4d& x);

  /// One step of the integration under a force on the cart [N].
  /// RT: no heap, no lock, no throw.
  void step(double force) noexcept;

  Eigen::Vector4d state() const noexcept;

  /// What the right and the left wall push the tip with, in this state [N]; never negative.
  Eigen::Vector2d wall_forces() const noexcept;

 private:
  struct Simulation;
  CartPoleParameters parameters_;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace c3rt::plant
