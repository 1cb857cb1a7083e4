#pragma once
// The planner as one function of its inputs: estimate → LCS → Algorithm 1 → Algorithm 3 → (x_d,
// λ_d).
#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Geometry>

#include "controller/planner/heuristic.hpp"
#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// What the planner does; a ball that is lost or a state that is missing leads to kHold or kWait,
/// and back.
enum class Mode { kWait, kApproach, kRoll, kReturn, kHold };

/// The mode logic alone, as a table: what comes next, given what is known.
struct Situation {
  bool state_fresh;         // the robot's state is known
  bool ball_at_hand;        // a valid ball estimate younger than the timeout, within reach
  bool hold_requested;      // a client asks to hold
  bool start_pose_reached;  // the approach has settled above the ball
  bool returning;           // Phase II of the heuristic
};
Mode next(Mode mode, const Situation& situation);

struct Input {
  double now;  // session time [s]
  bool state_fresh;
  Eigen::Vector3d p_WE, v_WE;  // the end effector [m, m/s]
  bool ball_fresh;
  double ball_age;  // since the exposure [s]
  Eigen::Vector3d p_WB, v_WB, omega_WB;
  Eigen::Quaterniond q_WB;
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
  Eigen::Vector3d force_E;      // λ_d as the contacts' force on the end effector, in W [N]
  Eigen::Vector3d ball_target;  // x_d^b
  double delta_t_c;             // [s]
  Eigen::Vector3d u_c3;         // [N]
  Eigen::VectorXd lambda_d;     // of the step over Δt_c (BallLayout::n_lambda) [N]
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
  ~Planner();
  /// One control period. Never throws; a failed solve gives a fallback plan that holds the end
  /// effector where it is.
  /// @param deadline asked between steps of the solve; lockstep passes none
  const Plan& step(const Input& input, c3::Deadline deadline = {}) noexcept;

  struct Counters {
    std::uint64_t fallbacks = 0, truncated = 0, lcp_failures = 0, speed_clamped = 0, ball_lost = 0;
    std::uint64_t branch_nodes = 0;
  };
  const Counters& counters() const noexcept { return counters_; }

 private:
  struct Workspace;
  void approach(const Input& input) noexcept;
  void plan_with_c3(const Input& input, c3::Deadline deadline) noexcept;
  Eigen::Vector2d target(const Input& input, double ahead,
                         const Eigen::Vector2d& ball) const noexcept;
  void hold(const Eigen::Vector3d& p_WE) noexcept;
  bool advance_reference(const Input& input, const Eigen::Vector3d& goal) noexcept;

  Parameters parameters_;
  Plan plan_;
  Counters counters_;
  Mode mode_ = Mode::kWait;
  Eigen::Vector3d reference_ = Eigen::Vector3d::Zero();  // of approach and hold
  double previous_now_ = -1.0, settled_since_ = -1.0, c3_since_ = -1.0;
  double task_since_ = -1.0;  // C3 took over for the first time: the clock of a task in time
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace c3rt::planner
