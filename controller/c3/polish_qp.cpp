#include <algorithm>
#include <cmath>

#include "controller/c3/polish.hpp"
#include "controller/qp/bound.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kStiffness = 1e7;   // of a penalty, relative to the problem against it
constexpr int kMaxPivots = 50;       // of a table, then it is made anew
constexpr double kOfLargest = 1e-3;  // of the largest force: what none is measured beside less

}  // namespace

bool Polish::is_equality(int row) const noexcept {
  return !is_pair(row) && constraints_[row - n_pairs_].lower == constraints_[row - n_pairs_].upper;
}

int Polish::stage(int row) const noexcept {
  return is_pair(row) ? row / sizes_.n_lambda : constraints_[row - n_pairs_].stage;
}

/// How a row depends on [x; u]; means nothing at stage N.
const double* Polish::normal(int row) const noexcept {
  return is_pair(row) ? modes_[row / sizes_.n_lambda].normal(row % sizes_.n_lambda)
                      : constraint_normals_.col(row - n_pairs_).data();
}

double Polish::along(int row, const MatrixXd& xu, const VectorXd& x_N) const noexcept {
  const int k = stage(row);
  if (k == sizes_.N) return x_N[constraints_[row - n_pairs_].coordinate];
  return Eigen::Map<const VectorXd>(normal(row), xu.rows()).dot(xu.col(k));
}

void Polish::add_normal(int row, double factor, MatrixXd& xu, VectorXd& x_N) const noexcept {
  const int k = stage(row);
  if (k == sizes_.N) {
    x_N[constraints_[row - n_pairs_].coordinate] += factor;
  } else {
    xu.col(k) += factor * Eigen::Map<const VectorXd>(normal(row), xu.rows());
  }
}

double Polish::target(int row) const noexcept {
  if (is_pair(row)) return 0.0;
  const qp::QpRows::Row& constraint = constraints_[row - n_pairs_];
  return side_[row] == Side::kUpper ? constraint.upper : constraint.lower;
}

double Polish::inverse_hessian(int row) noexcept {
  const int k = stage(row);
  if (k < sizes_.N) {
    return riccati_.inverse_hessian_along(
        k, Eigen::Map<const VectorXd>(normal(row), sizes_.n_x + sizes_.n_u));
  }
  p_.setZero();
  p_[constraints_[row - n_pairs_].coordinate] = 1.0;
  return riccati_.inverse_hessian_along(k, p_);
}

/// How far below zero a side may be: a gap beside what it is added up from, a force also beside the
/// largest one.
double Polish::slack(int k, int pair) const noexcept {
  const auto xu = xu_.col(k);
  const Eigen::Map<const VectorXd> a(modes_[k].normal(pair), xu.size());
  double terms = std::abs(modes_[k].offset(pair)) + a.cwiseAbs().dot(xu.cwiseAbs());
  const double force = kOfLargest * largest_force_;
  if (modes_[k].has_force(pair)) return kAtBound * (terms + force);
  const lcs::Lcs& lcs = lcs_[k];
  terms += std::abs(lcs.c[pair]) + lcs.F.row(pair).cwiseAbs().maxCoeff() * force;
  for (int i = 0; i < sizes_.n_x; ++i) terms += std::abs(lcs.E(pair, i) * xu[i]);
  for (int i = 0; i < sizes_.n_u; ++i) terms += std::abs(lcs.H(pair, i) * xu[sizes_.n_x + i]);
  return kAtBound * terms;
}

void Polish::note_forces(int k, const Plan& plan) noexcept {
  for (int j = 0; j < sizes_.n_lambda; ++j) {
    if (modes_[k].has_force(j)) largest_force_ = std::max(largest_force_, std::abs(plan.s(j, k)));
  }
}

/// Takes the modes of a plan, and rolls it out with them. With `fit` they are corrected where
/// they do not suit x and u. Forces that are not determined by these are left out.
void Polish::load(Plan& plan, bool fit) noexcept {
  const int n_lambda = sizes_.n_lambda;
  drop_all();
  plan.x.col(0) = x0_;
  largest_force_ = 0.0;
  for (int k = 0; k < sizes_.N; ++k) {
    char* force = plan.force.data() + k * n_lambda;
    load_modes(k, force);
    xu_.col(k).head(sizes_.n_x) = plan.x.col(k);
    xu_.col(k).tail(sizes_.n_u) = plan.u.col(k);
    for (int tries = 0; fit && tries < 2 * n_lambda && !fit_modes(k, plan); ++tries) {
    }
    take_modes(k);
  }
  is_loaded_ = true;
  roll(plan);
}

