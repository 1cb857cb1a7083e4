#include "controller/qp/interior_point_qp.hpp"

#include <algorithm>
#include <cmath>

#include "controller/qp/bound.hpp"

namespace c3rt::qp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxIterations = 60;
constexpr int kPatience = 5;        // corrections that find no fewer rows guessed wrongly
constexpr int kMaxCorrections = 8;  // of the multipliers of active rows
constexpr double kRemeasure = 2.0;  // change of rho after which these are measured anew
constexpr double kActiveStiffness =
    1e7;  // of the penalty of active rows, relative to the problem against them
constexpr double kMultipliersSettled =
    1e-13;  // estimated error beside the largest entry of its kind
constexpr double kAcceptableResidual = 1e-7;    // residuals; worse: not solved
constexpr double kMissedDynamics = 1e-9;        // the same for what the states miss the dynamics by
constexpr double kToBoundary = 0.995;           // share of the way to the boundary
constexpr double kMultipliersConverged = 1e-6;  // the same; worse: the active set is given up
constexpr double kGaps[] = {1e-3, 1e-7, 1e-10, 1e-13};  // complementarity where a guess is tried

}  // namespace

InteriorPointQp::InteriorPointQp(const Sizes& sizes)
    : direct_(make_direct_qp(sizes)), model_(sizes), active_(model_.rows()) {
  z_kept_.setZero(sizes.n_z(), sizes.N);
  x_N_kept_.setZero(sizes.n_x);
}

void InteriorPointQp::set_costs(const Costs& costs, const Constraints& constraints) {
  direct_->set_costs(costs, {});
  model_.set_costs(costs, constraints);
  const QpRows& rows = model_.rows();
  sides_.clear();
  active_.prepare();
  infeasibility_.prepare(model_);
  for (int i = 0; i < rows.all(); ++i) {
    const QpRows::Row& row = rows[i];
    if (row.lower == row.upper) continue;
    if (row.lower > -kInfinity) sides_.push_back({i, 1.0, row.lower});
    if (row.upper < kInfinity) sides_.push_back({i, -1.0, row.upper});
  }
  for (VectorXd* v : {&inverse_hessian_, &weight_, &multiplier_, &extra_, &multiplier_kept_}) {
    v->setZero(rows.all());
  }
  for (VectorXd* v : {&s_, &y_, &ds_, &dy_, &ds_affine_, &dy_affine_}) {
    v->setZero(static_cast<Eigen::Index>(sides_.size()));
  }
}

void InteriorPointQp::start(Horizon lcs, StageMatrices W, const VectorXd* lambda_0) noexcept {
  rho_measured_ = 0.0;
  direct_->start(lcs, W, lambda_0);
  model_.start(lcs, W, lambda_0);
  n_sides_ = 0;
  for (const Side& side : sides_) n_sides_ += side.row < model_.rows().count() ? 1 : 0;
  deactivate_all();
}

QpReport InteriorPointQp::solve(double rho, const Eigen::Ref<const VectorXd>& x0,
                                const Eigen::Ref<const MatrixXd>& x_desired,
                                const Eigen::Ref<const MatrixXd>& g, Eigen::Ref<MatrixXd> z,
                                Eigen::Ref<VectorXd> x_N) noexcept {
  if (model_.rows().count() == 0) return direct_->solve(rho, x0, x_desired, g, z, x_N);
  model_.set_linear_term(rho, x0, x_desired, g);
  iterations_ = 0;
  if (!(rho <= kRemeasure * rho_measured_ && rho_measured_ <= kRemeasure * rho)) {
    weight_.setZero();
    if (!model_.factor(weight_)) {
      return {QpStatus::kNotFactorable, 0, kInfinity, kInfinity};
    }
    model_.measure(inverse_hessian_);
    rho_measured_ = rho;
  }
  QpStatus status = QpStatus::kSolved;
  if (!find_active_set()) status = iterate();
  QpReport report = check(status);
  z = model_.z();
  x_N = model_.x_N();
  if (report.status == QpStatus::kNotConverged && infeasibility_.prove(model_, inverse_hessian_)) {
    report.status = QpStatus::kInfeasible;
  }
  if (report.status != QpStatus::kSolved) deactivate_all();
  return report;
}

