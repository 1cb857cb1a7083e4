#pragma once

#include <algorithm>
#include <optional>

#include "controller/qp/node_qp.hpp"

namespace c3rt::qp {

/// Pair i of complementary constraints is s_i and s_{n + i} of a NodeQp: one of the two has to be
/// zero.
struct ViolatedPair {
  int pair = -1;         // −1: there is none
  double smaller = 0.0;  // of its two sides, the smaller
};

/// Of the pairs that have no pinned side the one whose smaller side is the largest, if that is
/// above `tolerance`. RT.
inline ViolatedPair most_violated_pair(const NodeQp& qp, int n_pairs, double tolerance) noexcept {
  ViolatedPair worst{-1, tolerance};
  for (int i = 0; i < n_pairs; ++i) {
    const double smaller = std::min(qp.s()[i], qp.s()[n_pairs + i]);
    // what is left at a pinned side is rounding
    if (smaller > worst.smaller && !qp.is_pinned(i) && !qp.is_pinned(n_pairs + i)) {
      worst = {i, smaller};
    }
  }
  return worst;
}

/// What ends a search before it is complete.
enum class SearchLimit { kNodes, kDeadline };

/// What the relaxation of a node leaves to be searched below it.
struct Expansion {
  double bound;   // no point below the node costs less
  int pair = -1;  // to branch on; −1: nothing is left below
};

/// Branch and bound over complementary pairs, depth first, the cheaper side of a pair first. The
/// problem owns the nodes, one a level, the best point and the bounds:
///
///   double prune_above()               nodes with a bound of at least this cannot improve the best
///   bool struck()                      whether the deadline is over
///   Expansion expand(level, bound)     solves a node and keeps its point if it is the best
///   const NodeQp& relaxation(level)    of the node that was expanded last at this level
///   double side_bound(level, side)     of what is below, with this side zero
///   void descend(level, side)          makes the node at level + 1, with this side zero
///   void leave_open(bound)             a node with this bound is not searched
///
/// Allocates nothing itself; deterministic unless the deadline strikes.
template <typename Problem>
class BranchAndBound {
 public:
  BranchAndBound(Problem& problem, int n_pairs, long max_nodes) noexcept
      : problem_(problem), n_pairs_(n_pairs), max_nodes_(max_nodes) {}

  /// From the node of level 0. @param bound  no point at all costs less
  void run(double bound) {
    if (bound < problem_.prune_above()) explore(0, bound);
  }

  long nodes() const noexcept { return nodes_; }
  /// What ended the search early.
  std::optional<SearchLimit> limit() const noexcept { return limit_; }

 private:
  void explore(int level, double bound) {
    if (!limit_ && nodes_ >= max_nodes_) limit_ = SearchLimit::kNodes;
    if (!limit_ && problem_.struck()) limit_ = SearchLimit::kDeadline;
    if (limit_) return problem_.leave_open(bound);
    ++nodes_;
    const Expansion below = problem_.expand(level, bound);
    if (below.pair < 0) return;
    const int one = below.pair, other = n_pairs_ + below.pair;
    const bool one_first =
        problem_.relaxation(level).s()[one] <= problem_.relaxation(level).s()[other];
    for (const int side : {one_first ? one : other, one_first ? other : one}) {
      const double next = std::max(below.bound, problem_.side_bound(level, side));
      if (next >= problem_.prune_above()) continue;
      problem_.descend(level, side);
      explore(level + 1, next);
    }
  }

  Problem& problem_;
  int n_pairs_;
  long max_nodes_;
  long nodes_ = 0;
  std::optional<SearchLimit> limit_;
};

}  // namespace c3rt::qp
