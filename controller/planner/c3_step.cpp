#include "controller/planner/c3_step.hpp"

#include "controller/lcs/lcs.hpp"
#include "controller/lcs/step.hpp"

namespace c3rt::planner {
namespace {

constexpr int kInputs = 3;

bool is_stewart_trinkle(const Parameters& parameters) {
  return parameters.contact_model == ContactModel::kStewartTrinkle;
}

/// λ of n_c contacts: γ, normal force and edges of each, or edges alone.
int n_lambda_of(int n_c, bool stewart_trinkle) {
  return n_c * (stewart_trinkle ? 2 + kEdges : kEdges);
}

/// What the consensus term weighs λ with, in the order of the planning system.
Eigen::VectorXd G_of_lambda(const PlanningModel& model, const PhaseWeights& weights,
                            bool has_gamma) {
  const int n_c = model.n_c(Contacts::kPlanned);
  Eigen::VectorXd G(n_lambda_of(n_c, has_gamma));
  if (has_gamma) G.head(n_c).setConstant(weights.G_gamma);
  for (int i = 0; i < n_c; ++i) {
    const PlanningModel::ContactWeights of_contact = model.G(weights, i);
    if (has_gamma) G[n_c + i] = of_contact.normal;
    G.segment<kEdges>((has_gamma ? 2 * n_c : 0) + i * kEdges).setConstant(of_contact.tangential);
  }
  return G;
}

/// Weights of η, in the order of the planning system; Anitescu's rows, distance and slip in one,
/// have the first.
Eigen::VectorXd of_rows(const PhaseWeights::Gaps& gaps, int n_lambda, bool has_gamma) {
  Eigen::VectorXd rows = Eigen::VectorXd::Constant(n_lambda, gaps.cone);
  if (!has_gamma) return rows;
  const int n_c = n_lambda / (2 + kEdges);
  rows.segment(n_c, n_c).setConstant(gaps.distance);
  rows.tail(n_c * kEdges).setConstant(gaps.slip);
  return rows;
}

}  // namespace

std::unique_ptr<PlanningModel> make_model(const Parameters& parameters) {
  return parameters.balls == 1 ? make_one_ball(parameters) : make_several_balls(parameters);
}

c3::Costs costs_of(const PlanningModel& model, PhaseWeights weights, bool has_gamma, int ball) {
  std::swap(weights.Q_ball_xy[0], weights.Q_ball_xy[static_cast<std::size_t>(ball)]);
  const int n_x = model.n_x();
  const int n_lambda = n_lambda_of(model.n_c(Contacts::kPlanned), has_gamma);
  const int n_z = n_x + n_lambda + kInputs;
  const Eigen::VectorXd Q = model.Q(weights);

  Eigen::VectorXd G(n_z);
  G.head(n_x).setConstant(weights.G_x);
  G.segment(n_x, n_lambda) = G_of_lambda(model, weights, has_gamma);
  G.tail(kInputs).setConstant(weights.G_u);

  Eigen::VectorXd U(n_z);
  U.head(n_x).setConstant(weights.U_x);
  U.segment(n_x, n_lambda).setConstant(weights.U_lambda);
  U.tail(kInputs).setConstant(weights.U_u);

  c3::Costs costs;
  costs.Q = Q.asDiagonal();
  costs.Q_N = Q.asDiagonal();
  costs.R = weights.R * Eigen::MatrixXd::Identity(kInputs, kInputs);
  costs.G = G.asDiagonal();
  if (weights.U_x > 0.0) costs.U = U.asDiagonal();  // else the projection has no use for it
  costs.convex = {weights.U_x * Eigen::MatrixXd::Identity(n_x, n_x),
                  weights.U_u * Eigen::MatrixXd::Identity(kInputs, kInputs), weights.convex_alpha,
                  weights.convex_epsilon};
  costs.plus.g_lambda = weights.plus_g_lambda
                            ? Eigen::VectorXd::Constant(n_lambda, *weights.plus_g_lambda)
                            : Eigen::VectorXd(G.segment(n_x, n_lambda));
  costs.plus.u_lambda.setConstant(n_lambda, weights.plus_u_lambda);
  costs.plus.g_eta = of_rows(weights.plus_g_eta, n_lambda, has_gamma);
  costs.plus.u_eta = of_rows(weights.plus_u_eta, n_lambda, has_gamma);
  return costs;
}

C3Step::C3Step(const Parameters& parameters)
    : stewart_trinkle_(is_stewart_trinkle(parameters)),
      dt_(parameters.dt),
      model_(make_model(parameters)),
      n_lambda_(n_lambda_of(model_->n_c(Contacts::kPlanned), stewart_trinkle_)),
      solver_({model_->n_x(), n_lambda_, kInputs, parameters.N}, parameters.c3),
      lemke_(n_lambda_of(model_->n_c(Contacts::kAll), true)),
      x_desired_(Eigen::MatrixXd::Zero(model_->n_x(), parameters.N + 1)),
      x_hat_(model_->n_x()),
      x_next_(model_->n_x()) {
  result_.lambda_d = Eigen::VectorXd::Zero(lemke_.size());
  for (int ball = 0; ball < parameters.balls; ++ball) {
    roll_.push_back(costs_of(*model_, parameters.roll, stewart_trinkle_, ball));
    back_.push_back(costs_of(*model_, parameters.back, stewart_trinkle_, ball));
  }
  // refuses unusable weights at the start, not in the loop
  use(back_[0]);
  use(roll_[0]);
}

void C3Step::use(const c3::Costs& costs) {
  if (&costs != in_use_) solver_.set_costs(costs);
  in_use_ = &costs;
}

StepStatus C3Step::step(const Scene& x_hat, bool rolling, int ball, double delta_t_c,
                        const c3::Deadline& deadline) noexcept {
  // step 2: the LCS about x̂
  model_->state(x_hat, x_hat_);
  const model::ContactSystem system = model_->contact_system(x_hat, Contacts::kPlanned);
  lcs::Lcs planning =
      stewart_trinkle_ ? model::stewart_trinkle(system, dt_) : model::anitescu(system, dt_);
  const double scale = lcs::force_scale(planning);
  lcs::scale_forces(planning, scale);
  // Anitescu's λ are impulses
  result_.force_scale = stewart_trinkle_ ? scale : scale / dt_;

  // step 3: Algorithm 1
  use((rolling ? roll_ : back_)[static_cast<std::size_t>(ball)]);
  const c3::Solution& solution = solver_.solve(planning, x_hat_, x_desired_, deadline);
  result_.solution = &solution;
  if (solution.status == c3::SolveStatus::kFailed) return StepStatus::kFailed;

  // step 5: (x_d, λ_d) = L_Δt_c(x̂, u_C3)
  result_.u_c3 = solution.u_0();
  const lcs::Lcs stepping =
      model::stewart_trinkle(model_->contact_system(x_hat, Contacts::kAll), delta_t_c);
  if (!lcs::step(stepping, x_hat_, result_.u_c3, lemke_, x_next_, result_.lambda_d).ok())
    return StepStatus::kNoStep;
  result_.p_WE = x_next_.head<3>();
  result_.v_WE = x_next_.segment<3>(model_->v_WE());
  result_.force_E = model_->force_on_end_effector(x_hat, result_.lambda_d);
  return solution.status == c3::SolveStatus::kTruncated ? StepStatus::kTruncated : StepStatus::kOk;
}

}  // namespace c3rt::planner
