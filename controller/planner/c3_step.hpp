#pragma once
// Algorithm 3, steps 2 to 5: from x̂ and what is wanted of it to (x_d, λ_d).
#include <memory>
#include <vector>

#include "controller/c3/solver.hpp"
#include "controller/lcs/lemke.hpp"
#include "controller/planner/planning_model.hpp"

namespace c3rt::planner {

enum class StepStatus {
  kOk,
  kTruncated,  // the deadline struck, or a bound of the projection
  kFailed,     // Algorithm 1 has no answer
  kNoStep,     // the step over Δt_c has none
};

/// What a step leaves; of kFailed and kNoStep nothing but the status counts.
struct StepResult {
  Eigen::Vector3d p_WE, v_WE;    // x_d of the end effector
  Eigen::Vector3d force_E;       // λ_d as the contacts' force on the end effector, in W [N]
  Eigen::Vector3d u_c3;          // [N]
  Eigen::VectorXd lambda_d;      // of the step over Δt_c (n_lambda_d) [N]
  double force_scale;            // what the solution's λ are to be multiplied with for [N]
  const c3::Solution* solution;  // of Algorithm 1; valid until the next step
};

/// The scenario's M_s: of one ball or of several.
std::unique_ptr<PlanningModel> make_model(const Parameters& parameters);

/// What Algorithm 1 weighs in one phase. @param has_gamma Stewart and Trinkle's λ, else Anitescu's
/// @param ball that is worked on: it and the first one change their weights
c3::Costs costs_of(const PlanningModel& model, PhaseWeights weights, bool has_gamma, int ball = 0);

class C3Step {
 public:
  /// @throws std::invalid_argument if weights or sizes cannot be used (named)
  explicit C3Step(const Parameters& parameters);

  int n_x() const noexcept { return model_->n_x(); }
  int n_lambda() const noexcept { return n_lambda_; }        // of the planning system
  int n_lambda_d() const noexcept { return lemke_.size(); }  // of the step over Δt_c

  /// What is wanted at a stage 0 … N of the horizon.
  void want(int stage, const Scene& desired) noexcept {
    model_->state(desired, x_desired_.col(stage));
  }

  /// @param rolling Phase I of the heuristic, else Phase II: whose weights hold
  /// @param ball that the heuristic works on: the first of the weights per ball is its
  StepStatus step(const Scene& x_hat, bool rolling, int ball, double delta_t_c,
                  const c3::Deadline& deadline) noexcept;

  const StepResult& result() const noexcept { return result_; }

 private:
  void use(const c3::Costs& costs);

  bool stewart_trinkle_;
  double dt_;
  std::unique_ptr<PlanningModel> model_;
  int n_lambda_;
  std::vector<c3::Costs> roll_, back_;  // by the ball that is worked on
  const c3::Costs* in_use_ = nullptr;
  c3::Solver solver_;
  lcs::Lemke lemke_;
  Eigen::MatrixXd x_desired_;
  Eigen::VectorXd x_hat_, x_next_;
  StepResult result_;
};

}  // namespace c3rt::planner