void InteriorPointQp::deactivate_all() noexcept {
  active_.deactivate_all();
  multiplier_.setZero();
}

/// Solves with the active rows as equalities and the others left out: a stiff penalty holds each of
/// them at its bound, and its force is added to the row's multiplier [method of multipliers], until
/// no force is left.
bool InteriorPointQp::solve_equalities() noexcept {
  return factor_penalties() && multiplier_step() && iterate_multipliers();
}

/// Factors the problem with the penalties of the active rows.
bool InteriorPointQp::factor_penalties() noexcept {
  for (int i = 0; i < model_.rows().count(); ++i) {
    weight_[i] = active_[i] == Bound::kNone ? 0.0 : kActiveStiffness / inverse_hessian_[i];
    if (active_[i] == Bound::kNone) multiplier_[i] = 0.0;
  }
  ++iterations_;
  return model_.factor(weight_);
}

/// One iteration of the multipliers.
bool InteriorPointQp::multiplier_step() noexcept {
  const int n = model_.rows().count();
  model_.differentiate(multiplier_);
  for (int i = 0; i < n; ++i) {
    extra_[i] = weight_[i] == 0.0 ? 0.0 : weight_[i] * (model_.value()[i] - active_.target(i));
  }
  model_.newton(extra_);
  // by the step, not by the point it leads to, whose rounding the penalty would magnify
  for (int i = 0; i < n; ++i) {
    if (weight_[i] != 0.0) multiplier_[i] -= extra_[i] + weight_[i] * model_.change(i);
  }
  model_.move(1.0);
  return std::isfinite(model_.relative_step());
}

/// The first iteration after `factor_penalties`, as precise as the penalties are stiff.
void InteriorPointQp::multiplier_step_from_rest() noexcept {
  const int n = model_.rows().count();
  for (int i = 0; i < n; ++i) {
    extra_[i] = -multiplier_[i];
    if (weight_[i] != 0.0)
      extra_[i] += weight_[i] * (model_.value_at_rest()[i] - active_.target(i));
  }
  model_.newton_from_rest(extra_);
  for (int i = 0; i < n; ++i) {
    if (weight_[i] != 0.0) multiplier_[i] = -extra_[i] - weight_[i] * model_.change(i);
  }
}

/// More iterations, after a first one.
bool InteriorPointQp::iterate_multipliers() noexcept {
  double change = model_.relative_step();
  for (int round = 0; round < kMaxCorrections; ++round) {
    const double previous = change;
    if (!multiplier_step()) return false;
    change = model_.relative_step();
    if (change * change <= kMultipliersSettled * previous || change > 0.5 * previous) break;
  }
  if (!(change <= kMultipliersConverged)) return false;
  // rows that contradict each other end in a compromise
  for (int i = 0; i < model_.rows().count(); ++i) {
    if (active_[i] == Bound::kNone) continue;
    const double off = std::abs(model_.value()[i] - active_.target(i));
    if (off > ActiveSet::slack(model_.value()[i])) return false;
  }
  return true;
}

/// Solves with the active rows as equalities and corrects the set, until nothing is to be changed
/// [primal-dual active set]: true then. One iteration of the multipliers, as precise as the
/// penalties are stiff, is enough to correct a guess; they converge where it stands.
bool InteriorPointQp::find_active_set() noexcept {
  int fewest = std::numeric_limits<int>::max(), patience = kPatience;
  while (patience > 0) {
    if (!factor_penalties()) return false;
    multiplier_step_from_rest();
    ActiveSet::Corrections found = active_.correct(model_.value(), multiplier_, inverse_hessian_);
    if (found.all() == 0) {
      if (!iterate_multipliers()) return false;
      found = active_.correct(model_.value(), multiplier_, inverse_hessian_);
      if (found.all() == 0) return true;
    }
    // deactivating alone comes to an end, activating may go in circles
    if (found.violated > 0 && found.all() >= fewest) {
      --patience;
    } else if (found.all() < fewest) {
      fewest = found.all();
      patience = kPatience;
    }
  }
  return false;
}

