#include "controller/c3/polish.hpp"

#include <algorithm>
#include <cmath>

#include "controller/lcs/step.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSame = 1e-9;  // of a cost

}  // namespace

Polish::Polish(const Sizes& sizes, int max_qps)
    : sizes_(sizes),
      reduced_sizes_{sizes.n_x, 0, sizes.n_u, sizes.N},
      n_pairs_(sizes.N * sizes.n_lambda),
      max_qps_(max_qps),
      lemke_(sizes.n_lambda),
      modes_(sizes.N, FixedModes(sizes)),
      constraints_(sizes),
      riccati_(reduced_sizes_) {
  const int n_x = sizes.n_x, n_u = sizes.n_u, n = n_x + n_u;
  const lcs::Lcs without_pairs{
      MatrixXd::Zero(n_x, n_x), MatrixXd::Zero(n_x, n_u), MatrixXd(n_x, 0), VectorXd::Zero(n_x),
      MatrixXd(0, n_x),         MatrixXd(0, 0),           MatrixXd(0, n_u), VectorXd(0)};
  reduced_.assign(sizes.N, without_pairs);
  hessian_.assign(sizes.N, MatrixXd::Zero(n, n));
  plan_.x.setZero(n_x, sizes.N + 1);
  plan_.s.setZero(sizes.n_lambda, sizes.N);
  plan_.u.setZero(n_u, sizes.N);
  plan_.force.assign(n_pairs_, 0);
  best_ = first_ = candidate_ = plan_;
  contact_.assign(sizes.n_lambda, 0);
  u_before_ = u_first_ = plan_.u;
  z_.setZero(sizes.n_z(), sizes.N);
  for (MatrixXd* m : {&xu_, &gradient_, &total_, &step_}) m->setZero(n, sizes.N);
  no_defect_.setZero(n_x, sizes.N);
  for (VectorXd* v : {&x0_, &gradient_N_, &total_N_, &step_N_, &p_, &p_next_}) v->setZero(n_x);
  x_desired_.setZero(n_x, sizes.N + 1);
}

void Polish::set_costs(const Costs& costs, const Constraints& constraints) {
  costs_ = costs;
  constraints_.set(constraints);
  for (int k = 0; k < sizes_.N; ++k) {
    hessian_[k].topLeftCorner(sizes_.n_x, sizes_.n_x) = costs.Q[k];
    hessian_[k].bottomRightCorner(sizes_.n_u, sizes_.n_u) = costs.R[k];
  }
  constraint_normals_.setZero(sizes_.n_x + sizes_.n_u, constraints_.all());
  constraint_offsets_.setZero(constraints_.all());
  penalties_.prepare(sizes_.N, row_count());
  active_.clear();
  active_.reserve(row_count());
  kept_.reserve(row_count());
  again_.reserve(row_count());
  side_.assign(row_count(), Side::kNone);
  sides_.reserve(2 * row_count());
  for (VectorXd* v : {&s_, &y_, &ds_, &dy_, &complementarity_}) v->setZero(2 * row_count());
  for (VectorXd* v : {&weight_, &multiplier_, &inverse_hessian_, &value_}) v->setZero(row_count());
}

void Polish::start(Horizon lcs, const Eigen::Ref<const VectorXd>& x0,
                   const Eigen::Ref<const MatrixXd>& x_desired, const Eigen::Ref<const MatrixXd>& u,
                   const Eigen::Ref<const MatrixXd>& lambda) noexcept {
  projected_ = lambda;
  lcs_ = lcs;
  x0_ = x0;
  x_desired_ = x_desired;
  report_ = {};
  report_.status = PolishStatus::kNoPlan;
  kept_.clear();
  is_loaded_ = false;
  take_inputs(u);
  if (simulate(plan_)) judge(plan_);
  first_ = plan_;
  report_.cost_before = report_.cost;
}

void Polish::improve(const Eigen::Ref<const MatrixXd>& u, const Deadline& deadline) noexcept {
  const int left = max_qps_ - report_.qps;
  if (report_.status == PolishStatus::kDeadline || left < (report_.qps > 0 ? kFewestQps : 1))
    return;
  take_inputs(u);
  if (plan_.u == first_.u) {
    plan_ = first_;
  } else if (simulate(plan_)) {
    judge(plan_);
  }
  begin_descent((left + 1) / 2);
  load(plan_, true);
  descend(plan_, Effort::kThorough, deadline);
  end_descent();
}

bool Polish::resume(const Eigen::Ref<const MatrixXd>& u, const PairModes& modes,
                    const Deadline& deadline) noexcept {
  const int left = max_qps_ - report_.qps;
  if (modes(0, 0) == kNoMode || report_.status == PolishStatus::kDeadline || left <= 0)
    return false;
  const double before = report_.cost;
  take_inputs(u);
  again_.clear();
  for (int row = 0; row < n_pairs_; ++row) {
    const unsigned char mode = modes(row % sizes_.n_lambda, row / sizes_.n_lambda);
    plan_.force[row] = (mode & kForceMode) != 0 ? 1 : 0;
    if ((mode & kHeldMode) != 0) again_.push_back(row);
  }
  begin_descent(std::max(std::min(left, kMoveQps), (left + 1) / 2));
  load(plan_, false);
  if (solve()) {  // how little holds a row is told without the others
    hold_again();
    descend(plan_, Effort::kQuick, deadline);
  }
  end_descent();
  return report_.cost < before;
}

