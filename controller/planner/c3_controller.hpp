#pragma once
// Algorithm 3, steps 2 to 5, of any planning model: from x̂ and what is wanted of it to (x_d, λ_d).
#include <limits>
#include <memory>
#include <vector>

#include "controller/c3/known_plan.hpp"
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

class C3Controller {
 public:
  /// @throws std::invalid_argument if sizes or settings cannot be used (named)
  explicit C3Controller(const Parameters& parameters);
  /// The same with another model than the one that the parameters name.
  C3Controller(const Parameters& parameters, std::unique_ptr<model::PlanningModel> model);

  int n_x() const noexcept { return model_->layout().n_x; }
  int n_u() const noexcept { return model_->layout().n_u; }
  int n_lambda() const noexcept { return problem_.lambda().size(); }  // of the planning system
  int n_lambda_d() const noexcept { return lemke_.size(); }           // of the step over Δt_c
  const model::PlanningModel& model() const noexcept { return *model_; }
  const PlanningProblem& problem() const noexcept { return problem_; }

  /// Costs that steps may use. @return by which they are named
  /// @throws std::invalid_argument if they cannot be used (named)
  int add_costs(const c3::Costs& costs);
  /// Others in their place, say as a goal comes near.
  /// @throws std::invalid_argument if they cannot be used (named); then the old ones stay
  void replace_costs(int name, const c3::Costs& costs);

  /// What is wanted at a stage 0 … N of the horizon of a plan from x̂.
  void want(int stage, const scene::Scene& desired, const scene::Scene& x_hat) {
    model_->state_about(desired, x_hat, x_desired_.col(stage));
  }

  /// C3+ alone: the gaps of contacts that are farther apart than this begin as they are, else at 0,
  /// which draws bodies to every contact of the model [m]. Those of two bodies always do: nothing
  /// comes of drawing one to the other.
  void start_from_free_gaps(double beyond) { free_beyond_ = beyond; }

  /// Steps 2 and 3: the plan from x̂, of which result() has the solution. A strategy that compares
  /// several places of the end effector asks for one plan each.
  StepStatus plan(const scene::Scene& x_hat, int costs, const c3::Deadline& deadline);
  /// Steps 2 to 5. Polish begins with what it made of the last step's plan, too.
  StepStatus step(const scene::Scene& x_hat, int costs, double delta_t_c,
                  const c3::Deadline& deadline);

  /// The next step follows no other.
  void forget_plan() noexcept { known_.forget(); }

  const StepResult& result() const noexcept { return result_; }
  // of the last plan
  const lcs::Lcs& planning_system() const noexcept { return planning_; }  // forces scaled
  const Eigen::VectorXd& x_hat() const noexcept { return x_hat_; }
  const Eigen::MatrixXd& x_desired() const noexcept { return x_desired_; }  // (n_x × N + 1)

 private:
  void use(int costs);
  bool begins_free(int contact, double phi) const;
  StepStatus plan(const scene::Scene& x_hat, int costs, const c3::Deadline& deadline, bool goes_on);
  const c3::Start* start(const Eigen::VectorXd& phi, bool goes_on);

  double dt_;
  bool scale_forces_;
  double force_unit_;  // of the model's forces [N]
  double force_scale_ratio_;
  std::unique_ptr<model::PlanningModel> model_;
  PlanningProblem problem_;
  std::vector<int> all_contacts_;
  std::vector<c3::Costs> costs_;
  int in_use_ = -1;  // of them; negative: none yet
  c3::Solver solver_;
  lcs::Lemke lemke_;
  model::ContactSystem system_;
  model::LcsStorage storage_;
  lcs::Lcs planning_;
  Eigen::MatrixXd x_desired_;
  Eigen::VectorXd x_hat_, x_next_;
  double free_beyond_ = std::numeric_limits<double>::infinity();
  c3::KnownPlan known_;  // the last step's
  c3::Start start_;
  StepResult result_;
};

}  // namespace c3rt::planner
