#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>

#include "controller/c3/dual_qp.hpp"
#include "controller/c3/projection.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kZeroWeight = 1e-8;     // of the largest, for directions without weight
constexpr double kSingular = 1e-12;      // of the largest: a weight that counts as none
constexpr double kFeasible = 1e-11;      // of the largest normalised |s| at v
constexpr double kComplementary = 1e-10; // the same, for the smaller side of a pair
constexpr double kRounding = 1e-14;      // the same, for that side after the last polish
constexpr double kSameObjective = 1e-12; // a bound this close to the best cannot improve it

/// Branch and bound, depth first. All of the geometry is in the 2 n_lambda functionals of δ that the
/// LCP is made of, s = [λ; y] = C δ + [0; c]: with e = δ − v the QP of a node is a DualQp on
/// K = C U⁻¹ Cᵀ, which is computed once per system. Each s is divided by √K_ii, so that s² / 2 is the
/// least that bringing it to zero alone costs, whatever its unit.
class MiqpProjection final : public Projection {
 public:
  MiqpProjection(const Sizes& sizes, int max_nodes)
      : sizes_(sizes),
        max_nodes_(max_nodes),
        n_(sizes.n_lambda),
        U_inverse_(sizes.n_z(), sizes.n_z()),
        C_(2 * n_, sizes.n_z()),
        W_(sizes.n_z(), 2 * n_),
        K_(2 * n_, 2 * n_),
        scale_(2 * n_),
        t_(2 * n_),
        best_(2 * n_),
        multipliers_(2 * n_),
        difference_(sizes.n_z()),
        weighted_(sizes.n_z()) {
    // one state per level: a level pins one more pair
    nodes_.reserve(n_ + 1);
    for (int i = 0; i <= n_; ++i) nodes_.emplace_back(2 * n_);
    C_.setZero();
    C_.block(0, sizes.n_x, n_, n_).setIdentity();
  }

  void set_weight(const MatrixXd& U) override {
    U_ = U;
    MatrixXd definite = U;
    const double largest = std::max(U.diagonal().maxCoeff(), 1e-300);
    diagonal_ = U.isDiagonal(0.0);
    if (diagonal_) {
      for (Eigen::Index i = 0; i < U.rows(); ++i) {
        if (U(i, i) <= kSingular * largest) definite(i, i) = kZeroWeight * largest;
      }
      U_inverse_ = definite.diagonal().cwiseInverse().asDiagonal();
    } else {
      Eigen::LDLT<MatrixXd> factor(definite);
      if (factor.vectorD().minCoeff() <= kSingular * largest) {
        definite.diagonal().array() += kZeroWeight * largest;
        factor.compute(definite);
      }
      U_inverse_ = factor.solve(MatrixXd::Identity(U.rows(), U.cols()));
    }
  }

  void start(const lcs::Lcs& lcs) noexcept override {
    c_ = &lcs.c;
    C_.block(n_, 0, n_, sizes_.n_x) = lcs.E;
    C_.block(n_, sizes_.n_x, n_, n_) = lcs.F;
    C_.block(n_, sizes_.n_x + n_, n_, sizes_.n_u) = lcs.H;
    if (diagonal_) {
      W_.noalias() = U_inverse_.diagonal().asDiagonal() * C_.transpose();
    } else {
      W_.noalias() = U_inverse_ * C_.transpose();
    }
    K_.noalias() = C_ * W_;
    for (int i = 0; i < 2 * n_; ++i) {
      scale_[i] = K_(i, i) > 0.0 ? 1.0 / std::sqrt(K_(i, i)) : 1.0;
    }
    for (int j = 0; j < 2 * n_; ++j) {
      K_.col(j).array() *= scale_.array() * scale_[j];
      if (K_(j, j) > 0.0) K_(j, j) = 1.0;
    }
  }

  ProjectionReport project(const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> delta,
                           const Deadline& deadline) noexcept override {
    delta = v;
    if (!v.allFinite()) return {ProjectionStatus::kNotFinite, 0, 0.0};
    t_.noalias() = C_ * v;
    t_.tail(n_) += *c_;
    t_.array() *= scale_.array();
    magnitude_ = t_.cwiseAbs().maxCoeff();
    best_objective_ = kInfinity;
    n_nodes_ = 0;
    stuck_ = false;
    stopped_by_ = ProjectionStatus::kSolved;
    deadline_ = &deadline;

    nodes_[0].start(t_);
    explore(0);
    if (best_objective_ == kInfinity) return {ProjectionStatus::kNone, n_nodes_, 0.0};
    if (stuck_ && stopped_by_ == ProjectionStatus::kSolved) {
      stopped_by_ = ProjectionStatus::kNodeLimit;
    }
    return {stopped_by_, n_nodes_, finish(delta)};
  }

