#pragma once
// Algorithm 3, steps 2 to 5: from x̂ and what is wanted of it to (x_d, λ_d).
#include <memory>
#include <vector>

#include "controller/c3/solver.hpp"
#include "controller/lcs/lemke.hpp"
#include "controller/planner/parameters.hpp"
#include "controller/planner/weights.hpp"

namespace c3rt::planner {

enum class StepStatus {
  kOk,
  kTruncated,  // the deadline struck, or a bound of the projection
  kFailed,     // Algorithm 1 has no answer
  kNoStep,     // the step over Δt_c has none
};

/// What a step leaves; of kFailed and kNoStep nothing but status and solution count.
struct StepResult {
  Eigen::Vector3d p_WE, v_WE;  // x_d of the end effector
  Eigen::Vector3d force_E;     // λ_d as the contacts' force on the end effector, in W [N]
  Eigen::Vector3d u_c3;        // [N]
  Eigen::VectorXd lambda_d;    // of the step over Δt_c (n_lambda_d) [N]
  double force_scale;          // what the solution's λ are to be multiplied with for [N]
  double input_scale;          // and its u
  // of Algorithm 1, valid until the next step; none where forces of no contact could be scaled
  const c3::Solution* solution;
};

/// The scenario's M_s.
std::unique_ptr<model::PlanningModel> make_model(const ModelParameters& parameters);

/// What the scenario plans with. @param model must outlive it
PlanningProblem planning_problem(const model::PlanningModel& model,
                                 const ModelParameters& parameters);

class C3Step {
 public:
  /// @throws std::invalid_argument or std::out_of_range if weights or sizes cannot be used (named)
  explicit C3Step(const Parameters& parameters);

  int n_x() const noexcept { return model_->layout().n_x; }
  int n_u() const noexcept { return model_->layout().n_u; }
  int n_lambda() const noexcept { return problem_.lambda().size(); }  // of the planning system
  int n_lambda_d() const noexcept { return lemke_.size(); }           // of the step over Δt_c

  /// What is wanted at a stage 0 … N of the horizon.
  void want(int stage, const scene::Scene& desired) noexcept {
    model_->state(desired, x_desired_.col(stage));
  }

  /// @param rolling Phase I of the heuristic, else Phase II: whose weights hold
  /// @param active the body that is worked on: the first of the weights per body is its
  StepStatus step(const scene::Scene& x_hat, bool rolling, int active, double delta_t_c,
                  const c3::Deadline& deadline) noexcept;

  const StepResult& result() const noexcept { return result_; }

 private:
  void use(const c3::Costs& costs);

  double dt_;
  double force_unit_;  // of the model's forces [N]
  double size_ratio_;
  std::unique_ptr<model::PlanningModel> model_;
  PlanningProblem problem_;
  std::vector<int> all_contacts_;
  std::vector<c3::Costs> roll_, back_;  // by the body that is worked on
  const c3::Costs* in_use_ = nullptr;
  c3::Solver solver_;
  lcs::Lemke lemke_;
  Eigen::MatrixXd x_desired_;
  Eigen::VectorXd x_hat_, x_next_;
  StepResult result_;
};

}  // namespace c3rt::planner
