#include "controller/horizon/search.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "controller/base/words.hpp"
#include "controller/horizon/modes.hpp"
#include "controller/qp/branch_and_bound.hpp"
#include "controller/qp/node_qp.hpp"

namespace c3rt::horizon {
namespace {

using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = 1e-9;        // curvature that the cost gets, of its diagonal
constexpr double kFeasible = 1e-10;      // of the largest normalised |s| at the free minimiser
constexpr double kComplementary = 1e-8;  // the same, for the smaller side of a pair
constexpr double kCostRounding = 1e-10;  // a cost this small beside the free one's is rounding
constexpr int kMaxCentres = 8;           // of one node

class Search {
 public:
  Search(const Problem& problem, const SearchSettings& settings, const std::optional<Plan>& known,
         const c3::Deadline& deadline)
      : problem_(problem),
        settings_(settings),
        deadline_(deadline),
        condensed_(condense(problem)),
        least_(condensed_, kEpsilon),
        n_(condensed_.n_pairs),
        scratch_(condensed_.H.rows(), condensed_.J.rows()) {
    result_.max_nodes = settings.max_nodes;
    least_.place(VectorXd::Zero(condensed_.g.size()), node(0).centre);
    magnitude_ = node(0).centre.t.lpNorm<Eigen::Infinity>();
    if (known) {
      Plan plan = *known;
      evaluate(problem, plan);
      if (residual(problem, plan) <= kMet) {
        least_.place(least_.normalised(inputs_of(problem, condensed_, plan)), node(0).centre);
        accept(plan);
      }
    }
  }

  SearchResult run() {
    qp::NodeQp& root = node(0).qp;
    root.start(node(0).centre.t);
    for (const int row : condensed_.equalities) root.pin(row);
    qp::BranchAndBound<Search> tree(*this, n_, settings_.max_nodes);
    tree.run(0.0);  // costs are sums of squares
    result_.nodes = tree.nodes();
    // what was left unsearched is not cheaper than `open_`, what was pruned than the pruning bound
    result_.lower_bound = std::min(open_, prune_above());
    if (result_.plan) {
      const double above = std::max(0.0, result_.plan->objective - result_.lower_bound);
      result_.gap = above > 0.0 ? above / cost_scale() : 0.0;
    }
    if (result_.plan && result_.gap <= settings_.relative_gap * (1.0 + 1e-9)) {
      result_.status = SearchStatus::kOptimal;
    } else if (tree.limit()) {
      result_.status = tree.limit() == qp::SearchLimit::kNodes ? SearchStatus::kNodeLimit
                                                               : SearchStatus::kDeadline;
    } else if (!result_.plan && open_ == kInfinity) {
      result_.status = SearchStatus::kInfeasible;
    }
    return std::move(result_);
  }

 private:
  friend class qp::BranchAndBound<Search>;

  struct Node {
    qp::NodeQp qp;
    LeastDistance::Centre centre;
  };

  Node& node(int level) {
    while (static_cast<int>(nodes_.size()) <= level) {
      nodes_.push_back(
          std::make_unique<Node>(Node{qp::NodeQp(condensed_.H.rows(), condensed_.J.rows()), {}}));
    }
    return *nodes_[level];
  }

  void accept(const Plan& plan) {
    if (!result_.plan || plan.objective < result_.plan->objective) result_.plan = plan;
  }

  /// What gaps are relative to.
  double cost_scale() const {
    return std::max(std::abs(result_.plan->objective), kCostRounding * condensed_.constant);
  }

  double prune_above() const {
    if (!result_.plan) return kInfinity;
    return result_.plan->objective - settings_.relative_gap * cost_scale();
  }

  bool struck() const { return deadline_.struck(); }
  const qp::NodeQp& relaxation(int level) { return node(level).qp; }
  /// That of the node, which stands for both of its sides.
  static double side_bound(int, int) { return 0.0; }

  void descend(int level, int side) {
    Node& here = node(level);
    Node& next = node(level + 1);
    next.qp.copy_from(here.qp);
    next.centre = here.centre;
    next.qp.pin(side);
  }

  /// Nothing more is known of what is below a node than its bound.
  void leave_open(double bound) { open_ = std::min(open_, bound); }

  qp::NodeQp::Status solve(Node& here, double above) {
    return here.qp.solve(least_.C(), here.centre.t, kFeasible * magnitude_,
                         0.5 * (above - here.centre.lowest));
  }

