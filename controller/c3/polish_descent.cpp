#include <algorithm>
#include <cmath>

#include "controller/c3/polish.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kGain = 1e-5;         // of the cost: what is not worth another QP
constexpr double kRecoverable = 1e-5;  // violation that the penalties take out again
constexpr int kMaxCorrections = 2;     // of rows that a penalty has not brought to their bounds
constexpr double kRounding = 1e-9;     // of a cost
constexpr double kHeld = 1e-6;         // a rate this small beside its terms is a held row's
constexpr int kMaxLeaps = 12;
constexpr int kBoldLeaps = 6;  // that may hold and drop at once, which can go round in circles

}  // namespace

bool Polish::is_over(const Deadline& deadline) noexcept {
  if (deadline.struck()) report_.status = PolishStatus::kDeadline;
  if (report_.qps >= limit_) report_.status = PolishStatus::kQpLimit;
  return report_.status != PolishStatus::kBest;
}

/// From a plan that is loaded.
void Polish::descend(Plan& plan, Effort effort, const Deadline& deadline) noexcept {
  u_first_ = plan.u;
  if (!leap(plan, deadline)) {
    consider(plan);  // the QPs may have come to an end at a plan
    if (effort == Effort::kQuick || report_.status != PolishStatus::kBest) return;
    plan.u = u_first_;
    if (!converge(plan, deadline) || !leap(plan, deadline)) return;
  }
  consider(plan);
  if (!release(plan) && plan.violation <= kMet) return;
  if (is_over(deadline) || !solve()) return;
  go_on(plan, deadline);
}

/// To the minimiser with the present modes by whole steps: after each the rows are dropped whose
/// multipliers have the wrong sign, and all are held that are violated; it ends, too, where that
/// brings nothing more. False where that has no end.
bool Polish::leap(Plan& plan, const Deadline& deadline) noexcept {
  int corrections = 0;
  bool was_met = false;
  double before = 0.0;
  for (int round = 0; round < kMaxLeaps; ++round) {
    if (is_over(deadline) || !solve()) return false;
    plan.u += step_.bottomRows(sizes_.n_u);
    roll(plan);
    const bool held = hold_violated();
    const bool met = plan.violation <= kMet;
    if (!held && met && was_met && before - plan.cost <= kGain * plan.cost) return true;
    was_met = met;
    before = plan.cost;
    const bool dropped = (round < kBoldLeaps || !held) && drop_held(kGain * plan.cost);
    if (held || dropped) continue;
    if (plan.violation == 0.0 || ++corrections > kMaxCorrections) return true;
  }
  return false;
}

/// Holds again what a plan held at the last call.
void Polish::hold_again() noexcept {
  for (const int row : again_) {
    const double along = inverse_hessian(row);
    if (along > 0.0) add(row, Side::kLower, along);
  }
  again_.clear();
}

/// Holds rows that are violated.
bool Polish::hold_violated() noexcept {
  bool any = false;
  for (int row = 0; row < row_count(); ++row) {
    if (side_[row] != Side::kNone) continue;
    Side side = Side::kNone;
    if (is_pair(row)) {
      if (value_[row] < 0.0 && value_[row] < -slack(row / sizes_.n_lambda, row % sizes_.n_lambda))
        side = Side::kLower;
    } else {
      const double outside = constraints_.outside(row - n_pairs_, value_[row]);
      const double slack = kAtBound * (kOfValue + std::abs(value_[row]));
      if (outside > slack) side = Side::kUpper;
      if (outside < -slack) side = Side::kLower;
    }
    if (side == Side::kNone) continue;
    const double along = inverse_hessian(row);
    if (!(along > 0.0)) continue;
    add(row, side, along);
    any = true;
  }
  return any;
}

/// From a minimiser of the QP by steps, each to the first row in the way.
void Polish::go_on(Plan& plan, const Deadline& deadline) noexcept {
  int corrections = 0;
  while (true) {
    const double decrease = -0.5 * (gradient_.cwiseProduct(step_).sum() + gradient_N_.dot(step_N_));
    const Block block = first_block();
    if (block.alpha > 0.0 && !move(plan, block.alpha)) break;
    consider(plan);
    if (block.row >= 0) {
      double along = inverse_hessian(block.row);
      // the step itself shows how little holds the row where it is
      if (decrease > 0.0) along = std::max(along, block.rate * block.rate / (2.0 * decrease));
      if (!(along > 0.0)) break;
      add(block.row, block.side, along);
    } else if (!release(plan) && (plan.violation <= kMet || ++corrections > kMaxCorrections)) {
      break;
    }
    if (is_over(deadline) || !solve()) break;
  }
}

