#include "controller/c3/polish.hpp"

#include <algorithm>
#include <cmath>

#include "controller/lcs/step.hpp"
#include "controller/qp/bound.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kStiffness = 1e7;     // of a penalty, relative to the problem against it
constexpr double kGain = 1e-5;         // of the cost: what is not worth another QP
constexpr double kAtBound = 1e-9;      // of a value
constexpr double kMet = 1e-7;          // violation of what counts as a plan
constexpr double kRecoverable = 1e-5;  // violation that the penalties take out again
constexpr int kMaxCorrections = 2;     // of rows that a penalty has not brought to their bounds
constexpr double kRounding = 1e-9;     // of a cost
constexpr double kHeld = 1e-6;         // a rate this small beside its terms is a held row's
constexpr double kOfLargest = 1e-3;    // of the largest force: what none is measured beside less
constexpr double kOfValue = 1e-3;      // the same of a bound [unit of the row]

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
  best_ = first_ = plan_;
  u_before_ = plan_.u;
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
  side_.assign(row_count(), Side::kNone);
  for (VectorXd* v : {&weight_, &multiplier_, &inverse_hessian_, &value_}) v->setZero(row_count());
}

void Polish::start(Horizon lcs, const Eigen::Ref<const VectorXd>& x0,
                   const Eigen::Ref<const MatrixXd>& x_desired,
                   const Eigen::Ref<const MatrixXd>& u) noexcept {
  lcs_ = lcs;
  x0_ = x0;
  x_desired_ = x_desired;
  report_ = {};
  report_.status = PolishStatus::kNoPlan;
  plan_.u = u;
  if (simulate(plan_)) judge(plan_);
  first_ = plan_;
  report_.cost_before = report_.cost;
}

void Polish::improve(const Eigen::Ref<const MatrixXd>& u, const Deadline& deadline) noexcept {
  if (u == first_.u) {
    plan_ = first_;
  } else {
    plan_.u = u;
    simulate(plan_);
  }
  report_.status = PolishStatus::kBest;
  descend(plan_, deadline);
  for (int k = 0; k < sizes_.N; ++k) {
    for (int j = 0; j < sizes_.n_lambda; ++j) {
      if (!modes_[k].has_force(j)) plan_.s(j, k) = 0.0;
    }
    // by the system itself, without the rounding of the modes' tables
    auto next = plan_.x.col(k + 1);
    next = lcs_[k].d;
    next.noalias() += lcs_[k].A * plan_.x.col(k);
    next.noalias() += lcs_[k].B * plan_.u.col(k);
    next.noalias() += lcs_[k].D * plan_.s.col(k);
  }
  if (plan_.violation <= kMet) judge(plan_);
  if (!std::isfinite(report_.cost)) report_.status = PolishStatus::kNoPlan;
}

/// The plan of its inputs, each LCP solved by Lemke's method. False where one is not solved: from
/// there on the modes are those of the stage before.
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
      if (k > 0) std::copy_n(force - n_lambda, n_lambda, force);
      if (k == 0) std::fill_n(force, n_lambda, char{0});
    }
    return false;
  }
  return plan.x.allFinite();
}

/// Keeps a plan with complementary forces, s = λ, if it meets the constraints and is the best.
void Polish::judge(const Plan& plan) noexcept {
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
  if (!(violation <= kMet) || !std::isfinite(cost) || !(cost < report_.cost)) return;
  report_.cost = cost;
  best_.x = plan.x;
  best_.s = plan.s;
  best_.u = plan.u;
}

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

