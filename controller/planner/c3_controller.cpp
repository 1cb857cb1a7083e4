#include "controller/planner/c3_controller.hpp"

#include <algorithm>
#include <cmath>

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

C3Controller::C3Controller(const Parameters& parameters)
    : C3Controller(parameters, make_model(parameters.model)) {}

C3Controller::C3Controller(const Parameters& parameters,
                           std::unique_ptr<model::PlanningModel> model)
    : dt_(parameters.dt),
      scale_forces_(parameters.scale_forces),
      force_unit_(parameters.model.force_unit),
      force_scale_ratio_(parameters.model.force_scale_ratio),
      model_(std::move(model)),
      problem_(planning_problem(*model_, parameters.model)),
      all_contacts_(model::all_contacts(model_->layout())),
      solver_({n_x(), n_lambda(), n_u(), parameters.N}, parameters.c3),
      lemke_(n_lambda_of(model_->layout(), model::ContactModel::kStewartTrinkle,
                         model_->layout().n_c())),
      x_desired_(Eigen::MatrixXd::Zero(n_x(), parameters.N + 1)),
      x_hat_(n_x()),
      x_next_(n_x()),
      known_(1.0 / parameters.rate, parameters.dt, parameters.N) {
  result_.lambda_d = Eigen::VectorXd::Zero(lemke_.size());
  result_.input_scale = force_unit_;
}

int C3Controller::add_costs(const c3::Costs& costs) {
  solver_.set_costs(costs);
  costs_.push_back(costs);
  in_use_ = static_cast<int>(costs_.size()) - 1;
  return in_use_;
}

void C3Controller::replace_costs(int name, const c3::Costs& costs) {
  in_use_ = -1;  // where the next line throws, none are
  solver_.set_costs(costs);
  costs_.at(static_cast<std::size_t>(name)) = costs;
  in_use_ = name;
}

void C3Controller::use(int costs) {
  if (costs != in_use_) solver_.set_costs(costs_.at(static_cast<std::size_t>(costs)));
  in_use_ = costs;
}

bool C3Controller::begins_free(int contact, double phi) const {
  const auto of = static_cast<std::size_t>(problem_.contacts[static_cast<std::size_t>(contact)]);
  const model::ContactPair& bodies = problem_.layout->contacts[of].bodies;
  return phi > free_beyond_ ||
         (std::isfinite(free_beyond_) && bodies.first >= 0 && bodies.second >= 0);
}

const c3::Start* C3Controller::start(const Eigen::VectorXd& phi, bool goes_on) {
  const c3::Start* known = goes_on ? known_.start() : nullptr;
  bool begins_with_gaps = false;
  if (solver_.n_copy() > n_x() + n_lambda() + n_u()) {
    for (int i = 0; i < static_cast<int>(phi.size()); ++i)
      begins_with_gaps = begins_with_gaps || begins_free(i, phi[i]);
  }
  if (!begins_with_gaps) return known;
  c3::KnownPlan::put(known, start_);
  const model::LambdaLayout lambda = problem_.lambda();
  const Eigen::Index N = x_desired_.cols() - 1;
  start_.w.setZero(solver_.n_copy(), N);
  start_.delta.setZero(solver_.n_copy(), N);
  start_.delta.topRows(n_x()).colwise() = x_hat_;
  const Eigen::VectorXd eta = planning_.E * x_hat_ + planning_.c;
  for (int i = 0; i < static_cast<int>(phi.size()); ++i) {
    if (!begins_free(i, phi[i])) continue;
    const auto free = [&](int row) {
      start_.delta.row(solver_.n_copy() - n_lambda() + row).setConstant(std::max(0.0, eta[row]));
    };
    if (lambda.has_normal()) free(lambda.normal(i));
    for (int edge = 0; edge < lambda.edge_count(); ++edge) free(lambda.edges(i) + edge);
  }
  return &start_;
}

StepStatus C3Controller::plan(const scene::Scene& x_hat, int costs, const c3::Deadline& deadline) {
  return plan(x_hat, costs, deadline, false);
}

StepStatus C3Controller::plan(const scene::Scene& x_hat, int costs, const c3::Deadline& deadline,
                              bool goes_on) {
  // step 2: the LCS about x̂
  model_->state(x_hat, x_hat_);
  model_->evaluate(x_hat, problem_.contacts, system_);
  model::to_lcs(problem_.contact_model, system_, dt_, storage_, planning_);
  result_.solution = nullptr;
  const std::optional<double> of_model = lcs::find_force_scale(planning_);
  if (!of_model) return StepStatus::kFailed;
  const double scale = scale_forces_ ? *of_model / force_scale_ratio_ : 1.0;
  if (scale_forces_) lcs::scale_forces(planning_, scale);
  result_.force_scale = force_unit_ * model::newtons(problem_.contact_model, scale, dt_);

  // step 3: Algorithm 1
  use(costs);
  const c3::Solution& solution =
      solver_.solve(planning_, x_hat_, x_desired_, deadline, start(system_.phi, goes_on));
  result_.solution = &solution;
  if (solution.status == c3::SolveStatus::kFailed) return StepStatus::kFailed;
  result_.u_c3 = force_unit_ * solution.u_0();
  return solution.status == c3::SolveStatus::kTruncated ? StepStatus::kTruncated : StepStatus::kOk;
}

StepStatus C3Controller::step(const scene::Scene& x_hat, int costs, double delta_t_c,
                              const c3::Deadline& deadline) {
  const StepStatus planned = plan(x_hat, costs, deadline, true);
  if (planned == StepStatus::kFailed) {
    known_.forget();
    return planned;
  }
  known_.keep(*result_.solution);
  // step 5: (x_d, λ_d) = L_Δt_c(x̂, u_C3)
  const model::ContactSystem all = model_->contact_system(x_hat, all_contacts_);
  const lcs::Lcs stepping = model::stewart_trinkle(all, delta_t_c);
  const Eigen::VectorXd u = result_.solution->u_0();
  if (!lcs::step(stepping, x_hat_, u, lemke_, x_next_, result_.lambda_d).ok())
    return StepStatus::kNoStep;
  result_.lambda_d *= force_unit_;
  const model::Layout& layout = model_->layout();
  result_.p_WE = x_next_.segment<3>(layout.p_WE);
  result_.v_WE = x_next_.segment<3>(layout.v_WE);
  result_.force_E = model::force_on_end_effector(layout, all, result_.lambda_d);
  return planned;
}

}  // namespace c3rt::planner
