#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Householder>

#include "controller/c3/consensus.hpp"
#include "controller/c3/projection.hpp"
#include "controller/c3/projection/pair_rows.hpp"
#include "controller/c3/projection/quadric.hpp"
#include "controller/c3/solver.hpp"
#include "controller/qp/bound.hpp"
#include "controller/qp/node_qp.hpp"
#include "controller/qp/requirements.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using qp::kInfinity;
using qp::NodeQp;

constexpr double kInSet = 1e-12;  // the same, for a copy that needs no further turn

/// In coordinates δ = v + T h in which both the norm of U is ‖h‖ and the constraint λᵀ y = 0 is
/// q_0 + gᵀ h + hᵀ diag(curvature) h = 0, one turn is
///
///   f ← argmin ‖f‖² + ρ ‖f − h + ω‖²   subject to λ ≥ 0, y ≥ 0                    (a NodeQp)
///   h ← argmin ‖h − f − ω‖²            subject to λᵀ y = 0                        (a quadric)
///   ω ← (ω + f − h)/ρ_s,   ρ ← ρ_s ρ
///
/// started at h = 0, ω = 0.
class AdmmProjection final : public Projection {
 public:
  AdmmProjection(const Sizes& sizes, const AdmmProjectionSettings& settings)
      : settings_(settings),
        n_(sizes.n_lambda),
        M_(sizes.n_z(), sizes.n_z()),
        eigen_(sizes.n_z()),
        V_(sizes.n_z(), sizes.n_z()),
        T_(sizes.n_z(), sizes.n_z()),
        tau_(sizes.n_z()),
        off_diagonal_(sizes.n_z() - 1),
        rows_(sizes),
        turned_(2 * n_),
        qp_(sizes.n_z(), 2 * n_) {
    for (VectorXd* each : {&g_, &curvature_, &f_, &h_, &a_, &omega_, &best_, &difference_}) {
      each->setZero(sizes.n_z());
    }
    s_.setZero(2 * n_);
  }

  void set_weights(const Costs& costs) override {
    U_ = costs.U;
    L_inverse_ = definite(U_).llt().matrixL().solve(MatrixXd::Identity(U_.rows(), U_.cols()));
  }