/// From the table that takes the fewest pivots: the stage's own of before, that of the stage before
/// or a new one.
void Polish::load_modes(int k, const char* force) noexcept {
  const auto differing = [&](const FixedModes& modes) {
    int count = 0;
    for (int j = 0; j < sizes_.n_lambda; ++j)
      count += modes.has_force(j) != (force[j] != 0) ? 1 : 0;
    return modes.pivots() + count > kMaxPivots ? sizes_.n_lambda + 1 : count;
  };
  int fewest = 0;
  for (int j = 0; j < sizes_.n_lambda; ++j) fewest += force[j] != 0 ? 1 : 0;
  const int own = is_loaded_ ? differing(modes_[k]) : sizes_.n_lambda + 1;
  const int before = k > 0 && lcs_.stride == 0 ? differing(modes_[k - 1]) : sizes_.n_lambda + 1;
  if (before < std::min(own, fewest)) {
    modes_[k] = modes_[k - 1];
  } else if (own >= fewest) {
    modes_[k].start(lcs_[k]);
  }
  // which forces are left out, where not all are determined, must not depend on where it began
  if (modes_[k].set(force)) return;
  modes_[k].start(lcs_[k]);
  modes_[k].set(force);
}

/// The stage's sides and next state. If one is not met, its pair is fixed the other way: false.
bool Polish::fit_modes(int k, Plan& plan) noexcept {
  modes_[k].evaluate(xu_.col(k), plan.s.col(k), plan.x.col(k + 1));
  note_forces(k, plan);
  int worst = -1;
  for (int j = 0; j < sizes_.n_lambda; ++j) {
    if (plan.s(j, k) < -slack(k, j) && (worst < 0 || plan.s(j, k) < plan.s(worst, k))) worst = j;
  }
  return worst < 0 || !modes_[k].exchange(worst);
}

/// What follows from the modes of a stage.
void Polish::take_modes(int k) noexcept {
  const int n_x = sizes_.n_x, n_lambda = sizes_.n_lambda;
  modes_[k].dynamics(reduced_[k]);
  modes_changed_ = true;
  changed_ = std::max(changed_, k);
  for (int i = 0; i < constraints_.count(); ++i) {
    const qp::QpRows::Row& row = constraints_[i];
    if (row.stage != k) continue;
    auto a = constraint_normals_.col(i);
    a.setZero();
    constraint_offsets_[i] = 0.0;
    const auto add_entry = [&](int coordinate, double factor) {
      if (coordinate < n_x) {
        a[coordinate] += factor;
      } else if (coordinate >= n_x + n_lambda) {
        a[coordinate - n_lambda] += factor;
      } else if (const int j = coordinate - n_x; modes_[k].has_force(j)) {
        a += factor * Eigen::Map<const VectorXd>(modes_[k].normal(j), a.size());
        constraint_offsets_[i] += factor * modes_[k].offset(j);
      }
    };
    if (row.coordinate >= 0) {
      add_entry(row.coordinate, 1.0);
    } else {
      const double* full = constraints_.normal(i);
      for (int c = 0; c < sizes_.n_z(); ++c) {
        if (full[c] != 0.0) add_entry(c, full[c]);
      }
    }
  }
}

/// The plan of its inputs and the present modes.
void Polish::roll(Plan& plan) noexcept {
  plan.x.col(0) = x0_;
  largest_force_ = 0.0;
  for (int k = 0; k < sizes_.N; ++k) {
    xu_.col(k).head(sizes_.n_x) = plan.x.col(k);
    xu_.col(k).tail(sizes_.n_u) = plan.u.col(k);
    modes_[k].evaluate(xu_.col(k), plan.s.col(k), plan.x.col(k + 1));
    note_forces(k, plan);
  }
  measure(plan);
}