/// How far the step can be gone, and the row that ends it; −1: none.
Polish::Block Polish::first_block() const noexcept {
  Block block{-1, Side::kLower, 1.0, 0.0};
  for (int row = 0; row < row_count(); ++row) {
    if (side_[row] != Side::kNone) continue;
    const double rate = along(row, step_, step_N_);
    const auto limit = [&](double distance, double speed, Side side) {
      if (!(speed > 0.0) || distance >= block.alpha * speed) return;
      const int k = stage(row);
      if (k < sizes_.N) {
        const Eigen::Map<const VectorXd> a(normal(row), step_.rows());
        // a held row says the same
        if (speed <= kHeld * a.cwiseAbs().dot(step_.col(k).cwiseAbs())) return;
      }
      block = {row, side, std::max(0.0, distance) / speed, rate};
    };
    if (is_pair(row)) {
      limit(value_[row], -rate, Side::kLower);
    } else {
      const qp::QpRows::Row& constraint = constraints_[row - n_pairs_];
      limit(value_[row] - constraint.lower, -rate, Side::kLower);
      limit(constraint.upper - value_[row], rate, Side::kUpper);
    }
  }
  return block;
}

/// Goes α of the step; false, and nothing changes, where the plan would be worse for it.
bool Polish::move(Plan& plan, double alpha) noexcept {
  const double cost = plan.cost;
  const bool was_met = plan.violation <= kRecoverable;
  u_before_ = plan.u;
  plan.u += alpha * step_.bottomRows(sizes_.n_u);
  roll(plan);
  if (!was_met || (plan.violation <= kRecoverable && plan.cost <= (1.0 + kRounding) * cost))
    return true;
  plan.u = u_before_;
  roll(plan);
  return false;
}

/// At the minimiser with the active rows held: lets one pair pass into its other mode, or drops
/// rows. False where nothing is to be gained.
bool Polish::release(const Plan& plan) noexcept {
  const double enough = kGain * plan.cost;
  double by_dropping = enough;
  for (const int row : active_) {
    if (is_equality(row) || inwards(row) >= 0.0) continue;
    by_dropping =
        std::max(by_dropping, multiplier_[row] * multiplier_[row] * inverse_hessian_[row]);
  }
  const Flip flip = best_flip(by_dropping);
  if (flip.row >= 0) {
    const int k = flip.row / sizes_.n_lambda;
    if (modes_[k].exchange(flip.row % sizes_.n_lambda)) {
      drop(flip.row);
      take_modes(k);
      return true;
    }
  }
  return drop_held(enough);
}

bool Polish::drop_held(double enough) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < active_.size();) {
    const int row = active_[i];
    const double gain = multiplier_[row] * multiplier_[row] * inverse_hessian_[row];
    if (is_equality(row) || inwards(row) >= 0.0 || gain <= enough) {
      ++i;
      continue;
    }
    drop(row);
    any = true;
  }
  return any;
}

/// Of the pairs whose both sides are zero the one whose other mode would bring the most: ν, the
/// multiplier of the side that the mode fixes, is negative.
Polish::Flip Polish::best_flip(double enough) noexcept {
  const int n_x = sizes_.n_x, n_lambda = sizes_.n_lambda;
  Flip best{-1, enough};
  p_ = gradient_N_;  // of the cost-to-go, less what holds the active rows
  for (const int row : active_) {
    if (stage(row) == sizes_.N) add_normal(row, -multiplier_[row], total_, p_);
  }
  for (int k = sizes_.N - 1; k >= 0; --k) {
    total_.col(k) = gradient_.col(k);
    for (const int row : active_) {
      if (stage(row) == k) add_normal(row, -multiplier_[row], total_, total_N_);
    }
    for (const int row : active_) {
      if (!is_pair(row) || row / n_lambda != k) continue;
      const int pair = row % n_lambda;
      double nu = 0.0;
      for (int i = 0; i < n_x; ++i) nu += p_[i] * modes_[k].state_response(i, pair);
      for (const int other : active_) {
        if (is_pair(other) && other / n_lambda == k)
          nu -= multiplier_[other] * modes_[k].pair_response(other % n_lambda, pair);
      }
      const double own = modes_[k].pair_response(pair, pair);
      if (nu >= 0.0 || own == 0.0) continue;
      const double gain = nu * nu * inverse_hessian_[row] / (own * own);
      if (gain > best.gain) best = {row, gain};
    }
    p_next_ = total_.col(k).head(n_x);
    p_next_.noalias() += reduced_[k].A.transpose() * p_;
    p_.swap(p_next_);
  }
  return best;
}

}  // namespace c3rt::c3
