#include <algorithm>
#include <cmath>

#include "controller/c3/polish.hpp"
#include "controller/qp/bound.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::VectorXd;

constexpr int kMaxInteriorSteps = 25;
constexpr double kInteriorConverged = 1e-6;  // gap beside the cost, misses beside their terms
constexpr double kFirstSlack = 0.1;          // beside a row's terms, at least
constexpr double kToBoundary = 0.99;         // share of the way to the boundary
constexpr double kShort = 0.05;              // of the whole step
constexpr int kMaxShort = 3;                 // steps: then no plan has these modes
constexpr double kSmallestTerms = 1e-3;      // [unit of the row]

}  // namespace

/// To the minimiser with the present modes from anywhere: Mehrotra's predictor-corrector, then the
/// rows that it touches are held. False where it does not converge, as where the modes allow no
/// plan.
bool Polish::converge(Plan& plan, const Deadline& deadline) noexcept {
  drop_all();
  if (is_over(deadline) || !solve()) return false;
  plan.u += step_.bottomRows(sizes_.n_u);
  roll(plan);
  if (!hold_equalities()) return false;
  start_sides(plan);
  const auto n = static_cast<int>(sides_.size());
  int short_steps = 0;
  for (int round = 0; n > 0; ++round) {
    double gap = 0.0, miss = 0.0;
    for (int j = 0; j < n; ++j) {
      gap += s_[j] * y_[j];
      miss = std::max(miss, std::abs(distance(j) - s_[j]) / sides_[j].terms);
    }
    if (gap <= kInteriorConverged * plan.cost && miss <= kInteriorConverged) break;
    if (round == kMaxInteriorSteps || is_over(deadline)) return false;
    ++report_.qps;
    if (!interior_step() || !std::isfinite(plan.cost)) return false;
    const double alpha = longest_step(kToBoundary);
    if (alpha < kShort && ++short_steps > kMaxShort) return false;
    for (const int row : active_)
      multiplier_[row] -=
          alpha * weight_[row] * (value_[row] - target(row) + along(row, step_, step_N_));
    plan.u += alpha * step_.bottomRows(sizes_.n_u);
    roll(plan);
    s_.head(n) += alpha * ds_.head(n);
    y_.head(n) += alpha * dy_.head(n);
  }
  // how little holds a row is told without the others
  drop_all();
  if (is_over(deadline) || !solve()) return false;
  if (!hold_equalities()) return false;
  hold_touched(plan);
  return true;
}

/// False where one of them cannot be moved.
bool Polish::hold_equalities() noexcept {
  for (int row = n_pairs_; row < row_count(); ++row) {
    if (!is_equality(row)) continue;
    const double along = inverse_hessian(row);
    if (!(along > 0.0)) return false;
    add(row, Side::kLower, along);
  }
  return true;
}

double Polish::distance(int side) const noexcept {
  const Inequality& of = sides_[side];
  return of.sign * (value_[of.row] - of.bound);
}

/// All sides at the present plan. The gap is the plan's cost.
void Polish::start_sides(const Plan& plan) noexcept {
  sides_.clear();
  for (int row = 0; row < row_count(); ++row) {
    double terms = std::abs(value_[row]);
    if (const int k = stage(row); k < sizes_.N) {
      const Eigen::Map<const VectorXd> a(normal(row), xu_.rows());
      terms += a.cwiseAbs().dot(xu_.col(k).cwiseAbs());
    }
    const auto add_side = [&](double sign, double bound) {
      sides_.push_back({row, sign, bound, std::max(terms + std::abs(bound), kSmallestTerms)});
    };
    if (is_pair(row)) {
      add_side(1.0, 0.0);
      continue;
    }
    const qp::QpRows::Row& constraint = constraints_[row - n_pairs_];
    if (is_equality(row)) continue;
    if (constraint.lower > -qp::kInfinity) add_side(1.0, constraint.lower);
    if (constraint.upper < qp::kInfinity) add_side(-1.0, constraint.upper);
  }
  const auto n = static_cast<int>(sides_.size());
  for (int j = 0; j < n; ++j) {
    s_[j] = std::max(std::abs(distance(j)), kFirstSlack * sides_[j].terms);
    y_[j] = plan.cost / (n * s_[j]);
  }
}

/// A predictor and a corrector, into step_, ds_ and dy_.
bool Polish::interior_step() noexcept {
  const auto n = static_cast<int>(sides_.size());
  weight_.setZero();
  for (const int row : active_) weight_[row] = stiff_weight(row);
  double mu = 0.0;
  for (int j = 0; j < n; ++j) {
    weight_[sides_[j].row] += y_[j] / s_[j];
    mu += s_[j] * y_[j] / n;
  }
  penalties_.clear();
  for (int row = 0; row < row_count(); ++row) {
    if (weight_[row] != 0.0) penalise(row);
  }
  changed_ = sizes_.N;
  if (!riccati_.factor({hessian_.data(), 1}, costs_.Q_N, changed_, &penalties_)) return false;
  newton_step(0.0, false);
  const double alpha = longest_step(1.0);
  double mu_affine = 0.0;
  for (int j = 0; j < n; ++j) mu_affine += (s_[j] + alpha * ds_[j]) * (y_[j] + alpha * dy_[j]) / n;
  const double ratio = mu_affine / mu;
  newton_step(ratio * ratio * ratio * mu, true);
  return step_.allFinite() && step_N_.allFinite();
}

/// @param corrected  by the products of the predictor's ds and dy
void Polish::newton_step(double centre, bool corrected) noexcept {
  const auto n = static_cast<int>(sides_.size());
  start_total();
  for (int j = 0; j < n; ++j) {
    complementarity_[j] = s_[j] * y_[j] - centre + (corrected ? ds_[j] * dy_[j] : 0.0);
    const double miss = distance(j) - s_[j];
    add_normal(sides_[j].row,
               sides_[j].sign * ((complementarity_[j] + y_[j] * miss) / s_[j] - y_[j]), total_,
               total_N_);
  }
  riccati_.step(total_, total_N_, no_defect_, step_, step_N_);
  for (int j = 0; j < n; ++j) {
    ds_[j] = sides_[j].sign * along(sides_[j].row, step_, step_N_) + distance(j) - s_[j];
    dy_[j] = -(complementarity_[j] + y_[j] * ds_[j]) / s_[j];
  }
}

/// How far s and y stay positive.
double Polish::longest_step(double share) const noexcept {
  double alpha = 1.0;
  for (int j = 0; j < static_cast<int>(sides_.size()); ++j) {
    if (ds_[j] < 0.0) alpha = std::min(alpha, -share * s_[j] / ds_[j]);
    if (dy_[j] < 0.0) alpha = std::min(alpha, -share * y_[j] / dy_[j]);
  }
  return alpha;
}

/// Holds the rows whose multiplier is larger than their slack, in units of the cost and of the
/// row's terms.
void Polish::hold_touched(const Plan& plan) noexcept {
  for (int j = 0; j < static_cast<int>(sides_.size()); ++j) {
    const Inequality& side = sides_[j];
    if (s_[j] * plan.cost >= y_[j] * side.terms * side.terms) continue;
    const double along = inverse_hessian(side.row);
    if (!(along > 0.0)) continue;
    add(side.row, side.sign > 0.0 ? Side::kLower : Side::kUpper, along);
    multiplier_[side.row] = side.sign * y_[j];
  }
}

}  // namespace c3rt::c3