/// Takes the modes of a plan, and rolls it out with them. They are corrected where they do not suit
/// x and u: forces that are not determined by these are left out.
void Polish::load(Plan& plan) noexcept {
  const int n_lambda = sizes_.n_lambda;
  for (const int row : active_) side_[row] = Side::kNone;
  active_.clear();
  plan.x.col(0) = x0_;
  largest_force_ = 0.0;
  for (int k = 0; k < sizes_.N; ++k) {
    char* force = plan.force.data() + k * n_lambda;
    bool is_as_before = k > 0 && lcs_.stride == 0;
    for (int j = 0; is_as_before && j < n_lambda; ++j)
      is_as_before = modes_[k - 1].has_force(j) == (force[j] != 0);
    if (is_as_before) {
      modes_[k] = modes_[k - 1];
    } else {
      modes_[k].start(lcs_[k]);
      modes_[k].set(force);
    }
    xu_.col(k).head(sizes_.n_x) = plan.x.col(k);
    xu_.col(k).tail(sizes_.n_u) = plan.u.col(k);
    for (int tries = 0; tries < 2 * n_lambda && !fit_modes(k, plan); ++tries) {
    }
    take_modes(k);
  }
  changed_ = sizes_.N;
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
  for (const int row : active_) {
    const bool last = stage(row) == sizes_.N;
    penalties_.add(stage(row), last ? constraints_[row - n_pairs_].coordinate : -1, normal(row),
                   weight_[row]);
  }
  if (changed_ >= 0 && !riccati_.factor({hessian_.data(), 1}, costs_.Q_N, changed_, &penalties_))
    return false;
  changed_ = -1;
  total_ = gradient_;
  total_N_ = gradient_N_;
  for (const int row : active_) {
    add_normal(row, weight_[row] * (value_[row] - target(row)) - multiplier_[row], total_,
               total_N_);
  }
  riccati_.step(total_, total_N_, no_defect_, step_, step_N_);
  for (const int row : active_) {
    multiplier_[row] -=
        weight_[row] * (value_[row] - target(row)) + weight_[row] * along(row, step_, step_N_);
  }
  return step_.allFinite() && step_N_.allFinite();
}

void Polish::add(int row, Side side, double inverse_hessian) noexcept {
  side_[row] = side;
  inverse_hessian_[row] = inverse_hessian;
  weight_[row] = kStiffness / inverse_hessian;
  multiplier_[row] = 0.0;
  active_.push_back(row);
  changed_ = std::max(changed_, stage(row));
}

void Polish::drop(int row) noexcept {
  side_[row] = Side::kNone;
  active_.erase(std::find(active_.begin(), active_.end(), row));
  changed_ = std::max(changed_, stage(row));
}

/// The multiplier, negative where the row holds back a cheaper plan.
double Polish::inwards(int row) const noexcept {
  return side_[row] == Side::kUpper ? -multiplier_[row] : multiplier_[row];
}

/// Holds what is not met, and what is at its bound.
void Polish::guess_active() noexcept {
  for (int row = 0; row < row_count(); ++row) {
    Side side = Side::kNone;
    if (is_pair(row)) {
      const int k = row / sizes_.n_lambda;
      if (value_[row] < 0.0 && value_[row] < -slack(k, row % sizes_.n_lambda)) side = Side::kLower;
    } else {
      const qp::QpRows::Row& constraint = constraints_[row - n_pairs_];
      const double value = value_[row], slack = kAtBound * (kOfValue + std::abs(value));
      if (value >= constraint.upper - slack) side = Side::kUpper;
      if (value <= constraint.lower + slack) side = Side::kLower;
    }
    if (side == Side::kNone) continue;
    const double along = inverse_hessian(row);
    if (along > 0.0) add(row, side, along);
  }
}

/// Of rows that were at their bounds from the start those that want to leave.
bool Polish::drop_wrong_guesses() noexcept {
  bool any = false;
  for (std::size_t i = 0; i < active_.size();) {
    const int row = active_[i];
    const bool outside =
        is_pair(row) || std::abs(constraints_.outside(row - n_pairs_, value_[row])) >
                            kAtBound * (kOfValue + std::abs(value_[row]));
    if (outside || is_equality(row) || inwards(row) >= 0.0) {
      ++i;
      continue;
    }
    drop(row);
    any = true;
  }
  return any;
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

void Polish::descend(Plan& plan, const Deadline& deadline) noexcept {
  const auto is_over = [&] {
    if (deadline.struck()) report_.status = PolishStatus::kDeadline;
    if (report_.qps >= max_qps_) report_.status = PolishStatus::kQpLimit;
    return report_.status != PolishStatus::kBest;
  };
  load(plan);
  roll(plan);
  if (is_over() || !solve()) return;
  guess_active();
  if (!active_.empty()) {
    if (is_over() || !solve()) return;
    if (drop_wrong_guesses() && (is_over() || !solve())) return;
  }
  int corrections = 0;
  while (true) {
    const double decrease = -0.5 * (gradient_.cwiseProduct(step_).sum() + gradient_N_.dot(step_N_));
    const Block block = first_block();
    if (block.alpha > 0.0 && !move(plan, block.alpha)) break;
    if (block.row >= 0) {
      double along = inverse_hessian(block.row);
      // the step itself shows how little holds the row where it is
      if (decrease > 0.0) along = std::max(along, block.rate * block.rate / (2.0 * decrease));
      if (!(along > 0.0)) break;
      add(block.row, block.side, along);
    } else if (!release(plan) && (plan.violation <= kMet || ++corrections > kMaxCorrections)) {
      break;
    }
    if (is_over() || !solve()) break;
  }
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
