#include "controller/horizon/search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "controller/c3/node_qp.hpp"
#include "controller/horizon/modes.hpp"

namespace c3rt::horizon {
namespace {

using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = 1e-9;        // curvature where the cost has none, of the largest
constexpr double kFeasible = 1e-10;      // of the largest normalised |s| at the free minimiser
constexpr double kComplementary = 1e-8;  // the same, for the smaller side of a pair

class Search {
 public:
  Search(const Problem& problem, const SearchSettings& settings, const std::optional<Plan>& known,
         const c3::Deadline& deadline)
      : problem_(problem),
        settings_(settings),
        deadline_(deadline),
        condensed_(condense(problem)),
        least_(condensed_, kEpsilon),
        n_(condensed_.n_pairs) {
    VectorXd centre = VectorXd::Zero(condensed_.g.size());
    if (known) {
      accept(*known);
      Eigen::Map<Eigen::MatrixXd> stages(centre.data(), problem.sizes.n_u + problem.sizes.n_lambda,
                                         problem.sizes.N);
      stages << known->u, known->lambda;
    }
    least_.centre(centre);
    magnitude_ = least_.t().cwiseAbs().maxCoeff();
  }

  SearchResult run() {
    c3::NodeQp& root = node(0);
    root.start(least_.t());
    for (const int row : condensed_.equalities) root.pin(row);
    explore(0, least_.lowest());
    const double objective = result_.plan ? result_.plan->objective : kInfinity;
    result_.is_proven = !stopped_ && result_.plan;
    // what was left unsearched is not cheaper than `open_`, what was pruned than the pruning bound
    const double lower = std::min(open_, prune_above());
    if (result_.plan) {
      result_.gap = std::max(0.0, objective - lower) / std::max(std::abs(objective), 1e-300);
    }
    return std::move(result_);
  }

 private:
  c3::NodeQp& node(std::size_t level) {
    while (nodes_.size() <= level) {
      nodes_.push_back(std::make_unique<c3::NodeQp>(condensed_.H.rows(), condensed_.J.rows()));
    }
    return *nodes_[level];
  }

  void accept(const Plan& plan) {
    if (!result_.plan || plan.objective < result_.plan->objective) result_.plan = plan;
  }

  double prune_above() const {
    if (!result_.plan) return kInfinity;
    return result_.plan->objective - settings_.relative_gap * std::abs(result_.plan->objective);
  }

  /// @param bound  a lower bound of everything below this node
  void explore(std::size_t level, double bound) {
    if (result_.nodes >= settings_.max_nodes || deadline_.struck()) stopped_ = true;
    if (stopped_) {
      open_ = std::min(open_, bound);
      return;
    }
    ++result_.nodes;
    c3::NodeQp& here = node(level);
    const double limit = 0.5 * (prune_above() - least_.lowest());
    const auto status = here.solve(least_.C(), least_.t(), kFeasible * magnitude_, limit);
    if (status == c3::NodeQp::Status::kStuck) {
      stopped_ = true;
      open_ = std::min(open_, bound);
    }
    if (status != c3::NodeQp::Status::kSolved) return;
    bound = std::max(bound, least_.lowest() + 2.0 * here.objective());

    int pair = -1;
    double largest = 0.0;
    for (int i = 0; i < n_; ++i) {
      const double smaller = std::min(here.s()[i], here.s()[n_ + i]);
      if (smaller > largest) {
        largest = smaller;
        pair = i;
      }
    }
    if (largest <= kComplementary * magnitude_) leaf(here);
    // exact modes may cost more than this node, where a force without weight is large: search on
    if (pair < 0 || bound >= prune_above()) return;
    const int first = here.s()[pair] <= here.s()[n_ + pair] ? pair : n_ + pair;
    for (const int side : {first, first == pair ? n_ + pair : pair}) {
      const double s = here.s()[side];
      const double below = bound + s * s;  // bringing s to zero costs at least that
      if (below >= prune_above()) continue;
      c3::NodeQp& next = node(level + 1);
      next.copy_from(here);
      next.pin(side);
      explore(level + 1, below);
    }
  }

  void leaf(const c3::NodeQp& here) {
    std::vector<Side> zero;
    for (int i = 0; i < n_; ++i) {
      zero.push_back(here.s()[i] <= here.s()[n_ + i] ? Side::kForce : Side::kGap);
    }
    if (const auto plan = solve_modes(problem_, condensed_, zero)) accept(*plan);
  }

  const Problem& problem_;
  SearchSettings settings_;
  const c3::Deadline& deadline_;
  Condensed condensed_;
  LeastDistance least_;
  int n_;
  double magnitude_ = 0.0;
  std::vector<std::unique_ptr<c3::NodeQp>> nodes_;  // one per level
  SearchResult result_;
  bool stopped_ = false;
  double open_ = kInfinity;
};

}  // namespace

SearchResult search(const Problem& problem, const SearchSettings& settings,
                    const std::optional<Plan>& known, const c3::Deadline& deadline) {
  return Search(problem, settings, known, deadline).run();
}

}  // namespace c3rt::horizon