  double cost_of(const Node& here) const { return here.centre.lowest + 2.0 * here.qp.objective(); }

  void move(Node& here, const VectorXd& v) {
    least_.place(v, here.centre);
    here.qp.restart(least_.C(), here.centre.t);
  }

  /// What is not solved, or solved without a plan as cheap as its bound, stays open.
  qp::Expansion open(double bound) {
    leave_open(bound);
    return {bound, -1};
  }

  qp::ViolatedPair violated(const Node& here) const {
    return qp::most_violated_pair(here.qp, n_, 0.0);
  }

  /// @param bound  a lower bound of everything below this node
  qp::Expansion expand(int level, double bound) {
    Node& here = node(level);
    for (int i = 0;; ++i) {
      // the last time whatever it costs: where the curvature is what costs, there may be more below
      const bool last = i == kMaxCentres;
      const auto status = solve(here, last ? kInfinity : prune_above());
      if (status == qp::NodeQp::Status::kInfeasible) {
        bound = std::max(bound, least_.infeasible_below(here.centre, here.qp, prune_above()));
        return bound >= prune_above() ? qp::Expansion{bound, -1} : open(bound);
      }
      if (status == qp::NodeQp::Status::kStuck) return open(bound);
      const LeastDistance::Bound lower = least_.lower_bound(here.centre, here.qp, prune_above());
      bound = std::max(bound, lower.value);
      if (bound >= prune_above()) return {bound, -1};
      const bool solved = status == qp::NodeQp::Status::kSolved;
      if (solved && violated(here).smaller <= kComplementary * magnitude_) {
        leaf(here);
        if (bound >= prune_above()) return {bound, -1};
      }
      if (last || (solved && cost_of(here) < prune_above() && violated(here).pair >= 0)) break;
      move(here, lower.v);
    }
    const int pair = violated(here).pair;
    if (pair < 0) return open(bound);  // complementary, but no plan as cheap as the bound
    return {bound, pair};
  }

  void leaf(const Node& here) {
    std::vector<Side> zero;
    const VectorXd& s = here.qp.s();
    for (int i = 0; i < n_; ++i) {
      const bool gap = here.qp.is_pinned(n_ + i) || (!here.qp.is_pinned(i) && s[i] > s[n_ + i]);
      zero.push_back(gap ? Side::kGap : Side::kForce);
    }
    scratch_.copy_from(here.qp);
    scratch_centre_ = here.centre;
    std::optional<Plan> plan =
        solve_modes(problem_, zero, condensed_, least_, scratch_, scratch_centre_);
    if (!plan) plan = solve_modes(problem_, zero);
    if (plan) accept(*plan);
  }

  const Problem& problem_;
  SearchSettings settings_;
  const c3::Deadline& deadline_;
  Condensed condensed_;
  LeastDistance least_;
  int n_;
  double magnitude_ = 0.0;
  std::vector<std::unique_ptr<Node>> nodes_;  // one per level
  qp::NodeQp scratch_;
  LeastDistance::Centre scratch_centre_;
  SearchResult result_;
  double open_ = kInfinity;
};

}  // namespace

SearchResult search(const Problem& problem, const SearchSettings& settings,
                    const std::optional<Plan>& known, const c3::Deadline& deadline) {
  return Search(problem, settings, known, deadline).run();
}

std::string describe(const SearchResult& result) {
  const std::string best =
      result.plan ? base::words("the best plan found is within a gap of %.2g", result.gap)
                  : std::string("no plan was found");
  switch (result.status) {
    case SearchStatus::kOptimal:
      return base::words("proven optimal to a gap of %.2g", result.gap);
    case SearchStatus::kInfeasible:
      return "infeasible: no trajectory meets the constraints";
    case SearchStatus::kNodeLimit:
      return base::words("stopped at max_nodes = %ld (%ld QPs solved): ", result.max_nodes,
                         result.nodes) +
             best;
    case SearchStatus::kDeadline:
      return base::words("stopped by the deadline after %ld QPs: ", result.nodes) + best;
    case SearchStatus::kInaccurate:
      break;
  }
  return base::words("beyond double precision, %ld QPs searched to the end: ", result.nodes) + best;
}

}  // namespace c3rt::horizon