/// Mehrotra's predictor-corrector from the point where only equalities are active.
QpStatus InteriorPointQp::iterate() noexcept {
  deactivate_all();
  if (!solve_equalities()) {
    collect_multipliers();
  }
  start_sides();
  std::size_t next_gap = 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    double gap = 0.0, off = 0.0;
    for (int j = 0; j < n_sides_; ++j) {
      const Side& side = sides_[j];
      gap = std::max(gap, s_[j] * y_[j]);
      off = std::max(off, std::abs(side.sign * (model_.value()[side.row] - side.bound) - s_[j]) /
                              std::sqrt(inverse_hessian_[side.row]));
    }
    collect_multipliers();
    model_.differentiate(multiplier_);
    const double unit = violation_ * violation_;
    if (off <= kGaps[next_gap] * violation_ && gap <= kGaps[next_gap] * unit) {
      z_kept_ = model_.z();
      x_N_kept_ = model_.x_N();
      multiplier_kept_ = multiplier_;
      guess_active_set();
      if (find_active_set()) return QpStatus::kSolved;
      model_.go_to(z_kept_, x_N_kept_);
      multiplier_ = multiplier_kept_;
      model_.differentiate(multiplier_);
      if (++next_gap == std::size(kGaps)) return QpStatus::kSolved;
    }
    if (off > 1e-8 * violation_ && Infeasibility::is_proven(model_, multiplier_))
      return QpStatus::kInfeasible;
    ++iterations_;
    if (!newton_step()) return QpStatus::kNotFactorable;
  }
  collect_multipliers();
  model_.differentiate(multiplier_);
  return QpStatus::kNotConverged;
}

/// Guess from the iterate: a row is active where its multiplier is larger than its slack.
void InteriorPointQp::guess_active_set() noexcept {
  active_.deactivate_all();
  for (int j = 0; j < n_sides_; ++j) {
    if (y_[j] * inverse_hessian_[sides_[j].row] <= s_[j]) continue;
    active_.set(sides_[j].row, sides_[j].sign > 0.0 ? Bound::kLower : Bound::kUpper);
  }
}

/// In units of √cost a slack is s/√inverse_hessian and a multiplier y √inverse_hessian; the largest
/// violation in these units says how large both should be.
void InteriorPointQp::start_sides() noexcept {
  violation_ = 0.0;
  const auto distance = [this](const Side& side) {
    return side.sign * (model_.value()[side.row] - side.bound);
  };
  for (int j = 0; j < n_sides_; ++j) {
    const double unit = std::sqrt(inverse_hessian_[sides_[j].row]);
    violation_ = std::max(violation_, -distance(sides_[j]) / unit);
  }
  if (violation_ == 0.0) violation_ = 1.0;
  for (int j = 0; j < n_sides_; ++j) {
    const double unit = std::sqrt(inverse_hessian_[sides_[j].row]);
    s_[j] = std::max(std::abs(distance(sides_[j])), violation_ * unit);
    y_[j] = violation_ * violation_ / s_[j];
  }
}

void InteriorPointQp::collect_multipliers() noexcept {
  for (int i = 0; i < model_.rows().count(); ++i) {
    if (active_[i] != Bound::kEquality) multiplier_[i] = 0.0;
  }
  for (int j = 0; j < n_sides_; ++j) multiplier_[sides_[j].row] += sides_[j].sign * y_[j];
}

