#include "controller/planner/planner.hpp"

#include <algorithm>
#include <cstring>
#include <exception>

#include "controller/planner/strategy/registry.hpp"

namespace c3rt::planner {
namespace {

// Without plans, or without a robot that follows them, for this long: what was going on is over
// [s].
constexpr double kLeft = 0.2;

}  // namespace

Planner::Planner(const Parameters& parameters, const c3::Parallel& parallel)
    : Planner(parameters, strategy_kind(parameters.strategy).make, parallel) {}

Planner::Planner(const Parameters& parameters, MakeStrategy make, const c3::Parallel& parallel)
    : parameters_(parameters),
      parallel_(parallel),
      c3_(parameters),
      strategy_(make(parameters, c3_)) {
  plan_.lambda_d = Eigen::VectorXd::Zero(c3_.n_lambda_d());
  plan_.x = Eigen::MatrixXd::Zero(c3_.n_x(), parameters.N);
  plan_.lambda = Eigen::MatrixXd::Zero(c3_.n_lambda(), parameters.N);
  plan_.u = Eigen::MatrixXd::Zero(c3_.n_u(), parameters.N);
  plan_.primal_residual = Eigen::VectorXd::Zero(parameters.c3.admm_iterations);
  plan_.body = 0;
  plan_.body_target.setZero();
  plan_.mode = Mode::kWait;
  plan_.phase = name(Mode::kWait, "");
  hold(Eigen::Vector3d::Zero());
}

const Plan& Planner::step(const Input& input, c3::Deadline deadline) noexcept {
  try {
    compose(input, deadline);
  } catch (const std::exception& error) {
    ++counters_.failures;
    ++counters_.fallbacks;
    std::strncpy(failure_.data(), error.what(), failure_.size() - 1);
    const bool known = input.effector.p_WE.allFinite();
    hold(known ? input.effector.p_WE : Eigen::Vector3d(Eigen::Vector3d::Zero()));
    plan_.status = PlanStatus::kFallback;
    plan_.mode = known ? Mode::kHold : Mode::kWait;
    plan_.phase = name(plan_.mode, "");
    plan_.weighed.clear();
    plan_.place.reset();
  }
  return plan_;
}

void Planner::compose(const Input& input, const c3::Deadline& deadline) {
  Situation situation{};
  situation.input = &input;
  situation.period = measured_period(input, situation.interrupted);
  if (input.robot_follows && !situation.interrupted) followed_ = input.now;
  situation.robot_left = input.now - followed_ > kLeft;
  situation.available = available(parameters_, input);
  situation.scene = estimate(input);
  situation.parallel = parallel_;

  const Decision& decision = strategy_->decide(situation, c3_);
  if (!decision.plans_with_c3) c3_.forget_plan();
  if (decision.body_lost) ++counters_.body_lost;
  plan_.mode = decision.mode;
  plan_.phase = name(decision.mode, decision.phase);
  plan_.body = decision.body;
  plan_.body_target = decision.body_target;
  plan_.weighed = decision.weighed;
  plan_.place = decision.place;
  if (decision.mode == Mode::kWait) {
    hold(situation.available.state() ? input.effector.p_WE : Eigen::Vector3d::Zero());
    plan_.status = PlanStatus::kFallback;
  } else if (decision.plans_with_c3) {
    plan_with_c3(input, decision, deadline);
  } else {
    hold(decision.p_WE);
    plan_.v_WE = decision.v_WE;
    plan_.q_WE = decision.q_WE;
    plan_.force_E = decision.force_bias;
  }
  tell(situation, decision);
}

double Planner::measured_period(const Input& input, bool& interrupted) {
  double period = previous_now_ < 0.0 ? 1.0 / parameters_.rate : input.now - previous_now_;
  // a process that was stopped goes on with nothing, least of all with a step of that length
  interrupted = period > kLeft;
  if (interrupted) period = 1.0 / parameters_.rate;
  previous_now_ = input.now;
  if (period_count_ == kPeriodsAveraged) {
    std::copy(periods_.begin() + 1, periods_.end(), periods_.begin());
    --period_count_;
  }
  periods_[static_cast<std::size_t>(period_count_++)] = period;
  return period;
}

scene::Scene Planner::estimate(const Input& input) const {
  scene::Scene scene = c3_.model().layout().world;
  scene.effector.p_WE = input.effector.p_WE;
  scene.effector.v_WE = input.effector.v_WE;
  scene.body_count = parameters_.model.bodies;
  for (int i = 0; i < parameters_.model.bodies; ++i) {
    const BodyInput& seen = input.bodies[static_cast<std::size_t>(i)];
    scene::Body& body = scene.body(i);
    const scene::Body known = body;
    body = seen.body;
    body.shape = known.shape;
    body.name = known.name;
    // the camera saw the body a while ago; the arm's state is of now
    if (parameters_.predict_objects) {
      const double age = std::min(seen.age, parameters_.estimate_timeout);
      body.p_WB = seen.body.p_WB + age * seen.body.v_WB;
    }
  }
  return scene;
}

double Planner::delta_t_c(const Input& input) const {
  if (parameters_.delta_t_c > 0.0) return parameters_.delta_t_c;
  double result = input.solve_time;
  if (parameters_.delta_t_c_source == DeltaTcSource::kPeriod) {
    double sum = 0.0;
    for (int i = 0; i < period_count_; ++i) sum += periods_[static_cast<std::size_t>(i)];
    result = sum / static_cast<double>(period_count_);
  }
  // a stalled process must not turn into a huge step when it comes back
  return std::min(std::max(result, 1e-3), parameters_.dt);
}

void Planner::hold(const Eigen::Vector3d& p_WE) {
  plan_.status = PlanStatus::kOk;
  plan_.p_WE = p_WE;
  plan_.v_WE.setZero();
  plan_.q_WE = Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);  // the tool points down
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

void Planner::plan_with_c3(const Input& input, const Decision& decision,
                           const c3::Deadline& deadline) {
  for (int k = 0; k <= parameters_.N; ++k)
    c3_.want(k, decision.desired.at(static_cast<std::size_t>(k)), decision.x_hat);
  hold(input.effector.p_WE);
  plan_.q_WE = decision.q_WE;
  plan_.delta_t_c = delta_t_c(input);

  const StepStatus status = c3_.step(decision.x_hat, decision.costs, plan_.delta_t_c, deadline);
  const StepResult& result = c3_.result();
  if (result.solution != nullptr)
    counters_.branch_nodes += static_cast<std::uint64_t>(result.solution->branch_nodes);
  if (status == StepStatus::kFailed || status == StepStatus::kNoStep) {
    plan_.status = PlanStatus::kFallback;
    ++counters_.fallbacks;
    if (status == StepStatus::kNoStep) ++counters_.lcp_failures;
    return;
  }
  plan_.status = status == StepStatus::kTruncated ? PlanStatus::kTruncated : PlanStatus::kOk;
  if (status == StepStatus::kTruncated) ++counters_.truncated;
  plan_.p_WE = result.p_WE + decision.raised * Eigen::Vector3d::UnitZ();
  plan_.v_WE = result.v_WE;
  const double speed = plan_.v_WE.norm();
  if (speed > parameters_.speed_limit) {
    const Eigen::Vector3d way = plan_.p_WE - input.effector.p_WE;
    if (way.norm() > 0.0)
      plan_.p_WE =
          input.effector.p_WE + way.normalized() * parameters_.speed_limit * plan_.delta_t_c;
    plan_.v_WE *= parameters_.speed_limit / speed;
    ++counters_.speed_clamped;
  }
  plan_.force_E = result.force_E + decision.force_bias;
  plan_.lambda_d = result.lambda_d;
  plan_.u_c3 = result.u_c3;
  const c3::Solution& solution = *result.solution;
  const Eigen::Index n_x = plan_.x.rows(), n_lambda = plan_.lambda.rows();
  plan_.x = solution.z.topRows(n_x);
  plan_.lambda = result.force_scale * solution.z.middleRows(n_x, n_lambda);
  plan_.u = result.input_scale * solution.z.middleRows(n_x + n_lambda, plan_.u.rows());
  plan_.admm_iterations = solution.iterations;
  plan_.primal_residual = solution.primal_residual;
  plan_.complementarity_violation = solution.complementarity_violation;
}

void Planner::tell(const Situation& situation, const Decision& decision) {
  const Input& input = *situation.input;
  Cause cause = situation.available.cause;
  const bool of_state = !situation.available.state();
  const bool of_body = !of_state && cause != Cause::kNone;
  const int body = of_body ? situation.available.body : decision.body;
  // what a client asked for goes before what hinders, and that before what was reached
  const bool asked = decision.cause == Cause::kAsked || decision.cause == Cause::kNotBroughtToRest;
  if (!of_state && input.stopped) {
    cause = Cause::kStopped;
  } else if (!of_state && (asked || cause == Cause::kNone)) {
    cause = decision.cause;
  }
  const bool same_phase = std::strcmp(decision.phase, activity_.phase) == 0;
  if (decision.mode != activity_.mode || !same_phase || cause != activity_.cause ||
      body != activity_.body)
    activity_.since = input.now;
  activity_.mode = decision.mode;
  activity_.phase = decision.phase;
  activity_.cause = cause;
  activity_.body = std::min(body, parameters_.model.bodies - 1);
  const auto meant = static_cast<std::size_t>(activity_.body);
  activity_.body_name = situation.scene.bodies[meant].name;
  activity_.age = of_state ? input.state_age : input.bodies[meant].age;
  activity_.body_at = situation.scene.bodies[meant].p_WB.head<2>();
  activity_.body_speed = situation.scene.bodies[meant].v_WB.head<2>().norm();
}

}  // namespace c3rt::planner
