#pragma once
// The planner as one function of its inputs: estimate → LCS → Algorithm 1 → Algorithm 3 → (x_d,
// λ_d). Here is what surrounds Algorithm 3: what to do, and what is wanted.
#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "controller/planner/approach.hpp"
#include "controller/planner/ball_disturbance.hpp"
#include "controller/planner/c3_step.hpp"
#include "controller/planner/heuristic.hpp"
#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// What the planner does; a ball that is lost or a state that is missing leads to kHold or kWait,
/// and back.
enum class Mode { kWait, kApproach, kRoll, kReturn, kHold };

/// The mode logic alone, as a table: what comes next, given what is known.
struct Situation {
  bool state_fresh;         // the robot's state is known
  bool balls_at_hand;       // of each a valid estimate younger than the timeout, within reach
  bool hold_requested;      // a client asks to hold
  bool start_pose_reached;  // the approach has settled above a ball
  bool returning;           // Phase II of the heuristic
  bool other_ball;          // a cycle has ended and the next one is another ball's
};
Mode next(Mode mode, const Situation& situation);

/// What is known of one ball.
struct BallInput {
  bool fresh;
  double age;  // since the exposure [s]
  Ball ball;   // at the exposure
};

struct Input {
  double now;  // session time [s]
  bool state_fresh;
  Eigen::Vector3d p_WE, v_WE;              // the end effector [m, m/s]
  std::array<BallInput, kMaxBalls> balls;  // the first Parameters::balls of them
  bool hold_requested;
  std::optional<CircleTask> circle;  // a client's, in place of the scenario's task
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

  /// What is believed to accelerate a ball that nobody touches; 0 if it is not learnt [m/s²].
  Eigen::Vector2d disturbance() const noexcept {
    return disturbance_ ? disturbance_->acceleration() : Eigen::Vector2d(Eigen::Vector2d::Zero());
  }

 private:
  Situation situation(const Input& input) const noexcept;
  /// Moves the scene so that the ball lies on the model's table. @return by how much it was above
  /// it [m]
  double lowered(Scene& scene, std::size_t worked) const noexcept;

  void plan_with_c3(const Input& input, const Scene& scene, c3::Deadline deadline) noexcept;
  /// Learns what accelerates the ball that C3 has touched and nobody touches now.
  void observe_ball(const Input& input, const Scene& scene, bool in_c3) noexcept;
  /// The phase of the heuristic now; where the ball has run away its clock starts anew.
  void advance_phase(double now, const Scene& scene, bool in_c3) noexcept;
  /// The balls at the time of the arm's state.
  Scene estimate(const Input& input) const noexcept;
  double delta_t_c(const Input& input) const noexcept;
  /// x_d^b of a ball of the scene.
  Eigen::Vector2d target(const Input& input, double ahead, const Scene& scene,
                         int ball) const noexcept;
  double elapsed(const Input& input) const noexcept;
  void hold(const Eigen::Vector3d& p_WE) noexcept;

  Parameters parameters_;
  C3Step step_;
  Approach approach_;  // and hold
  Plan plan_;
  Counters counters_;
  Mode mode_ = Mode::kWait;
  Phase phase_ = Phase::kRoll;
  int ball_ = 0;          // that the heuristic works on
  bool touched_ = false;  // in this Phase I
  std::optional<BallDisturbance> disturbance_;
  double ball_touched_ = -1.0;  // the end effector was last near the ball; negative: not yet [s]
  double previous_now_ = -1.0, c3_since_ = -1.0;
  double task_since_ = -1.0;  // C3 took over for the first time: the clock of a task in time
  static constexpr int kPeriodsAveraged = 10;
  std::array<double, kPeriodsAveraged> periods_{};  // the newest at period_count_ - 1
  int period_count_ = 0;
};

}  // namespace c3rt::planner
