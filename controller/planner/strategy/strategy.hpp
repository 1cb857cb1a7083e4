#pragma once
// What a strategy is asked in each period, and what it decides: whether C3 plans or the end
// effector moves on its own, and what is wanted of either.
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "controller/c3/parallel.hpp"
#include "controller/planner/availability.hpp"
#include "controller/planner/c3_controller.hpp"
#include "controller/planner/input.hpp"
#include "controller/planner/plan.hpp"

namespace c3rt::planner {

/// What a strategy decides from, in one period.
struct Situation {
  const Input* input;      // now, and what a client wants
  double period;           // since the last one [s]
  bool interrupted;        // there was none for a while: what was going on is over
  bool robot_left;         // the robot has not followed for a while: the same
  Availability available;  // what of the input can be used
  scene::Scene scene;      // at the time of the arm's state
  c3::Parallel parallel;   // threads for plans of several places
};

/// What it decides. Of a period in which nothing about a member is decided it stays as it was.
struct Decision {
  Mode mode = Mode::kWait;
  const char* phase = "";      // in kTask: a word for it, which lives for ever
  Cause cause = Cause::kNone;  // of the strategy's own, why it holds
  int body = 0;                // that is worked on
  bool body_lost = false;      // C3 had to leave its work, as a body was lost
  Eigen::Vector3d body_target = Eigen::Vector3d::Zero();  // where it should be, in W [m]
  // of one that compares places: those of this period, and that to which the end effector goes or
  // from which it pushes
  std::vector<WeighedPlace> weighed;
  std::optional<Eigen::Vector3d> place;  // [m]

  bool plans_with_c3 = false;
  // where C3 does not plan: the end effector's reference, and a force on top [N]
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero(), v_WE = Eigen::Vector3d::Zero();
  // and where it does, a force on top of λ_d [N]
  Eigen::Vector3d force_bias = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WE{0.0, 1.0, 0.0, 0.0};  // the tool points down

  // of C3: Algorithm 3, step 1
  scene::Scene x_hat;
  double raised = 0.0;                // x̂ is this much lower than what it stands for [m]
  std::vector<scene::Scene> desired;  // at stages 0 … N
  int costs = 0;                      // of C3Controller::add_costs
};

/// A strategy is made once, with all the room that it needs, from the scenario's parameters and the
/// controller, to which it adds its costs.
class Strategy {
 public:
  virtual ~Strategy() = default;
  /// Forgets whatever happened before.
  virtual void reset() = 0;
  /// From the next period on C3 plans with the weights of these parameters, which are else those
  /// that the strategy was made from. Of one that adds no costs nothing changes.
  /// @throws std::invalid_argument if they cannot be used (named)
  virtual void set_weights(const Parameters&, C3Controller&) {}
  /// One period. @param c3 for one that compares plans: what it wants of the last of them is lost
  /// when the planner asks for the decided one
  virtual const Decision& decide(const Situation& situation, C3Controller& c3) = 0;
};

}  // namespace c3rt::planner
