#pragma once
// Two fingers that hold an object by friction and lift it hand over hand [C3, section VI-A].
#include "controller/lcs/lcs.hpp"
#include "controller/model/registry.hpp"

namespace c3rt::model {

/// All masses are 1 kg.
struct FingerGaitingParameters {
  double friction;  // μ of both fingers
  double gravity;   // [m/s²]; acts on the object

  /// The numbers of the paper.
  static FingerGaitingParameters paper();
};

/// x = [height and rate of the object; of finger 1; of finger 2], u = [accelerations of the
/// fingers [m/s²]; their normal forces [N]], λ = for each finger [γ; upward; downward friction on
/// the object [N]].
struct FingerGaitingLayout {
  static constexpr int n_x = 6, n_lambda = 6, n_u = 4;
  static constexpr int object = 0, object_rate = 1, finger_1 = 2, finger_1_rate = 3, finger_2 = 4,
                       finger_2_rate = 5;
  static constexpr int acceleration_1 = 0, acceleration_2 = 1, normal_1 = 2, normal_2 = 3;
  static constexpr int gamma_1 = 0, up_1 = 1, down_1 = 2, gamma_2 = 3, up_2 = 4, down_2 = 5;
};

/// @param dt time step of the implicit scheme (6) [s]
lcs::Lcs finger_gaiting(const FingerGaitingParameters& parameters, double dt);

class FingerGaiting final : public SystemModel {
 public:
  explicit FingerGaiting(const FingerGaitingParameters& parameters);
  lcs::Lcs planning_system(const Eigen::VectorXd& x, double dt) const override;
  lcs::Lcs simulation_system(const Eigen::VectorXd& x, double dt) const override;
  void clip(Eigen::Ref<Eigen::VectorXd> u) const override;

 private:
  FingerGaitingParameters parameters_;
};
SystemKind finger_gaiting_kind();

}  // namespace c3rt::model
