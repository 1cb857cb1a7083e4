#pragma once
// What a place of the end effector is worth.
#include "controller/lcs/lemke.hpp"
#include "controller/planner/c3_controller.hpp"

namespace c3rt::planner {

/// The cost of the objects over the horizon. Costs of another scene or goal do not compare.
struct Worth {
  // else the plan or its simulation has no answer, or a body is pushed to where the robot would
  // hold, as it is out of reach, or from where the end effector could not bring it back
  bool known = false;
  double cost = 0.0;   // where the end effector tries the plan
  double still = 0.0;  // and where it touches nothing
  double gain() const noexcept { return known ? still - cost : 0.0; }
};

/// A room of its own to plan in and to try the plan, so that several work at once.
///
/// A plan of Algorithm 1 moves objects with forces that are not complementary, and where it does so
/// most it seems best. So the end effector's part of the plan is tried: the same LCS is simulated
/// with the end effector under a servo that follows the plan, and the objects' terms of the costs
/// are counted.
class Candidate {
 public:
  /// @throws std::invalid_argument as C3Controller; also where u is not the force on the end
  /// effector
  Candidate(const Parameters& parameters, const ServoGains& servo);

  /// @param costs by the bodies that the model has of `from`
  /// @param from the scene with the end effector at the place
  /// @param desired at stages 0 … N
  Worth worth(const c3::Costs& costs, const scene::Scene& from,
              const std::vector<scene::Scene>& desired);

  C3Controller& c3() noexcept { return c3_; }

 private:
  void set_costs(const c3::Costs& costs);
  // a body of the last trial: to where the robot would hold, or farther out than it has to
  bool leaves_reach(const scene::Scene& from, const scene::Scene& wanted) const;

  C3Controller c3_;
  SamplingParameters sampling_;
  Eigen::AlignedBox2d reach_;  // of bodies, in W [m]
  int costs_ = -1;
  Eigen::VectorXd Q_;  // diagonal, of the objects alone
  Eigen::MatrixXd K_, G_, planned_, w_, x_, lambda_;
  Eigen::VectorXd x_alone_;
  scene::Scene alone_;
  lcs::Lcs closed_;
  lcs::Lemke lemke_;
  int N_;
  double dt_;
};

}  // namespace c3rt::planner
