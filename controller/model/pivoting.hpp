#pragma once
// Two fingers that pivot a square box about its corner on the ground [C3, section VI-B].
#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"
#include "controller/model/registry.hpp"

namespace c3rt::model {

/// The matrices published with the paper carry two sign errors.
enum class PivotingEquations {
  /// Ground friction accelerates what slides (t3⁺ pushes to +x but is paired with γ3 − v_t), and
  /// t2⁺ enters the box's vertical speed with Δt² sin α in place of Δt sin α.
  kAsPublished,
  /// Both put right. Both keep the published approximations: the ground's tangential speed has the
  /// lever that is exact at α = π/4, and the gap follows α only through its rate.
  kCorrected,
};

/// Mass and inertia of the box and masses of the fingers are 1, in SI units.
struct PivotingParameters {
  double friction_1;  // μ1 of finger 1
  double friction_2;  // μ2 of finger 2
  double friction_3;  // μ3 of the ground
  double half_size;   // h = w of the paper: half of the box's side [m]
  double gravity;     // [m/s²]
  PivotingEquations equations;

  /// The numbers of the paper: all μ = 0.1, a 2 m × 2 m box; equations corrected.
  static PivotingParameters paper();
};

/// x = [x and y of the box's centre, its clockwise angle α, positions of the fingers along their
/// faces; each followed by its rate], u = [accelerations of the fingers [m/s²]; their normal
/// forces [N]], λ = [γ, friction to either side of finger 1; of finger 2; of the ground; normal
/// force of the ground].
struct PivotingLayout {
  static constexpr int n_x = 10, n_lambda = 10, n_u = 4;
  static constexpr int x = 0, x_rate = 1, y = 2, y_rate = 3, alpha = 4, alpha_rate = 5,
                       finger_1 = 6, finger_1_rate = 7, finger_2 = 8, finger_2_rate = 9;
  static constexpr int acceleration_1 = 0, acceleration_2 = 1, normal_1 = 2, normal_2 = 3;
  static constexpr int gamma_1 = 0, t1_plus = 1, t1_minus = 2, gamma_2 = 3, t2_plus = 4,
                       t2_minus = 5, gamma_3 = 6, t3_plus = 7, t3_minus = 8, normal_ground = 9;
};

/// The LCS about the state x (n_x), whose α and finger positions give the levers.
/// @param dt time step of the implicit scheme (6) [s]
lcs::Lcs pivoting(const PivotingParameters& parameters, const Eigen::VectorXd& x, double dt);

class Pivoting final : public SystemModel {
 public:
  explicit Pivoting(const PivotingParameters& parameters);
  lcs::Lcs planning_system(const Eigen::VectorXd& x, double dt) const override;
  lcs::Lcs simulation_system(const Eigen::VectorXd& x, double dt) const override;
  void clip(Eigen::Ref<Eigen::VectorXd> u) const override;

 private:
  PivotingParameters parameters_;
};
SystemKind pivoting_kind();

}  // namespace c3rt::model