/// One predictor and corrector from the gradient kept in the model.
bool InteriorPointQp::newton_step() noexcept {
  const int n = model_.rows().count();
  for (int i = 0; i < n; ++i) {
    weight_[i] = active_[i] == Bound::kEquality ? kActiveStiffness / inverse_hessian_[i] : 0.0;
  }
  double mu = 0.0;
  for (int j = 0; j < n_sides_; ++j) {
    weight_[sides_[j].row] += y_[j] / s_[j];
    mu += s_[j] * y_[j];
  }
  mu /= std::max(n_sides_, 1);
  if (!model_.factor(weight_)) return false;

  const auto solve_for = [&](double centre, bool corrected) {
    for (int i = 0; i < n; ++i) {
      extra_[i] = active_[i] == Bound::kEquality
                      ? weight_[i] * (model_.value()[i] - active_.target(i))
                      : 0.0;
    }
    const auto complementarity = [&](int j) {
      return s_[j] * y_[j] - centre + (corrected ? ds_affine_[j] * dy_affine_[j] : 0.0);
    };
    const auto off = [&](int j) {
      const Side& side = sides_[j];
      return side.sign * (model_.value()[side.row] - side.bound) - s_[j];
    };
    for (int j = 0; j < n_sides_; ++j) {
      extra_[sides_[j].row] += sides_[j].sign * (complementarity(j) + y_[j] * off(j)) / s_[j];
    }
    model_.newton(extra_);
    for (int j = 0; j < n_sides_; ++j) {
      ds_[j] = sides_[j].sign * model_.change(sides_[j].row) + off(j);
      dy_[j] = -(complementarity(j) + y_[j] * ds_[j]) / s_[j];
    }
  };
  const auto longest = [&](double share) {
    double alpha = 1.0;
    for (int j = 0; j < n_sides_; ++j) {
      if (ds_[j] < 0.0) alpha = std::min(alpha, -share * s_[j] / ds_[j]);
      if (dy_[j] < 0.0) alpha = std::min(alpha, -share * y_[j] / dy_[j]);
    }
    return alpha;
  };
  solve_for(0.0, false);
  const double alpha_affine = longest(1.0);
  double mu_affine = 0.0;
  for (int j = 0; j < n_sides_; ++j) {
    mu_affine += (s_[j] + alpha_affine * ds_[j]) * (y_[j] + alpha_affine * dy_[j]);
  }
  mu_affine /= std::max(n_sides_, 1);
  ds_affine_ = ds_;
  dy_affine_ = dy_;
  const double ratio = mu_affine / mu;
  solve_for(ratio * ratio * ratio * mu, true);

  const double alpha = longest(kToBoundary);
  for (int i = 0; i < n; ++i) {
    if (active_[i] != Bound::kEquality) continue;
    multiplier_[i] -=
        alpha * weight_[i] * (model_.value()[i] - active_.target(i) + model_.change(i));
  }
  model_.move(alpha);
  for (int j = 0; j < n_sides_; ++j) {
    s_[j] += alpha * ds_[j];
    y_[j] += alpha * dy_[j];
  }
  return true;
}

/// The optimality conditions at the point reached, each beside its terms.
QpReport InteriorPointQp::check(QpStatus status) noexcept {
  const int n = model_.rows().count();
  double dual = model_.stationarity(multiplier_);
  double largest_force = 0.0;
  for (int i = 0; i < n; ++i) {
    largest_force =
        std::max(largest_force, std::abs(multiplier_[i]) * std::sqrt(inverse_hessian_[i]));
  }
  for (int i = 0; i < n; ++i) {
    const QpRows::Row& row = model_.rows()[i];
    if (multiplier_[i] == 0.0 || row.lower == row.upper) continue;
    const double value = model_.value()[i];
    const double inside = multiplier_[i] > 0.0 ? value - row.lower : row.upper - value;
    const double lost = std::abs(multiplier_[i]) * std::max(0.0, inside);
    dual = std::max(dual, lost / std::max(largest_force * largest_force,
                                          std::abs(multiplier_[i]) * std::abs(value)));
  }
  const double inconsistency = model_.inconsistency(), violation = model_.violation();
  const bool met = violation <= kAcceptableResidual && inconsistency <= kMissedDynamics &&
                   dual <= kAcceptableResidual;
  if (status == QpStatus::kSolved && !met) status = QpStatus::kNotConverged;
  if (!model_.z().allFinite() || !model_.x_N().allFinite()) status = QpStatus::kNotFactorable;
  return {status, iterations_, std::max(violation, inconsistency), dual};
}

std::unique_ptr<QpStep> make_interior_point_qp(const Sizes& sizes) {
  return std::make_unique<InteriorPointQp>(sizes);
}

}  // namespace c3rt::qp
