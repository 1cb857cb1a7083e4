#include "controller/planner/c3_step.hpp"

#include "controller/lcs/lcs.hpp"
#include "controller/lcs/step.hpp"
#include "controller/model/registry.hpp"

namespace c3rt::planner {
namespace {

int n_lambda_of(const model::Layout& layout, model::ContactModel contact_model, int n_c) {
  return model::LambdaLayout(contact_model, n_c, layout.n_e).size();
}

}  // namespace

std::unique_ptr<model::PlanningModel> make_model(const ModelParameters& parameters) {
  return model::model_kind(parameters.kind).make(parameters.values, parameters.bodies);
}

PlanningProblem planning_problem(const model::PlanningModel& model,
                                 const ModelParameters& parameters) {
  PlanningProblem problem{&model.layout(), {}, parameters.contact_model};
  for (int i = 0; i < model.layout().n_c(); ++i) {
    if (parameters.pairs.count(model.layout().contacts[static_cast<std::size_t>(i)].pair) > 0)
      problem.contacts.push_back(i);
  }
  return problem;
}

C3Step::C3Step(const Parameters& parameters)
    : dt_(parameters.dt),
      force_unit_(parameters.model.force_unit),
      size_ratio_(parameters.model.size_ratio),
      model_(make_model(parameters.model)),
      problem_(planning_problem(*model_, parameters.model)),
      all_contacts_(model::all_contacts(model_->layout())),
      solver_({n_x(), n_lambda(), n_u(), parameters.N}, parameters.c3),
      lemke_(n_lambda_of(model_->layout(), model::ContactModel::kStewartTrinkle,
                         model_->layout().n_c())),
      x_desired_(Eigen::MatrixXd::Zero(n_x(), parameters.N + 1)),
      x_hat_(n_x()),
      x_next_(n_x()) {
  result_.lambda_d = Eigen::VectorXd::Zero(lemke_.size());
  result_.input_scale = force_unit_;
  for (int active = 0; active < parameters.model.bodies; ++active) {
    roll_.push_back(costs_of(problem_, parameters.roll, active));
    back_.push_back(costs_of(problem_, parameters.back, active));
  }
  // refuses unusable weights at the start, not in the loop
  use(back_[0]);
  use(roll_[0]);
}

void C3Step::use(const c3::Costs& costs) {
  if (&costs != in_use_) solver_.set_costs(costs);
  in_use_ = &costs;
}

StepStatus C3Step::step(const scene::Scene& x_hat, bool rolling, int active, double delta_t_c,
                        const c3::Deadline& deadline) noexcept {
  // step 2: the LCS about x̂
  model_->state(x_hat, x_hat_);
  lcs::Lcs planning =
      model::to_lcs(problem_.contact_model, model_->contact_system(x_hat, problem_.contacts), dt_);
  result_.solution = nullptr;
  const std::optional<double> of_model = lcs::find_force_scale(planning);
  if (!of_model) return StepStatus::kFailed;
  const double scale = *of_model / (size_ratio_ * size_ratio_);
  lcs::scale_forces(planning, scale);
  result_.force_scale = force_unit_ * model::newtons(problem_.contact_model, scale, dt_);

  // step 3: Algorithm 1
  use((rolling ? roll_ : back_)[static_cast<std::size_t>(active)]);
  const c3::Solution& solution = solver_.solve(planning, x_hat_, x_desired_, deadline);
  result_.solution = &solution;
  if (solution.status == c3::SolveStatus::kFailed) return StepStatus::kFailed;

  // step 5: (x_d, λ_d) = L_Δt_c(x̂, u_C3)
  result_.u_c3 = solution.u_0();
  const model::ContactSystem all = model_->contact_system(x_hat, all_contacts_);
  const lcs::Lcs stepping = model::stewart_trinkle(all, delta_t_c);
  if (!lcs::step(stepping, x_hat_, result_.u_c3, lemke_, x_next_, result_.lambda_d).ok())
    return StepStatus::kNoStep;
  result_.lambda_d *= force_unit_;
  result_.u_c3 *= force_unit_;
  const model::Layout& layout = model_->layout();
  result_.p_WE = x_next_.segment<3>(layout.p_WE);
  result_.v_WE = x_next_.segment<3>(layout.v_WE);
  result_.force_E = model::force_on_end_effector(layout, all, result_.lambda_d);
  return solution.status == c3::SolveStatus::kTruncated ? StepStatus::kTruncated : StepStatus::kOk;
}

}  // namespace c3rt::planner