void Polish::read_modes(PairModes& modes) const noexcept {
  modes.resize(sizes_.n_lambda, sizes_.N);
  for (int row = 0; row < n_pairs_; ++row)
    modes(row % sizes_.n_lambda, row / sizes_.n_lambda) = best_.force[row] != 0 ? kForceMode : 0;
  for (const Kept& kept : kept_) {
    if (is_pair(kept.row))
      modes(kept.row % sizes_.n_lambda, kept.row / sizes_.n_lambda) |= kHeldMode;
  }
}

void Polish::begin_descent(int qps) noexcept {
  report_.status = PolishStatus::kBest;
  limit_ = report_.qps + qps;
}

void Polish::end_descent() noexcept {
  // the next call goes on where this one has no QPs left
  if (report_.status == PolishStatus::kQpLimit && plan_.violation <= kMet &&
      plan_.cost <= (1.0 + kSame) * report_.cost) {
    for (int row = 0; row < n_pairs_; ++row)
      best_.force[row] = modes_[row / sizes_.n_lambda].has_force(row % sizes_.n_lambda) ? 1 : 0;
    keep_active();
  }
  if (report_.status == PolishStatus::kQpLimit && report_.qps < max_qps_)
    report_.status = PolishStatus::kBest;  // the limit was this plan's
  if (report_.status == PolishStatus::kBest && !std::isfinite(report_.cost))
    report_.status = PolishStatus::kNoPlan;
}

/// Inputs, those with bounds within them: others are no plan.
void Polish::take_inputs(const Eigen::Ref<const MatrixXd>& u) noexcept {
  plan_.u = u;
  const int first = sizes_.n_x + sizes_.n_lambda;
  for (int i = 0; i < constraints_.count(); ++i) {
    const qp::QpRows::Row& row = constraints_[i];
    if (row.stage == sizes_.N || row.coordinate < first) continue;
    double& input = plan_.u(row.coordinate - first, row.stage);
    input = std::min(std::max(input, row.lower), row.upper);
  }
}

/// Judges the plan with the present modes.
void Polish::consider(const Plan& plan) noexcept {
  if (!(plan.violation <= kMet) || !(plan.cost < report_.cost)) return;
  candidate_ = plan;
  for (int k = 0; k < sizes_.N; ++k) {
    for (int j = 0; j < sizes_.n_lambda; ++j) {
      candidate_.force[k * sizes_.n_lambda + j] = modes_[k].has_force(j) ? 1 : 0;
      if (!modes_[k].has_force(j)) candidate_.s(j, k) = 0.0;
    }
    // by the system itself, without the rounding of the modes' tables
    auto next = candidate_.x.col(k + 1);
    next = lcs_[k].d;
    next.noalias() += lcs_[k].A * candidate_.x.col(k);
    next.noalias() += lcs_[k].B * candidate_.u.col(k);
    next.noalias() += lcs_[k].D * candidate_.s.col(k);
  }
  if (judge(candidate_)) keep_active();
}

/// The plan of its inputs, each LCP solved by Lemke's method. False where one is not solved: from
/// there on the modes are those of the last projection.
bool Polish::simulate(Plan& plan) noexcept {
  const int n_lambda = sizes_.n_lambda;
  plan.x.col(0) = x0_;
  for (int k = 0; k < sizes_.N; ++k) {
    char* force = plan.force.data() + k * n_lambda;
    auto lambda = plan.s.col(k);
    if (lcs::step(lcs_[k], plan.x.col(k), plan.u.col(k), lemke_, plan.x.col(k + 1), lambda).ok()) {
      for (int j = 0; j < n_lambda; ++j) force[j] = lambda[j] > 0.0 ? 1 : 0;
      continue;
    }
    // Lemke's method takes long to find none
    for (; k < sizes_.N; ++k, force += n_lambda) {
      for (int j = 0; j < n_lambda; ++j) force[j] = projected_(j, k) > 0.0 ? 1 : 0;
    }
    return false;
  }
  return plan.x.allFinite();
}

/// Keeps a plan with complementary forces, s = λ, if it meets the constraints and is the best.
bool Polish::judge(const Plan& plan) noexcept {
  const int N = sizes_.N;
  z_.topRows(sizes_.n_x) = plan.x.leftCols(N);
  z_.middleRows(sizes_.n_x, sizes_.n_lambda) = plan.s;
  z_.bottomRows(sizes_.n_u) = plan.u;
  p_next_ = plan.x.col(N);
  double violation = 0.0, cost = 0.0;
  for (int i = 0; i < constraints_.count(); ++i) {
    const double value = constraints_.value(i, z_, p_next_);
    violation = std::max(violation,
                         std::abs(constraints_.outside(i, value)) / (kOfValue + std::abs(value)));
  }
  for (int k = 0; k <= N; ++k) {
    p_ = plan.x.col(k) - x_desired_.col(k);
    p_next_.noalias() = (k == N ? costs_.Q_N : costs_.Q[k]) * p_;
    cost += p_.dot(p_next_);
    if (k == N) break;
    total_.col(k).tail(sizes_.n_u).noalias() = costs_.R[k] * plan.u.col(k);
    cost += plan.u.col(k).dot(total_.col(k).tail(sizes_.n_u));
  }
  if (!(violation <= kMet) || !std::isfinite(cost) || !(cost < report_.cost)) return false;
  report_.cost = cost;
  best_ = plan;
  kept_.clear();
  return true;
}

}  // namespace c3rt::c3