/// Cost, its gradient (halved) and the values of the rows.
void Polish::measure(Plan& plan) noexcept {
  const int n_x = sizes_.n_x, n_u = sizes_.n_u, N = sizes_.N;
  plan.cost = plan.violation = 0.0;
  for (int k = 0; k < N; ++k) {
    auto g = gradient_.col(k);
    p_ = plan.x.col(k) - x_desired_.col(k);
    g.head(n_x).noalias() = costs_.Q[k] * p_;
    g.tail(n_u).noalias() = costs_.R[k] * plan.u.col(k);
    plan.cost += p_.dot(g.head(n_x)) + plan.u.col(k).dot(g.tail(n_u));
  }
  p_ = plan.x.col(N) - x_desired_.col(N);
  gradient_N_.noalias() = costs_.Q_N * p_;
  plan.cost += p_.dot(gradient_N_);
  p_ = plan.x.col(N);
  for (int row = 0; row < row_count(); ++row) {
    if (is_pair(row)) {
      const int k = row / sizes_.n_lambda, j = row % sizes_.n_lambda;
      value_[row] = plan.s(j, k);
      if (value_[row] >= 0.0) continue;
      const double terms = slack(k, j) / kAtBound;
      if (-value_[row] > kAtBound * terms)
        plan.violation = std::max(plan.violation, -value_[row] / terms);
      continue;
    }
    const int i = row - n_pairs_;
    value_[row] = constraint_offsets_[i] + along(row, xu_, p_);
    plan.violation = std::max(plan.violation, std::abs(constraints_.outside(i, value_[row])) /
                                                  (kOfValue + std::abs(value_[row])));
  }
  if (!std::isfinite(plan.cost)) plan.violation = qp::kInfinity;
}

/// The step to the minimiser with the active rows held: a stiff penalty holds each of them, and its
/// force is added to the row's multiplier [method of multipliers].
bool Polish::solve() noexcept {
  ++report_.qps;
  if (modes_changed_) riccati_.start({reduced_.data(), 1}, false);
  modes_changed_ = false;
  penalties_.clear();
  for (const int row : active_) penalise(row);
  if (changed_ >= 0 && !riccati_.factor({hessian_.data(), 1}, costs_.Q_N, changed_, &penalties_))
    return false;
  changed_ = -1;
  start_total();
  riccati_.step(total_, total_N_, no_defect_, step_, step_N_);
  for (const int row : active_) {
    multiplier_[row] -=
        weight_[row] * (value_[row] - target(row)) + weight_[row] * along(row, step_, step_N_);
  }
  return step_.allFinite() && step_N_.allFinite();
}

/// Its weight, into the terms that the recursion factors.
void Polish::penalise(int row) noexcept {
  const bool last = stage(row) == sizes_.N;
  penalties_.add(stage(row), last ? constraints_[row - n_pairs_].coordinate : -1, normal(row),
                 weight_[row]);
}

/// The gradient with what holds the active rows, into total_.
void Polish::start_total() noexcept {
  total_ = gradient_;
  total_N_ = gradient_N_;
  for (const int row : active_) {
    add_normal(row, weight_[row] * (value_[row] - target(row)) - multiplier_[row], total_,
               total_N_);
  }
}

double Polish::stiff_weight(int row) const noexcept { return kStiffness / inverse_hessian_[row]; }

void Polish::add(int row, Side side, double inverse_hessian) noexcept {
  side_[row] = side;
  inverse_hessian_[row] = inverse_hessian;
  weight_[row] = stiff_weight(row);
  multiplier_[row] = 0.0;
  active_.push_back(row);
  changed_ = std::max(changed_, stage(row));
}

void Polish::drop(int row) noexcept {
  side_[row] = Side::kNone;
  active_.erase(std::find(active_.begin(), active_.end(), row));
  changed_ = std::max(changed_, stage(row));
}

void Polish::drop_all() noexcept {
  for (const int row : active_) side_[row] = Side::kNone;
  active_.clear();
  changed_ = sizes_.N;
}

/// The multiplier, negative where the row holds back a cheaper plan.
double Polish::inwards(int row) const noexcept {
  return side_[row] == Side::kUpper ? -multiplier_[row] : multiplier_[row];
}

}  // namespace c3rt::c3
