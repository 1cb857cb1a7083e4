#include "controller/planner/planner.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "controller/c3/solver.hpp"
#include "controller/lcs/lcs.hpp"
#include "controller/lcs/lemke.hpp"
#include "controller/lcs/step.hpp"

namespace c3rt::planner {
namespace {

using L = model::BallLayout;
constexpr std::size_t kPeriodsAveraged = 10;

bool is_stewart_trinkle(const Parameters& parameters) {
  return parameters.contact_model == ContactModel::kStewartTrinkle;
}

/// λ of the planning system: γ, normal force and edges of each contact, or edges alone.
int n_lambda_of(const Parameters& parameters) {
  const int n_c = static_cast<int>(parameters.contacts.size());
  return n_c * (is_stewart_trinkle(parameters) ? 2 + L::n_e : L::n_e);
}

/// What the consensus term weighs λ with, in the order of the planning system.
Eigen::VectorXd G_of_lambda(const Parameters& parameters, const PhaseWeights& weights) {
  const int n_c = static_cast<int>(parameters.contacts.size());
  const bool has_gamma = is_stewart_trinkle(parameters);
  Eigen::VectorXd G(n_lambda_of(parameters));
  if (has_gamma) G.head(n_c).setConstant(weights.G_gamma);
  for (int i = 0; i < n_c; ++i) {
    const bool arm =
        parameters.contacts[static_cast<std::size_t>(i)] == model::BallContact::kEndEffector;
    if (has_gamma) G[n_c + i] = arm ? weights.G_end_effector_normal : weights.G_table_normal;
    G.segment<L::n_e>((has_gamma ? 2 * n_c : 0) + i * L::n_e)
        .setConstant(arm ? weights.G_end_effector_tangential : weights.G_table_tangential);
  }
  return G;
}

c3::Costs costs_of(const Parameters& parameters, const PhaseWeights& weights) {
  const int n_lambda = n_lambda_of(parameters);
  const int n_z = L::n_x + n_lambda + L::n_u;
  Eigen::VectorXd Q = Eigen::VectorXd::Zero(L::n_x);
  Q.segment<3>(L::p_WE).setConstant(weights.Q_end_effector);
  Q.segment<2>(L::p_WB).setConstant(weights.Q_ball_xy);
  Q[L::p_WB + 2] = weights.Q_ball_z;
  Q.segment<3>(L::v_WE).setConstant(weights.Q_end_effector_velocity);
  Q.segment<3>(L::omega_WB).setConstant(weights.Q_ball_velocity);
  Q.segment<3>(L::v_WB).setConstant(weights.Q_ball_velocity);

  Eigen::VectorXd G(n_z);
  G.head(L::n_x).setConstant(weights.G_x);
  G.segment(L::n_x, n_lambda) = G_of_lambda(parameters, weights);
  G.tail(L::n_u).setConstant(weights.G_u);

  Eigen::VectorXd U(n_z);
  U.head(L::n_x).setConstant(weights.U_x);
  U.segment(L::n_x, n_lambda).setConstant(weights.U_lambda);
  U.tail(L::n_u).setConstant(weights.U_u);

  c3::Costs costs;
  costs.Q = Q.asDiagonal();
  costs.Q_N = Q.asDiagonal();
  costs.R = weights.R * Eigen::MatrixXd::Identity(L::n_u, L::n_u);
  costs.G = G.asDiagonal();
  costs.U = U.asDiagonal();
  costs.convex = {weights.U_x * Eigen::MatrixXd::Identity(L::n_x, L::n_x),
                  weights.U_u * Eigen::MatrixXd::Identity(L::n_u, L::n_u), weights.convex_alpha,
                  weights.convex_epsilon};
  for (const auto& [target, value] : {std::pair{&costs.plus.g_lambda, weights.plus_g_lambda},
                                      std::pair{&costs.plus.g_eta, weights.plus_g_eta},
                                      std::pair{&costs.plus.u_lambda, weights.plus_u_lambda},
                                      std::pair{&costs.plus.u_eta, weights.plus_u_eta}}) {
    *target = Eigen::VectorXd::Constant(n_lambda, value);
  }
  return costs;
}

// The tool points down; the tilt leans it about the axis (e_y, −e_x, 0).
Eigen::Quaterniond tool_orientation(double tilt, const Eigen::Vector2d& e) {
  const Eigen::Quaterniond down(0.0, 1.0, 0.0, 0.0);
  if (tilt == 0.0 || e.norm() < 1e-9) return down;
  const Eigen::Vector2d direction = e.normalized();
  return Eigen::AngleAxisd(tilt, Eigen::Vector3d(direction.y(), -direction.x(), 0.0)) * down;
}

}  // namespace

Mode next(Mode mode, const Situation& situation) {
  if (!situation.state_fresh) return Mode::kWait;
  if (!situation.ball_at_hand || situation.hold_requested) return Mode::kHold;
  switch (mode) {
    case Mode::kWait:
    case Mode::kHold:
      return Mode::kApproach;
    case Mode::kApproach:
      return situation.start_pose_reached ? Mode::kReturn : Mode::kApproach;
    case Mode::kRoll:
    case Mode::kReturn:
      return situation.returning ? Mode::kReturn : Mode::kRoll;
  }
  return Mode::kHold;
}

struct Planner::Workspace {
  explicit Workspace(const Parameters& parameters)
      : solver({L::n_x, n_lambda_of(parameters), L::n_u, parameters.N}, parameters.c3),
        lemke(L::n_lambda),
        roll(costs_of(parameters, parameters.roll)),
        back(costs_of(parameters, parameters.back)),
        x_desired(L::n_x, parameters.N + 1),
        x_next(L::n_x),
        lambda(L::n_lambda) {
    // refuses unusable weights at the start, not in the loop
    use(Phase::kReturnUp);
    use(Phase::kRoll);
  }

