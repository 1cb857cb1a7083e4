#include "controller/planner/strategy/candidate.hpp"

#include <algorithm>
#include <stdexcept>

#include "controller/lcs/servo.hpp"
#include "controller/lcs/simulate.hpp"
#include "controller/planner/strategy/reach.hpp"

namespace c3rt::planner {
namespace {

constexpr double kPastReach = 5e-3;  // a trial ends not exactly where the body will [m]

}  // namespace

Candidate::Candidate(const Parameters& parameters, const ServoGains& servo)
    : c3_(parameters),
      sampling_(parameters.sampling),
      reach_(parameters.approach.reach_min, parameters.approach.reach_max),
      lemke_(c3_.n_lambda()),
      N_(parameters.N),
      dt_(parameters.dt) {
  if (c3_.n_u() != 3)
    throw std::invalid_argument(
        "strategy sampling: expected a model with the force on the end "
        "effector as its 3 inputs, got " +
        std::to_string(c3_.n_u()));
  const model::Layout& layout = c3_.model().layout();
  K_.setZero(c3_.n_u(), c3_.n_x());
  K_.middleCols<3>(layout.p_WE).diagonal().setConstant(servo.stiffness);
  K_.middleCols<3>(layout.v_WE).diagonal().setConstant(servo.damping);
  Q_.setZero(c3_.n_x());
  planned_.setZero(c3_.n_x(), N_);
  w_.setZero(c3_.n_u(), N_);
  x_.setZero(c3_.n_x(), N_ + 1);
  lambda_.setZero(c3_.n_lambda(), N_);
  x_alone_.setZero(c3_.n_x());
}

void Candidate::set_costs(const c3::Costs& costs) {
  if (costs_ < 0) {
    costs_ = c3_.add_costs(costs);
  } else {
    c3_.replace_costs(costs_, costs);
  }
  Q_.setZero();
  const Eigen::VectorXd all = costs.Q[0].diagonal();
  for (const model::StateBlock& block : c3_.model().layout().x) {
    if (block.body >= 0) Q_.segment(block.start, block.size) = all.segment(block.start, block.size);
  }
}

bool Candidate::leaves_reach(const scene::Scene& from, const scene::Scene& wanted) const {
  const std::vector<model::StateBlock>& blocks = c3_.model().layout().x;
  return std::any_of(blocks.begin(), blocks.end(), [&](const model::StateBlock& block) {
    if (block.body < 0 || block.size != 2) return false;  // where a body is in the plane
    const int body = c3_.model().body(block.body, from);
    const Eigen::Vector2d begin = x_.col(0).segment<2>(block.start);
    const Eigen::Vector2d end = x_.col(N_).segment<2>(block.start);
    if (reach_.exteriorDistance(end) > reach_.exteriorDistance(begin)) return true;
    const BodyReach reach(sampling_, from.body(body), from.effector.radius);
    const double asked_for = reach.beyond(wanted.body(body).p_WB.head<2>());
    return reach.beyond(end) > std::max({0.0, reach.beyond(begin), asked_for}) + kPastReach;
  });
}

Worth Candidate::worth(const c3::Costs& costs, const scene::Scene& from,
                       const std::vector<scene::Scene>& desired) {
  Worth worth;
  set_costs(costs);
  for (int k = 0; k <= N_; ++k) c3_.want(k, desired[static_cast<std::size_t>(k)], from);
  if (c3_.plan(from, costs_, {}) == StepStatus::kFailed) return worth;
  const c3::Solution& plan = *c3_.result().solution;
  planned_.leftCols(N_ - 1) = plan.z.topRows(c3_.n_x()).rightCols(N_ - 1);
  planned_.col(N_ - 1) = plan.x_N;
  lcs::close_loop(c3_.planning_system(), K_, closed_, G_);
  w_.noalias() = G_ * planned_;
  if (!lcs::simulate(closed_, c3_.x_hat(), w_, lemke_, x_, lambda_).ok() || !x_.allFinite())
    return worth;
  if (leaves_reach(from, desired.back())) return worth;
  const auto cost_of = [&](const auto& x, int k) {
    return (x - c3_.x_desired().col(k)).cwiseAbs2().dot(Q_);
  };
  alone_ = from;
  for (int k = 1; k <= N_; ++k) {
    for (int i = 0; i < alone_.body_count; ++i) alone_.body(i).p_WB += dt_ * alone_.body(i).v_WB;
    c3_.model().state_about(alone_, from, x_alone_);
    worth.cost += cost_of(x_.col(k), k);
    worth.still += cost_of(x_alone_, k);
  }
  worth.known = true;
  return worth;
}

}  // namespace c3rt::planner
