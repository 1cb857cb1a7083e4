#include "controller/c3/dual_qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace c3rt::c3 {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// What is left of K_pp = 1 after the active constraints are taken out: below this, p depends on them.
constexpr double kDependent = 1e-11;

}  // namespace

DualQp::DualQp(Eigen::Index size)
    : mu(Eigen::VectorXd::Zero(size)),
      s(Eigen::VectorXd::Zero(size)),
      pinned(size, 0),
      active(size, 0),
      L(size, size),
      is_active_(size, 0),
      l_(size),
      r_(size),
      direction_(size) {}

void DualQp::start(const Eigen::VectorXd& t) noexcept {
  mu.setZero();
  s = t;
  std::fill(pinned.begin(), pinned.end(), char{0});
  std::fill(is_active_.begin(), is_active_.end(), char{0});
  n_active = 0;
  objective = 0.0;
}

void DualQp::copy_from(const DualQp& other) noexcept {
  mu = other.mu;
  s = other.s;
  std::copy(other.pinned.begin(), other.pinned.end(), pinned.begin());
  std::copy(other.is_active_.begin(), other.is_active_.end(), is_active_.begin());
  std::copy_n(other.active.begin(), other.n_active, active.begin());
  n_active = other.n_active;
  L.topLeftCorner(n_active, n_active) = other.L.topLeftCorner(n_active, n_active);
  objective = other.objective;
}

DualQp::Status DualQp::solve(const Eigen::MatrixXd& K, const Eigen::VectorXd& t, double tolerance,
                             double bound) noexcept {
  const int size = static_cast<int>(s.size());
  for (int iteration = 0; iteration < 20 * size; ++iteration) {
    int p = -1;
    double worst = tolerance;
    for (int i = 0; i < size; ++i) {
      if (is_active_[i]) continue;
      const double violation = pinned[i] ? std::abs(s[i]) : -s[i];
      if (violation > worst) {
        worst = violation;
        p = i;
      }
    }
    if (p < 0) {
      objective = -0.5 * t.dot(mu);
      return objective > bound ? Status::kAboveBound : Status::kSolved;
    }

    // move μ_p in the direction that brings s_p to zero, keeping the active s at zero; an active
    // multiplier that reaches zero on the way leaves the set
    const double sign = s[p] < 0.0 ? 1.0 : -1.0;
    while (true) {
      double curvature = K(p, p);
      for (int i = 0; i < n_active; ++i) {  // l = L⁻¹ K_Ap
        double value = K(active[i], p);
        for (int j = 0; j < i; ++j) value -= L(i, j) * l_[j];
        l_[i] = value / L(i, i);
        curvature -= l_[i] * l_[i];
      }
      r_.head(n_active) = l_.head(n_active);
      for (int i = n_active - 1; i >= 0; --i) {  // r = L⁻ᵀ l, by rows of L
        r_[i] /= L(i, i);
        for (int j = 0; j < i; ++j) r_[j] -= L(i, j) * r_[i];
      }
      const bool dependent = curvature <= kDependent * K(p, p) || K(p, p) <= 0.0;
      const double to_zero = dependent ? kInfinity : std::abs(s[p]) / curvature;
      double to_block = kInfinity;
      int blocking = -1;
      for (int i = 0; i < n_active; ++i) {
        if (pinned[active[i]] || !(sign * r_[i] > 0.0)) continue;
        const double length = std::max(mu[active[i]], 0.0) / (sign * r_[i]);
        if (length < to_block) {
          to_block = length;
          blocking = i;
        }
      }
      const double length = std::min(to_zero, to_block);
      if (length == kInfinity) return Status::kInfeasible;
      mu[p] += sign * length;
      for (int i = 0; i < n_active; ++i) mu[active[i]] -= sign * length * r_[i];
      if (!dependent) {
        direction_ = K.col(p);
        for (int i = 0; i < n_active; ++i) direction_.noalias() -= r_[i] * K.col(active[i]);
        s.noalias() += (sign * length) * direction_;
        for (int i = 0; i < n_active; ++i) s[active[i]] = 0.0;
      }
      if (to_zero <= to_block) {
        active[n_active] = p;
        append(std::sqrt(curvature));
        is_active_[p] = 1;
        s[p] = 0.0;
        break;
      }
      mu[active[blocking]] = 0.0;
      is_active_[active[blocking]] = 0;
      remove(blocking);
    }
    // the multipliers solve a relaxation (the active constraints alone): a lower bound already
    if (-0.5 * t.dot(mu) > bound) {
      objective = -0.5 * t.dot(mu);
      return Status::kAboveBound;
    }
  }
  return Status::kStuck;
}

void DualQp::refine(const Eigen::MatrixXd& K, const Eigen::VectorXd& t) noexcept {
  direction_ = t;
  direction_.noalias() += K * mu;
  for (int i = 0; i < n_active; ++i) r_[i] = -direction_[active[i]];
  const auto factor = L.topLeftCorner(n_active, n_active).triangularView<Eigen::Lower>();
  auto correction = r_.head(n_active);
  factor.solveInPlace(correction);
  factor.transpose().solveInPlace(correction);
  for (int i = 0; i < n_active; ++i) mu[active[i]] += r_[i];
  s = t;
  s.noalias() += K * mu;
  for (int i = 0; i < n_active; ++i) s[active[i]] = 0.0;
}

void DualQp::append(double diagonal) noexcept {
  for (int j = 0; j < n_active; ++j) L(n_active, j) = l_[j];
  L(n_active, n_active) = diagonal;
  ++n_active;
}

/// Takes row `position` out of L and restores the triangle by Givens rotations of the columns.
void DualQp::remove(int position) noexcept {
  for (int i = position; i + 1 < n_active; ++i) {
    active[i] = active[i + 1];
    for (int j = 0; j <= i + 1; ++j) L(i, j) = L(i + 1, j);
    const double a = L(i, i), b = L(i, i + 1);
    const double length = std::hypot(a, b);
    const double cosine = a / length, sine = b / length;
    L(i, i) = length;
    for (int row = i + 2; row < n_active; ++row) {
      const double left = L(row, i), right = L(row, i + 1);
      L(row, i) = cosine * left + sine * right;
      L(row, i + 1) = cosine * right - sine * left;
    }
  }
  --n_active;
}

}  // namespace c3rt::c3