  void use(Phase phase) {
    const c3::Costs* wanted = phase == Phase::kRoll ? &roll : &back;
    if (wanted != in_use) solver.set_costs(*wanted);
    in_use = wanted;
  }

  c3::Solver solver;
  lcs::Lemke lemke;
  c3::Costs roll, back;
  const c3::Costs* in_use = nullptr;
  Eigen::MatrixXd x_desired;
  Eigen::VectorXd x_next, lambda;
  std::deque<double> periods;
};

Planner::Planner(const Parameters& parameters)
    : parameters_(parameters), workspace_(std::make_unique<Workspace>(parameters)) {
  plan_.lambda_d = Eigen::VectorXd::Zero(L::n_lambda);
  plan_.x = Eigen::MatrixXd::Zero(L::n_x, parameters.N);
  plan_.lambda = Eigen::MatrixXd::Zero(n_lambda_of(parameters), parameters.N);
  plan_.u = Eigen::MatrixXd::Zero(L::n_u, parameters.N);
  plan_.ball_target.setZero();
  hold(Eigen::Vector3d::Zero());
}

Planner::~Planner() = default;

const Plan& Planner::step(const Input& input, c3::Deadline deadline) noexcept {
  const double period = previous_now_ < 0.0 ? 1.0 / parameters_.rate : input.now - previous_now_;
  previous_now_ = input.now;
  workspace_->periods.push_back(period);
  if (workspace_->periods.size() > kPeriodsAveraged) workspace_->periods.pop_front();

  Situation situation{};
  situation.state_fresh = input.state_fresh && input.p_WE.allFinite() && input.v_WE.allFinite();
  const ApproachParameters& reach = parameters_.approach;
  situation.ball_at_hand = input.ball_fresh && input.p_WB.allFinite() && input.v_WB.allFinite() &&
                           input.omega_WB.allFinite() && input.q_WB.coeffs().allFinite() &&
                           (input.p_WB.head<2>().array() >= reach.reach_min.array()).all() &&
                           (input.p_WB.head<2>().array() <= reach.reach_max.array()).all();
  situation.hold_requested = input.hold_requested;
  situation.start_pose_reached =
      settled_since_ >= 0.0 && input.now - settled_since_ >= parameters_.approach.settle_time;
  const bool in_c3 = mode_ == Mode::kRoll || mode_ == Mode::kReturn;
  const Phase phase =
      phase_at(parameters_.heuristic, in_c3 && c3_since_ >= 0.0 ? input.now - c3_since_ : 0.0);
  situation.returning = phase != Phase::kRoll;

  const Mode previous = mode_;
  mode_ = next(mode_, situation);
  if (mode_ != previous) {
    if (mode_ == Mode::kApproach || mode_ == Mode::kHold) {
      reference_ = input.p_WE;
      settled_since_ = -1.0;
    }
    if (previous == Mode::kApproach && mode_ == Mode::kReturn) {
      c3_since_ = input.now;
      if (task_since_ < 0.0) task_since_ = input.now;
    }
    if (in_c3 && !situation.ball_at_hand) ++counters_.ball_lost;
  }

  switch (mode_) {
    case Mode::kWait:
      hold(input.state_fresh ? input.p_WE : Eigen::Vector3d::Zero());
      plan_.status = PlanStatus::kFallback;
      break;
    case Mode::kHold: {
      // out of the cameras' way, where it can start again from
      const double safe = parameters_.model.table_height + parameters_.approach.safe_height;
      (void)advance_reference(input,
                              {reference_.x(), reference_.y(), std::max(reference_.z(), safe)});
      hold(reference_);
      break;
    }
    case Mode::kApproach:
      approach(input);
      break;
    case Mode::kRoll:
    case Mode::kReturn:
      plan_with_c3(input, deadline);
      break;
  }
  plan_.mode = mode_;
  return plan_;
}

Eigen::Vector2d Planner::target(const Input& input, double ahead,
                                const Eigen::Vector2d& ball) const noexcept {
  if (input.circle) return circle_target(*input.circle, ball);
  const double elapsed = task_since_ < 0.0 ? 0.0 : input.now - task_since_;
  return planner::target(parameters_.task, elapsed, ahead, ball);
}

void Planner::hold(const Eigen::Vector3d& p_WE) noexcept {
  plan_.status = PlanStatus::kOk;
  plan_.p_WE = p_WE;
  plan_.v_WE.setZero();
  plan_.q_WE = tool_orientation(0.0, Eigen::Vector2d::Zero());
  plan_.force_E.setZero();
  plan_.delta_t_c = 0.0;
  plan_.u_c3.setZero();
  plan_.lambda_d.setZero();
  // nothing was predicted: no horizon of an earlier solve goes out with it
  plan_.x.setZero();
  plan_.lambda.setZero();
  plan_.u.setZero();
  plan_.admm_iterations = 0;
  plan_.complementarity_violation = 0.0;
}

// One period's step towards the goal; @return whether it is reached. An arm that does not follow
// (stopped by a person, a reflex) is waited for, so that it finds the reference near by when it
// moves again.
bool Planner::advance_reference(const Input& input, const Eigen::Vector3d& goal) noexcept {
  if ((reference_ - input.p_WE).norm() > parameters_.approach.leash) return false;
  const Eigen::Vector3d way = goal - reference_;
  const double step = parameters_.approach.speed * workspace_->periods.back();
  const bool arrives = way.norm() <= step;
  reference_ = arrives ? goal : Eigen::Vector3d(reference_ + way.normalized() * step);
  return arrives;
}

void Planner::approach(const Input& input) noexcept {
  const double period = workspace_->periods.back();
  const double safe = parameters_.model.table_height + parameters_.approach.safe_height;
  const Eigen::Vector3d start(input.p_WB.x(), input.p_WB.y(),
                              input.p_WB.z() + parameters_.approach.start_height);
  const bool above = (reference_ - start).head<2>().norm() < parameters_.approach.tolerance;
  // up, across, down: never through the ball
  Eigen::Vector3d goal = start;
  if (!above && reference_.z() < safe - parameters_.approach.tolerance) {
    goal << reference_.x(), reference_.y(), safe;
  } else if (!above) {
    goal.z() = safe;
  }
  const Eigen::Vector3d before = reference_;
  const bool arrived = advance_reference(input, goal);
  hold(reference_);
  if (!arrived) plan_.v_WE = (reference_ - before) / period;
  plan_.ball_target << target(input, 0.0, input.p_WB.head<2>()), input.p_WB.z();
  if ((input.p_WE - start).norm() > parameters_.approach.tolerance) {
    settled_since_ = -1.0;
  } else if (settled_since_ < 0.0) {
    settled_since_ = input.now;
  }
}

void Planner::plan_with_c3(const Input& input, c3::Deadline deadline) noexcept {
  Workspace& work = *workspace_;
  // the camera saw the ball a while ago; the arm's state is of now
  const Eigen::Vector3d p_WB = parameters_.predict_ball
                                   ? Eigen::Vector3d(input.p_WB + input.ball_age * input.v_WB)
                                   : input.p_WB;
  const Eigen::Vector2d target_now = target(input, 0.0, p_WB.head<2>());
  const Eigen::Vector2d e = target_now - p_WB.head<2>();

  // Algorithm 3, steps 1 and 2: x̂ and the LCS about it
  model::BallState state{input.p_WE, input.q_WB, p_WB, input.v_WE, input.omega_WB, input.v_WB};
  if (parameters_.separate_overlap)
    model::separate(parameters_.model, Eigen::Vector3d(e.x(), e.y(), 0.0), state);
  const model::ContactSystem system =
      model::ball_contact_system(parameters_.model, state, parameters_.contacts);
  const model::BallStateVector x_hat = model::to_vector(state);
  lcs::Lcs planning = is_stewart_trinkle(parameters_)
                          ? model::stewart_trinkle(system, parameters_.dt)
                          : model::anitescu(system, parameters_.dt);
  const double scale = lcs::force_scale(planning);
  lcs::scale_forces(planning, scale);

  const Phase phase = phase_at(parameters_.heuristic, input.now - c3_since_);
  const double ball_height = parameters_.model.table_height + parameters_.model.ball_radius;
  model::BallState desired{};
  desired.p_WE = end_effector_target(parameters_.heuristic, parameters_.model, phase, state.p_WE,
                                     state.p_WB, target_now);
  desired.q_WB.setIdentity();
  desired.p_WB << target_now, ball_height;
  desired.v_WE.setZero();
  desired.omega_WB.setZero();
  desired.v_WB.setZero();
  work.x_desired.colwise() = Eigen::VectorXd(model::to_vector(desired));
  for (int k = 1; k <= parameters_.N; ++k)
    work.x_desired.col(k).segment<2>(L::p_WB) = target(input, k * parameters_.dt, p_WB.head<2>());

  // step 3: Algorithm 1
  work.use(phase);
  const c3::Solution& solution = work.solver.solve(planning, x_hat, work.x_desired, deadline);
  counters_.branch_nodes += static_cast<std::uint64_t>(solution.branch_nodes);

  // step 4
  double delta_t_c = input.solve_time;
  if (parameters_.delta_t_c_source == DeltaTcSource::kPeriod) {
    double sum = 0.0;
    for (const double period : work.periods) sum += period;
    delta_t_c = sum / static_cast<double>(work.periods.size());
  }
  // a stalled process must not turn into a huge step when it comes back
  delta_t_c = std::min(std::max(delta_t_c, 1e-3), parameters_.dt);

  hold(input.p_WE);
  plan_.ball_target = desired.p_WB;
  plan_.q_WE = tool_orientation(parameters_.tilt, e);
  plan_.delta_t_c = delta_t_c;
  if (solution.status == c3::SolveStatus::kFailed) {
    plan_.status = PlanStatus::kFallback;
    ++counters_.fallbacks;
    return;
  }

  // step 5: (x_d, λ_d) = L_Δt_c(x̂, u_C3)
  const Eigen::Vector3d u_0 = solution.u_0();
  const lcs::Lcs stepping =
      model::stewart_trinkle(model::ball_contact_system(parameters_.model, state), delta_t_c);
  if (!lcs::step(stepping, x_hat, u_0, work.lemke, work.x_next, work.lambda).ok()) {
    plan_.status = PlanStatus::kFallback;
    ++counters_.lcp_failures;
    ++counters_.fallbacks;
    return;
  }
  plan_.status =
      solution.status == c3::SolveStatus::kTruncated ? PlanStatus::kTruncated : PlanStatus::kOk;
  if (plan_.status == PlanStatus::kTruncated) ++counters_.truncated;
  plan_.p_WE = work.x_next.segment<3>(L::p_WE);
  plan_.v_WE = work.x_next.segment<3>(L::v_WE);
  const double speed = plan_.v_WE.norm();
  if (speed > parameters_.speed_limit) {
    const Eigen::Vector3d way = plan_.p_WE - input.p_WE;
    if (way.norm() > 0.0)
      plan_.p_WE = input.p_WE + way.normalized() * parameters_.speed_limit * delta_t_c;
    plan_.v_WE *= parameters_.speed_limit / speed;
    ++counters_.speed_clamped;
  }
  plan_.force_E = model::force_on_end_effector(state, work.lambda);
  plan_.lambda_d = work.lambda;
  plan_.u_c3 = u_0;
  plan_.x = solution.z.topRows(L::n_x);
  // Anitescu's λ are impulses
  const double to_newton = is_stewart_trinkle(parameters_) ? scale : scale / parameters_.dt;
  const Eigen::Index n_lambda = plan_.lambda.rows();
  plan_.lambda = to_newton * solution.z.middleRows(L::n_x, n_lambda);
  plan_.u = solution.z.middleRows(L::n_x + n_lambda, L::n_u);
  plan_.admm_iterations = solution.iterations;
  plan_.primal_residual = solution.primal_residual;
  plan_.complementarity_violation = solution.complementarity_violation;
}

}  // namespace c3rt::planner
