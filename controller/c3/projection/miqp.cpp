#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Cholesky>

#include "controller/c3/consensus.hpp"
#include "controller/c3/projection.hpp"
#include "controller/c3/projection/pair_rows.hpp"
#include "controller/c3/solver.hpp"
#include "controller/qp/bound.hpp"
#include "controller/qp/branch_and_bound.hpp"
#include "controller/qp/node_qp.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using qp::kInfinity;
using qp::NodeQp;

constexpr double kComplementary = 1e-10;   // the same, for the smaller side of a pair
constexpr double kRoundingOfSide = 1e-14;  // the same, for that side after the last polish
constexpr double kSameObjective = 1e-12;   // a bound this close to the best cannot improve it

/// Branch and bound, depth first. All that counts are the 2 n_lambda functionals of δ that the LCP
/// is made of, [λ; y] = J δ + [0; c]. With U = L Lᵀ and δ = v + L⁻ᵀ f the QP of a node is a NodeQp
/// on the columns of L⁻¹ Jᵀ, which are computed once per system. Each is divided by its length, so
/// that s² / 2 is the least that bringing that functional to zero alone costs, whatever its unit.
class MiqpProjection final : public Projection {
 public:
  MiqpProjection(const Sizes& sizes, int max_nodes)
      : sizes_(sizes),
        max_nodes_(max_nodes),
        n_(sizes.n_lambda),
        rows_(sizes),
        best_(sizes.n_z(), 2 * n_),
        difference_(sizes.n_z()),
        weighted_(sizes.n_z()) {
    // one state per level: a level pins one more pair
    nodes_.reserve(n_ + 1);
    for (int i = 0; i <= n_; ++i) nodes_.emplace_back(sizes.n_z(), 2 * n_);
  }

  void set_weights(const Costs& costs) override {
    U_ = costs.U;
    diagonal_ = U_.isDiagonal(0.0);
    L_inverse_ = definite(U_).llt().matrixL().solve(MatrixXd::Identity(U_.rows(), U_.cols()));
  }

  void start(const lcs::Lcs& lcs) noexcept override {
    rows_.assign(lcs);
    if (diagonal_) {
      rows_.C.noalias() = L_inverse_.diagonal().asDiagonal() * rows_.J.transpose();
    } else {
      rows_.C.noalias() = L_inverse_ * rows_.J.transpose();
    }
    rows_.normalise();
  }

  ProjectionReport project(const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> delta,
                           const Deadline& deadline) noexcept override {
    delta = v;
    if (!v.allFinite()) return {ProjectionStatus::kNotFinite, 0, 0.0};
    rows_.evaluate(v);
    magnitude_ = rows_.largest;
    best_objective_ = kInfinity;
    stuck_ = false;
    deadline_ = &deadline;

    nodes_[0].start(rows_.t);
    qp::BranchAndBound<MiqpProjection> search(*this, n_, max_nodes_);
    search.run(0.0);
    const long n_nodes = search.nodes();
    if (best_objective_ == kInfinity) {
      const bool whole = !search.limit() && !stuck_;
      return {whole ? ProjectionStatus::kEmpty : ProjectionStatus::kNotFound, n_nodes, 0.0};
    }
    const double objective = finish(delta);
    if (!rows_.holds(v, delta)) {  // weights or units too far apart for the digits of δ
      delta = v;
      return {ProjectionStatus::kInaccurate, n_nodes, 0.0};
    }
    const bool deadline_struck = search.limit() == qp::SearchLimit::kDeadline;
    const auto status = deadline_struck            ? ProjectionStatus::kDeadline
                        : search.limit() || stuck_ ? ProjectionStatus::kNodeLimit
                                                   : ProjectionStatus::kSolved;
    return {status, n_nodes, objective};
  }

 private:
  friend class qp::BranchAndBound<MiqpProjection>;

  /// A bound this close to the best cannot improve it.
  double prune_above() const noexcept { return best_objective_ * (1.0 - kSameObjective); }
  bool struck() const noexcept { return deadline_->struck(); }
  const NodeQp& relaxation(int level) const noexcept { return nodes_[level]; }
  void leave_open(double) const noexcept {}  // the search knows what ended it

