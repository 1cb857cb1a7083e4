#pragma once
// The planner as one function of its inputs: estimate → LCS → Algorithm 1 → Algorithm 3 → (x_d,
// λ_d). Here is what surrounds Algorithm 3: what to do, and what is wanted.
#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "controller/planner/activity.hpp"
#include "controller/planner/approach.hpp"
#include "controller/planner/ball_disturbance.hpp"
#include "controller/planner/c3_step.hpp"
#include "controller/planner/heuristic.hpp"
#include "controller/planner/parameters.hpp"
#include "controller/planner/rest.hpp"
#include "controller/planner/target.hpp"

namespace c3rt::planner {

/// The mode logic alone, as a table: what comes next, given what is known.
struct Situation {
  bool state_fresh;         // the robot's state is known
  bool robot_left;          // it has not followed for a while: what was going on is over
  bool balls_at_hand;       // of each a valid estimate younger than the timeout, within reach
  bool hold_requested;      // a client asks to hold, and no ball has to be brought to rest for it
  bool rest_wanted;         // the end effector is on a ball that is to lie still
  bool ball_left;           // it has risen from a ball that lies still
  bool start_pose_reached;  // the approach has settled above a ball
  bool returning;           // Phase II of the heuristic
  bool other_ball;          // a cycle has ended and the next one is another ball's
};
Mode next(Mode mode, const Situation& situation);

/// What is known of one body.
struct BodyInput {
  bool seen = false;  // by vision, at the exposure; else it is where it was last seen
  double age = std::numeric_limits<double>::infinity();  // since the exposure; before the first [s]
  scene::Body body;                                      // at the exposure
};

struct Input {
  double now;        // session time [s]
  double state_age;  // of what follows; infinite before the first [s]
  scene::Effector effector;
  std::array<BodyInput, scene::kMaxBodies> bodies;  // the first ModelParameters::bodies of them
  bool robot_follows = true;                        // it moves, and its controller tracks the plans
  bool stopped;                                     // a person has stopped the robot
  Target target;                                    // a client's
  double solve_time;  // duration of the previous solve [s], for DeltaTcSource::kSolveTime
};

enum class PlanStatus { kOk, kTruncated, kFallback };

struct Plan {
  PlanStatus status;
  Mode mode;
  Eigen::Vector3d p_WE, v_WE;  // x_d of the end effector
  Eigen::Quaterniond q_WE;
  // λ_d as the contacts' force on the end effector, and the press of Phase I, in W [N]
  Eigen::Vector3d force_E;
  int ball;                     // that the heuristic works on
  Eigen::Vector3d ball_target;  // its x_d^b
  double delta_t_c;             // [s]
  Eigen::Vector3d u_c3;         // [N]
  Eigen::VectorXd lambda_d;     // of the step over Δt_c, with every contact [N]
  Eigen::MatrixXd x;            // (n_x × N) predicted
  Eigen::MatrixXd lambda;       // of the planning system (n_lambda × N) [N]
  Eigen::MatrixXd u;            // (n_u × N) [N]
  int admm_iterations;
  Eigen::VectorXd primal_residual;  // (admm_iterations)
  double complementarity_violation;
};

class Planner {
 public:
  /// @throws std::invalid_argument if weights or sizes cannot be used (named)
  explicit Planner(const Parameters& parameters);
  /// One control period. Never throws; a failed solve gives a fallback plan that holds the end
  /// effector where it is.
  /// @param deadline asked between steps of the solve; lockstep passes none
  const Plan& step(const Input& input, c3::Deadline deadline = {}) noexcept;

  struct Counters {
    std::uint64_t fallbacks = 0, truncated = 0, lcp_failures = 0, speed_clamped = 0, ball_lost = 0;
    std::uint64_t branch_nodes = 0;
  };
  const Counters& counters() const noexcept { return counters_; }

  /// What it is doing and why.
  const Activity& activity() const noexcept { return activity_; }

  /// What is believed to accelerate a ball that nobody touches; 0 if it is not learnt [m/s²].
  Eigen::Vector2d disturbance() const noexcept {
    return disturbance_ ? disturbance_->acceleration() : Eigen::Vector2d(Eigen::Vector2d::Zero());
  }

 private:
  Situation situation(const Input& input) const noexcept;
  /// Why a ball cannot be worked on; kNone if it can.
  Cause hindrance(const BodyInput& ball) const noexcept;
  /// The same of the first ball that cannot, and of the robot's state.
  Cause hindrance(const Input& input, int& ball) const noexcept;
  bool in_view(const BodyInput& ball) const noexcept;
  RestInput rest_input(const Input& input, const scene::Scene& scene, double period) const noexcept;
  /// What a client's target and the balls make of the situation: when a ball has to lie still.
  void decide_rest(const Input& input, const scene::Scene& scene, Situation& known) noexcept;
  /// Keeps activity() true.
  void tell(const Input& input, const scene::Scene& scene) noexcept;
  /// Moves the scene so that the ball lies on the model's table. @return by how much it was above
  /// it [m]
  double lowered(scene::Scene& scene, std::size_t worked) const noexcept;

  void plan_with_c3(const Input& input, const scene::Scene& scene, c3::Deadline deadline) noexcept;
  /// Learns what accelerates the ball that C3 has touched and nobody touches now.
  void observe_ball(const Input& input, const scene::Scene& scene, bool in_c3) noexcept;
  /// The phase of the heuristic now; where the ball has run away its clock starts anew.
  void advance_phase(double now, const scene::Scene& scene, bool in_c3) noexcept;
  /// The balls at the time of the arm's state.
  scene::Scene estimate(const Input& input) const noexcept;
  double delta_t_c(const Input& input) const noexcept;
  /// x_d^b of a ball of the scene.
  Eigen::Vector2d target(const Input& input, double ahead, const scene::Scene& scene,
                         int ball) const noexcept;
  double elapsed(const Input& input) const noexcept;
  void hold(const Eigen::Vector3d& p_WE) noexcept;

  Parameters parameters_;
  C3Step step_;
  Approach approach_;  // and hold
  Rest rest_;
  bool on_ball_ = false;          // the end effector touches it from above, when last seen
  double stopping_since_ = -1.0;  // a rolling ball has to be brought to rest; negative: none [s]
  bool not_brought_to_rest_ = false;          // within the time allowed
  std::optional<Eigen::Vector2d> delivered_;  // to this point of a client, in W [m]
  double astray_since_ = -1.0;                // it has moved away from there; negative: not [s]
  Activity activity_;
  Plan plan_;
  Counters counters_;
  Mode mode_ = Mode::kWait;
  Phase phase_ = Phase::kRoll;
  int ball_ = 0;          // that the heuristic works on
  bool touched_ = false;  // in this Phase I
  std::optional<BallDisturbance> disturbance_;
  double ball_touched_ = -1.0;  // the end effector was last near the ball; negative: not yet [s]
  double previous_now_ = -1.0, c3_since_ = -1.0;
  double followed_ = -1.0;    // the robot last followed; negative: not yet [s]
  double task_since_ = -1.0;  // C3 took over for the first time: the clock of a task in time
  static constexpr int kPeriodsAveraged = 10;
  std::array<double, kPeriodsAveraged> periods_{};  // the newest at period_count_ - 1
  int period_count_ = 0;
};

}  // namespace c3rt::planner
