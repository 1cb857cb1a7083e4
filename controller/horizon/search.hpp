#pragma once

#include <optional>

#include "controller/c3/deadline.hpp"
#include "controller/horizon/problem.hpp"

namespace c3rt::horizon {

struct SearchSettings {
  long max_nodes = 1'000'000;
  double relative_gap = 1e-4;
};

struct SearchResult {
  std::optional<Plan> plan;  // the best found, or the one given
  bool is_proven = false;    // the search ended by itself: `gap` is at most the one asked for
  double gap = 0.0;          // (objective − lower bound)/objective
  long nodes = 0;            // QPs solved
};

/// The monolithic problem [C3, eq. (15)] by branch and bound over its complementary pairs, without
/// M: the search of the exact projection, over the whole horizon. Depth first, so that an answer
/// is there soon. λ has no cost of its own: the bounds hold up to the curvature of 1e-9 of the
/// largest that is given to it. Not RT. Deterministic unless the deadline strikes.
/// @param known  a plan that meets the constraints and is complementary, for example C3's
SearchResult search(const Problem& problem, const SearchSettings& settings,
                    const std::optional<Plan>& known = {}, const c3::Deadline& deadline = {});

}  // namespace c3rt::horizon
