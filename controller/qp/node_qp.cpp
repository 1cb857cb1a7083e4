#include "controller/qp/node_qp.hpp"

#include <algorithm>
#include <cmath>

#include "controller/qp/bound.hpp"

namespace c3rt::qp {
namespace {

// A column of length 1 with less than this left beside the active ones depends on them.
constexpr double kDependent = 1e-9;
// A coefficient this small beside the largest is rounding, not an active constraint in the way.
constexpr double kNoCoefficient = 1e-11;
// Where p depends on the active ones, their rounding shows in s_p times its coefficients: this part
// of `tolerance` is granted for each unit of them.
constexpr double kAmplified = 1e-2;

}  // namespace

NodeQp::NodeQp(Eigen::Index n_variables, Eigen::Index n_constraints)
    : f_(Eigen::VectorXd::Zero(n_variables)),
      s_(Eigen::VectorXd::Zero(n_constraints)),
      mu_(Eigen::VectorXd::Zero(n_constraints)),
      pinned_(n_constraints, 0),
      is_active_(n_constraints, 0),
      active_(n_constraints, 0),
      Q_(n_variables, n_constraints),
      L_(n_constraints, n_constraints),
      l_(n_constraints),
      again_(n_constraints),
      r_(n_constraints),
      z_(n_variables) {}

void NodeQp::start(const Eigen::VectorXd& t) noexcept {
  f_.setZero();
  s_ = t;
  mu_.setZero();
  std::fill(pinned_.begin(), pinned_.end(), char{0});
  std::fill(is_active_.begin(), is_active_.end(), char{0});
  n_active_ = 0;
}

void NodeQp::copy_from(const NodeQp& other) noexcept {
  f_ = other.f_;
  s_ = other.s_;
  mu_ = other.mu_;
  std::copy(other.pinned_.begin(), other.pinned_.end(), pinned_.begin());
  std::copy(other.is_active_.begin(), other.is_active_.end(), is_active_.begin());
  std::copy_n(other.active_.begin(), other.n_active_, active_.begin());
  n_active_ = other.n_active_;
  // whole columns are one block of memory
  std::copy_n(other.Q_.data(), n_active_ * Q_.rows(), Q_.data());
  std::copy_n(other.L_.data(), n_active_ * L_.rows(), L_.data());
}

NodeQp::Status NodeQp::solve(const Eigen::MatrixXd& C, const Eigen::VectorXd& t, double tolerance,
                             double bound) noexcept {
  const int size = static_cast<int>(s_.size());
  for (int iteration = 0; iteration <= 20 * size; ++iteration) {
    int p = -1;
    double worst = tolerance;
    for (int i = 0; i < size; ++i) {
      if (is_active_[i]) continue;
      const double violation = pinned_[i] ? std::abs(s_[i]) : -s_[i];
      if (violation > worst) {
        worst = violation;
        p = i;
      }
    }
    if (p < 0) return objective() > bound ? Status::kAboveBound : Status::kSolved;

    // move μ_p in the direction that brings s_p to zero, keeping the active s at zero; an active
    // multiplier that reaches zero on the way leaves the set
    const double sign = s_[p] < 0.0 ? 1.0 : -1.0;
    while (true) {
      const double rest = split(C, p);
      const bool dependent = rest <= kDependent;
      const double to_zero = dependent ? kInfinity : std::abs(s_[p]) / (rest * rest);
      double to_block = kInfinity, largest = 0.0, sum = 0.0;
      for (int i = 0; i < n_active_; ++i) {
        largest = std::max(largest, std::abs(r_[i]));
        sum += std::abs(r_[i]);
      }
      if (dependent && std::abs(s_[p]) <= tolerance * (1.0 + kAmplified * sum)) {
        s_[p] = 0.0;
        break;
      }
      int blocking = -1;
      for (int i = 0; i < n_active_; ++i) {
        if (pinned_[active_[i]] || sign * r_[i] <= kNoCoefficient * largest) continue;
        const double length = std::max(mu_[active_[i]], 0.0) / (sign * r_[i]);
        if (length < to_block) {
          to_block = length;
          blocking = i;
        }
      }
      const double length = std::min(to_zero, to_block);
      if (length == kInfinity) {
        contradicted_ = p;
        return Status::kInfeasible;
      }
      mu_[p] += sign * length;
      for (int i = 0; i < n_active_; ++i) mu_[active_[i]] -= sign * length * r_[i];
      if (!dependent) {
        f_ += (sign * length) * z_;
        update_s(C, t);
      }
      if (to_zero <= to_block) {
        append(p, rest);
        break;
      }
      mu_[active_[blocking]] = 0.0;
      remove(blocking);
    }
    // f solves a relaxation (the active constraints alone): a lower bound already
    if (objective() > bound) return Status::kAboveBound;
  }
  return Status::kStuck;
}

void NodeQp::refine(const Eigen::MatrixXd& C, const Eigen::VectorXd& t) noexcept {
  for (int i = 0; i < n_active_; ++i) {  // L l = −s_A, and f ← f + Q l
    double value = -t[active_[i]] - C.col(active_[i]).dot(f_);
    for (int j = 0; j < i; ++j) value -= L_(i, j) * l_[j];
    l_[i] = value / L_(i, i);
  }
  f_.noalias() += Q_.leftCols(n_active_) * l_.head(n_active_);
  update_s(C, t);
}

void NodeQp::restart(const Eigen::MatrixXd& C, const Eigen::VectorXd& t) noexcept {
  mu_.setZero();
  while (true) {
    auto mu = l_.head(n_active_);
    for (int i = 0; i < n_active_; ++i) mu[i] = t[active_[i]];
    multipliers(mu);
    int leaving = -1;
    double lowest = 0.0;
    for (int i = 0; i < n_active_; ++i) {
      if (pinned_[active_[i]] || mu[i] >= lowest) continue;
      lowest = mu[i];
      leaving = i;
    }
    if (leaving < 0) break;
    remove(leaving);
  }
  f_.setZero();
  for (int i = 0; i < n_active_; ++i) {
    mu_[active_[i]] = l_[i];
    f_ += l_[i] * C.col(active_[i]);
  }
  refine(C, t);
}

void NodeQp::multipliers(Eigen::Ref<Eigen::VectorXd> t) const noexcept {
  t = -t;
  const auto L = L_.topLeftCorner(n_active_, n_active_).triangularView<Eigen::Lower>();
  L.solveInPlace(t);
  L.transpose().solveInPlace(t);
}

Eigen::VectorXd NodeQp::against(Eigen::VectorXd s) const {
  s = -s;
  L_.topLeftCorner(n_active_, n_active_).triangularView<Eigen::Lower>().solveInPlace(s);
  return Q_.leftCols(n_active_) * s;
}

NodeQp::Contradiction NodeQp::contradiction() const {
  const double s = s_[contradicted_];
  return {contradicted_,      s < 0.0 ? 1.0 : -1.0,
          std::abs(s),        1.0 + r_.head(n_active_).lpNorm<1>(),
          r_.head(n_active_), z_};
}

double NodeQp::split(const Eigen::MatrixXd& C, int p) noexcept {
  z_ = C.col(p);
  if (n_active_ == 0) return z_.norm();
  const auto Q = Q_.leftCols(n_active_);
  auto l = l_.head(n_active_), again = again_.head(n_active_);
  l.noalias() = Q.transpose() * z_;
  z_.noalias() -= Q * l;
  again.noalias() = Q.transpose() * z_;  // what is left is small: orthogonal only if done twice
  z_.noalias() -= Q * again;
  l += again;
  r_.head(n_active_) = l;
  for (int i = n_active_ - 1; i >= 0; --i) {  // Lᵀ r = l, by rows of L
    r_[i] /= L_(i, i);
    for (int j = 0; j < i; ++j) r_[j] -= L_(i, j) * r_[i];
  }
  return z_.norm();
}

void NodeQp::append(int p, double length) noexcept {
  Q_.col(n_active_) = z_ / length;
  for (int j = 0; j < n_active_; ++j) L_(n_active_, j) = l_[j];
  L_(n_active_, n_active_) = length;
  active_[n_active_++] = p;
  is_active_[p] = 1;
  s_[p] = 0.0;
}

/// Takes row `position` out of L and restores the triangle by rotations of its columns and Q's.
void NodeQp::remove(int position) noexcept {
  is_active_[active_[position]] = 0;
  for (int i = position; i + 1 < n_active_; ++i) {
    active_[i] = active_[i + 1];
    for (int j = 0; j <= i + 1; ++j) L_(i, j) = L_(i + 1, j);
    const double length = std::hypot(L_(i, i), L_(i, i + 1));
    const double cosine = L_(i, i) / length, sine = L_(i, i + 1) / length;
    L_(i, i) = length;
    for (int row = i + 2; row < n_active_; ++row) {
      const double left = L_(row, i), right = L_(row, i + 1);
      L_(row, i) = cosine * left + sine * right;
      L_(row, i + 1) = cosine * right - sine * left;
    }
    for (Eigen::Index row = 0; row < Q_.rows(); ++row) {
      const double left = Q_(row, i), right = Q_(row, i + 1);
      Q_(row, i) = cosine * left + sine * right;
      Q_(row, i + 1) = cosine * right - sine * left;
    }
  }
  --n_active_;
}

void NodeQp::update_s(const Eigen::MatrixXd& C, const Eigen::VectorXd& t) noexcept {
  s_ = t;
  s_.noalias() += C.transpose() * f_;
  for (int i = 0; i < n_active_; ++i) s_[active_[i]] = 0.0;
}

}  // namespace c3rt::qp