  qp::Expansion expand(int level, double) noexcept {
    NodeQp& node = nodes_[level];
    const double bound = prune_above();
    const NodeQp::Status status = node.solve(rows_.C, rows_.t, kFeasible * magnitude_, bound);
    if (status == NodeQp::Status::kStuck) stuck_ = true;  // its subtree is lost, not searched
    if (status != NodeQp::Status::kSolved || node.objective() >= bound) return {bound, -1};
    const int pair = qp::most_violated_pair(node, n_, kComplementary * magnitude_).pair;
    if (pair < 0) {
      best_.copy_from(node);
      best_objective_ = node.objective();
    }
    return {node.objective(), pair};
  }

  /// Whatever else happens, s_side = 0 costs at least s² / 2 more than this node.
  double side_bound(int level, int side) const noexcept {
    const double s = nodes_[level].s()[side];
    return nodes_[level].objective() + 0.5 * s * s;
  }

  void descend(int level, int side) noexcept {
    nodes_[level + 1].copy_from(nodes_[level]);
    nodes_[level + 1].pin(side);
  }

  /// δ of the best node: the sides that the search accepted as zero are pinned to it, the active
  /// constraints solved once more to take out what the path there has accumulated.
  double finish(Eigen::Ref<VectorXd> delta) noexcept {
    NodeQp& node = nodes_[0];
    node.copy_from(best_);
    for (int i = 0; i < n_; ++i) node.pin(node.s()[i] <= node.s()[n_ + i] ? i : n_ + i);
    const NodeQp::Status status =
        node.solve(rows_.C, rows_.t, kRoundingOfSide * magnitude_, kInfinity);
    if (status == NodeQp::Status::kSolved) best_.copy_from(node);
    best_.refine(rows_.C, rows_.t);
    if (diagonal_) {
      difference_ = L_inverse_.diagonal().cwiseProduct(best_.f());
    } else {
      difference_.noalias() = L_inverse_.transpose() * best_.f();
    }
    delta += difference_;
    for (int i = 0; i < n_; ++i) {
      double& force = delta[sizes_.n_x + i];
      force = best_.s()[i] <= best_.s()[n_ + i] ? 0.0 : std::max(force, 0.0);
    }
    weighted_.noalias() = U_ * difference_;
    return difference_.dot(weighted_);
  }

  Sizes sizes_;
  int max_nodes_;
  int n_;  // pairs
  bool diagonal_ = false;
  MatrixXd U_;
  MatrixXd L_inverse_;  // of U = L Lᵀ
  PairRows rows_;       // with T = L⁻ᵀ
  double magnitude_ = 0.0;
  std::vector<NodeQp> nodes_;
  NodeQp best_;
  double best_objective_ = kInfinity;  // halved
  bool stuck_ = false;
  const Deadline* deadline_ = nullptr;
  VectorXd difference_, weighted_;
};

}  // namespace

std::unique_ptr<Projection> make_miqp_projection(const Sizes& sizes, int max_nodes) {
  return std::make_unique<MiqpProjection>(sizes, max_nodes);
}

namespace {

std::string why_no_point_of_tree(const ProjectionReport& report, const Settings& settings,
                                 const Costs&, const lcs::Lcs&) {
  if (report.status == ProjectionStatus::kEmpty)
    return "the set that the projection is onto is empty";
  if (report.status == ProjectionStatus::kNotFound && report.nodes >= settings.max_nodes) {
    return "the projection's search ended at max_nodes = " + std::to_string(settings.max_nodes) +
           " before it found a point";
  }
  return "";
}

}  // namespace

const ProjectionType& miqp_projection() {
  static const ProjectionType type{ProjectionKind::kMiqp,
                                   "miqp",
                                   "MIQP",
                                   true,
                                   true,
                                   [](const Sizes& sizes, const Settings& settings) {
                                     return make_miqp_projection(sizes, settings.max_nodes);
                                   },
                                   make_consensus,
                                   nullptr,
                                   nullptr,
                                   {},
                                   why_no_point_of_tree,
                                   true};
  return type;
}

}  // namespace c3rt::c3