 private:
  /// Solves the QP of nodes_[level] and searches below it.
  void explore(int level) noexcept {
    if (stopped_by_ != ProjectionStatus::kSolved) return;
    if (n_nodes_ >= max_nodes_) {
      stopped_by_ = ProjectionStatus::kNodeLimit;
      return;
    }
    if (deadline_->struck()) {
      stopped_by_ = ProjectionStatus::kDeadline;
      return;
    }
    ++n_nodes_;
    DualQp& node = nodes_[level];
    const double bound = best_objective_ * (1.0 - kSameObjective);
    const DualQp::Status status = node.solve(K_, t_, kFeasible * magnitude_, bound);
    if (status == DualQp::Status::kStuck) stuck_ = true;  // its subtree is lost, not searched
    if (status != DualQp::Status::kSolved || node.objective >= bound) return;

    // the pair whose cheaper side costs most to bring to zero
    int pair = -1;
    double largest = kComplementary * magnitude_;
    for (int i = 0; i < n_; ++i) {
      const double smaller = std::min(node.s[i], node.s[n_ + i]);
      if (smaller > largest) {
        largest = smaller;
        pair = i;
      }
    }
    if (pair < 0) {
      best_.copy_from(node);
      best_objective_ = node.objective;
      return;
    }
    const int force = pair, gap = n_ + pair;
    const int first = node.s[force] <= node.s[gap] ? force : gap;
    for (const int side : {first, first == force ? gap : force}) {
      // whatever else happens, s_side = 0 costs at least s² / 2 more than this node
      const double at_least = node.objective + 0.5 * node.s[side] * node.s[side] * K_(side, side);
      if (at_least >= best_objective_ * (1.0 - kSameObjective)) continue;
      nodes_[level + 1].copy_from(node);
      nodes_[level + 1].pinned[side] = 1;
      explore(level + 1);
    }
  }

  /// δ of the best node: the sides that the search accepted as zero are pinned to it, the active
  /// constraints solved once more to take out what the path there has accumulated.
  double finish(Eigen::Ref<VectorXd> delta) noexcept {
    DualQp& node = nodes_[0];
    node.copy_from(best_);
    for (int i = 0; i < n_; ++i) node.pinned[node.s[i] <= node.s[n_ + i] ? i : n_ + i] = 1;
    const DualQp::Status status = node.solve(K_, t_, kRounding * magnitude_, kInfinity);
    if (status == DualQp::Status::kSolved) best_.copy_from(node);
    best_.refine(K_, t_);
    multipliers_ = scale_.cwiseProduct(best_.mu);
    difference_.noalias() = W_ * multipliers_;
    delta += difference_;
    for (int i = 0; i < n_; ++i) {
      double& force = delta[sizes_.n_x + i];
      force = best_.s[i] <= best_.s[n_ + i] ? 0.0 : std::max(force, 0.0);
    }
    weighted_.noalias() = U_ * difference_;
    return difference_.dot(weighted_);
  }

  Sizes sizes_;
  int max_nodes_;
  int n_;  // pairs
  bool diagonal_ = false;
  MatrixXd U_, U_inverse_;
  MatrixXd C_;            // [0 I 0; E F H] (2 n_lambda × n_z)
  MatrixXd W_;            // U⁻¹ Cᵀ
  MatrixXd K_;            // C U⁻¹ Cᵀ, normalised
  VectorXd scale_;        // 1/√K_ii before it was
  const VectorXd* c_ = nullptr;

  VectorXd t_;            // s at v
  double magnitude_ = 0.0;
  std::vector<DualQp> nodes_;
  DualQp best_;
  double best_objective_ = kInfinity;  // halved
  VectorXd multipliers_;               // of the best node, in the units of C
  long n_nodes_ = 0;
  ProjectionStatus stopped_by_ = ProjectionStatus::kSolved;
  bool stuck_ = false;
  const Deadline* deadline_ = nullptr;
  VectorXd difference_, weighted_;
};

}  // namespace

std::unique_ptr<Projection> make_miqp_projection(const Sizes& sizes, int max_nodes) {
  return std::make_unique<MiqpProjection>(sizes, max_nodes);
}

}  // namespace c3rt::c3