  void start(const lcs::Lcs& lcs) noexcept override {
    rows_.assign(lcs);
    // λᵀ y is the sum of the products of two rows each
    rows_.C.noalias() = L_inverse_ * rows_.J.transpose();
    const auto C_lambda = rows_.C.leftCols(n_), C_y = rows_.C.rightCols(n_);
    M_.noalias() = C_lambda * C_y.transpose();
    for (Eigen::Index i = 0; i < M_.rows(); ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) M_(i, j) = M_(j, i) = 0.5 * (M_(i, j) + M_(j, i));
    }
    diagonalise();
    rows_.C.noalias() = T_.transpose() * rows_.J.transpose();
    rows_.normalise();
  }

  ProjectionReport project(const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> delta,
                           const Deadline& deadline) noexcept override {
    delta = v;
    if (!v.allFinite()) return {ProjectionStatus::kNotFinite, 0, 0.0};
    if (eigen_.info() != Eigen::Success) return {ProjectionStatus::kInaccurate, 0, 0.0};
    rows_.evaluate(v);
    const double magnitude = rows_.largest;
    linearise();
    h_.setZero();
    omega_.setZero();
    best_violation_ = kInfinity;
    ProjectionStatus status = ProjectionStatus::kSolved, without = ProjectionStatus::kNotFound;
    double rho = settings_.rho;
    long turns = 0;
    while (turns < settings_.iterations) {
      if (deadline.struck()) {
        status = ProjectionStatus::kDeadline;
        break;
      }
      ++turns;
      f_ = (rho / (1.0 + rho)) * (h_ - omega_);
      turned_ = rows_.t;
      turned_.noalias() += rows_.C.transpose() * f_;
      qp_.start(turned_);
      const NodeQp::Status qp = qp_.solve(rows_.C, turned_, kFeasible * magnitude, kInfinity);
      if (qp == NodeQp::Status::kInfeasible) without = ProjectionStatus::kEmpty;
      if (qp != NodeQp::Status::kSolved) break;
      f_ += qp_.f();
      a_ = f_ + omega_;
      nearest_on_quadric(q_0_, g_, curvature_, a_, h_);
      s_ = rows_.t;
      s_.noalias() += rows_.C.transpose() * h_;
      const bool done = consider(qp_.s(), f_) <= kInSet * magnitude;
      consider(s_, h_);
      if (done) break;
      omega_ = (omega_ + f_ - h_) / settings_.rho_scale;
      rho *= settings_.rho_scale;
    }
    if (best_violation_ == kInfinity) return {without, turns, 0.0};
    difference_.noalias() = T_ * best_;
    delta += difference_;
    if (!delta.allFinite()) {
      delta = v;
      return {ProjectionStatus::kInaccurate, turns, 0.0};
    }
    a_.noalias() = U_ * difference_;
    return {status, turns, difference_.dot(a_)};
  }

 private:
  /// curvature ← the eigenvalues of M, T ← L⁻ᵀ times its eigenvectors. By hand to the tridiagonal
  /// matrix and back: Eigen's way from M itself takes from the heap.
  void diagonalise() noexcept {
    const Eigen::Index size = M_.rows();
    for (Eigen::Index k = 0; k + 1 < size; ++k) {
      const Eigen::Index rest = size - k - 1;
      // M ← P M P with P = I − τ r rᵀ, r(0) = 1 [Golub, Van Loan: Matrix computations, 8.3.1]
      auto r = M_.col(k).tail(rest);
      r.makeHouseholderInPlace(tau_[k], off_diagonal_[k]);
      r[0] = 1.0;
      auto block = M_.bottomRightCorner(rest, rest);
      auto w = a_.head(rest);
      w.noalias() = block * r;
      w *= tau_[k];
      w -= (0.5 * tau_[k] * w.dot(r)) * r;
      for (Eigen::Index j = 0; j < rest; ++j) block.col(j) -= w[j] * r + r[j] * w;
    }
    h_ = M_.diagonal();
    eigen_.computeFromTridiagonal(h_, off_diagonal_);
    curvature_ = eigen_.eigenvalues();
    V_ = eigen_.eigenvectors();
    for (Eigen::Index k = size - 2; k >= 0; --k) {
      const auto r = M_.col(k).tail(size - k - 1);
      auto block = V_.bottomRows(size - k - 1);
      for (Eigen::Index j = 0; j < size; ++j) block.col(j) -= (tau_[k] * r.dot(block.col(j))) * r;
    }
    T_.noalias() = L_inverse_.transpose() * V_;
  }

  /// λᵀ y at v and its gradient in h.
  void linearise() noexcept {
    q_0_ = 0.0;
    g_.setZero();
    for (int i = 0; i < n_; ++i) {
      const double lambda = rows_.t[i] / rows_.scale[i];
      const bool constant = rows_.scale[n_ + i] == 0.0;
      const double y = constant ? (*rows_.c)[i] : rows_.t[n_ + i] / rows_.scale[n_ + i];
      q_0_ += lambda * y;
      g_ += (y / rows_.scale[i]) * rows_.C.col(i);
      if (!constant) g_ += (lambda / rows_.scale[n_ + i]) * rows_.C.col(n_ + i);
    }
  }

  /// Keeps the copy that is nearest to the set, of all turns. Returns how near `copy` is.
  double consider(const VectorXd& s, const VectorXd& copy) noexcept {
    if (n_ == 0) {
      best_violation_ = 0.0;
      best_ = copy;
      return 0.0;
    }
    const double violation = s.head(n_).cwiseMin(s.tail(n_)).cwiseAbs().maxCoeff();
    if (violation < best_violation_) {
      best_violation_ = violation;
      best_ = copy;
    }
    return violation;
  }

  AdmmProjectionSettings settings_;
  int n_;                   // pairs
  MatrixXd U_, L_inverse_;  // U = L Lᵀ
  MatrixXd M_;              // L⁻¹ P L⁻ᵀ with λᵀ y = δᵀ P δ + …
  Eigen::SelfAdjointEigenSolver<MatrixXd> eigen_;  // of M
  MatrixXd V_, T_;                                 // its eigenvectors, L⁻ᵀ V
  VectorXd tau_, off_diagonal_;
  PairRows rows_;
  VectorXd turned_;  // rows_.t at the target of the QP
  NodeQp qp_;
  double q_0_ = 0.0;
  VectorXd g_, curvature_;
  VectorXd f_, h_, a_, omega_, s_, best_, difference_;
  double best_violation_ = kInfinity;
};

}  // namespace

std::unique_ptr<Projection> make_admm_projection(const Sizes& sizes,
                                                 const AdmmProjectionSettings& settings) {
  return std::make_unique<AdmmProjection>(sizes, settings);
}

namespace {

void check_admm(const Settings& settings) {
  const AdmmProjectionSettings& admm = settings.admm;
  for (const auto& [name, value] : {std::pair{"Settings.admm.rho", admm.rho},
                                    std::pair{"Settings.admm.rho_scale", admm.rho_scale}}) {
    if (!(std::isfinite(value) && value > 0.0)) {
      qp::refuse(name, "a positive number", std::to_string(value));
    }
  }
  if (admm.iterations < 1) {
    qp::refuse("Settings.admm.iterations", "1 or more", std::to_string(admm.iterations));
  }
}

}  // namespace

const ProjectionType& admm_projection() {
  static const ProjectionType type{ProjectionKind::kAdmm,
                                   "admm",
                                   "ADMM",
                                   true,
                                   true,
                                   [](const Sizes& sizes, const Settings& settings) {
                                     return make_admm_projection(sizes, settings.admm);
                                   },
                                   make_consensus,
                                   nullptr,
                                   check_admm};
  return type;
}

}  // namespace c3rt::c3
