#pragma once
// The time-based heuristic of Figure 10 as a strategy: the approach, Phase I and II, and bringing a
// body to rest.
#include <memory>
#include <optional>

#include "controller/planner/strategy/approach.hpp"
#include "controller/planner/strategy/heuristic.hpp"
#include "controller/planner/strategy/rest.hpp"
#include "controller/planner/strategy/strategy.hpp"
#include "controller/planner/strategy/task_at_hand.hpp"

namespace c3rt::planner {

/// What it is at. kRoll and kReturn, Phase I and II, are where C3 plans.
enum class TimeHeuristicMode { kWait, kApproach, kRoll, kReturn, kRest, kHold };

/// The mode logic alone, as a table: what comes next, given what is known.
struct Known {
  bool state_fresh;         // the robot's state is known
  bool robot_left;          // it has not followed for a while: what was going on is over
  bool spheres_at_hand;     // of each a valid estimate younger than the timeout, within reach
  bool hold_requested;      // a client asks to hold, and no sphere has to be brought to rest for it
  bool rest_wanted;         // the end effector is on a sphere that is to lie still
  bool sphere_left;         // it has risen from a sphere that lies still
  bool start_pose_reached;  // the approach has settled above a sphere
  bool returning;           // Phase II of the heuristic
  bool other_sphere;        // a cycle has ended and the next one is another sphere's
};
TimeHeuristicMode next(TimeHeuristicMode mode, const Known& known);

/// All that the strategy remembers from period to period.
struct TimeHeuristicState {
  TimeHeuristicState(const Parameters& parameters);

  TaskAtHand task;
  Approach approach;  // and hold
  Rest rest;
  TimeHeuristicMode mode = TimeHeuristicMode::kWait;
  Phase phase = Phase::kRoll;
  int sphere = 0;                // that it works on
  bool touched = false;          // in this Phase I
  double c3_since = -1.0;        // the cycle began; negative: not yet [s]
  bool on_sphere = false;        // the end effector touches it from above, when last seen
  double stopping_since = -1.0;  // a rolling sphere has to be brought to rest; negative: none [s]
  bool not_brought_to_rest = false;          // within the time allowed
  std::optional<Eigen::Vector2d> delivered;  // to this point of the task, in W [m]
  double astray_since = -1.0;                // it has moved away from there; negative: not [s]
};

class TimeHeuristic final : public Strategy {
 public:
  /// @throws std::invalid_argument or std::out_of_range if weights cannot be used (named)
  TimeHeuristic(const Parameters& parameters, C3Controller& c3);

  void reset() override;
  void set_weights(const Parameters& parameters, C3Controller& c3) override;
  const Decision& decide(const Situation& now, C3Controller& c3) override;

 private:
  /// What a client's target and the spheres make of the situation: when a sphere has to lie still.
  void decide_rest(const Situation& now, Known& known);
  /// The phase of the heuristic now; where the sphere has run away its clock starts anew.
  void advance_phase(double now, const scene::Scene& scene, bool in_c3);
  void move_without_c3(const Situation& now);
  /// Algorithm 3, step 1, and what is wanted at each stage.
  void move_with_c3(const Situation& now);
  /// Of the centre of a sphere that lies on the table, in W [m].
  double height(const scene::Body& sphere) const;
  /// Moves the scene so that the sphere lies on the model's table. @return by how much it was above
  /// it [m]
  double lowered(scene::Scene& scene) const;
  Cause cause(const Input& input) const;
  RestInput rest_input(const Situation& now) const;
  /// x_d^b of a sphere of the scene.
  Eigen::Vector2d target(const Input& input, double ahead, const scene::Scene& scene,
                         int sphere) const;
  /// Where the sphere is to come to rest, of a task that says so, in W [m].
  std::optional<Eigen::Vector2d> resting_place(const Input& input) const;

  Parameters parameters_;
  std::vector<int> roll_, back_;  // costs by the sphere that is worked on
  TimeHeuristicState state_;
  Decision decision_;
};

std::unique_ptr<Strategy> make_time_heuristic(const Parameters& parameters, C3Controller& c3);

}  // namespace c3rt::planner
