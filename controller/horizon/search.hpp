#pragma once

#include <limits>
#include <optional>
#include <string>

#include "controller/c3/deadline.hpp"
#include "controller/horizon/problem.hpp"

namespace c3rt::horizon {

struct SearchSettings {
  long max_nodes = 1'000'000;
  double relative_gap = 1e-4;
};

enum class SearchStatus {
  kOptimal,     // proven: no plan is cheaper by more than the gap asked for
  kInfeasible,  // shown: no plan meets the constraints
  kNodeLimit,   // max_nodes ended the search, with a plan or without
  kDeadline,    // the deadline did
  kInaccurate,  // all is searched, but double precision could not decide everywhere
};

struct SearchResult {
  SearchStatus status = SearchStatus::kInaccurate;
  std::optional<Plan> plan;  // the best found, or the one given
  // no plan costs less (see LeastDistance::lower_bound); infinity where there is none
  double lower_bound = 0.0;
  // (objective − lower_bound)/objective, or of the costs' rounding if that is larger; infinity
  // without a plan
  double gap = std::numeric_limits<double>::infinity();
  long nodes = 0;      // QPs solved
  long max_nodes = 0;  // that were allowed

  bool is_proven() const noexcept { return status == SearchStatus::kOptimal; }
};

/// The monolithic problem [C3, eq. (15)] by branch and bound over its complementary pairs, without
/// M: the search of the exact projection, over the whole horizon. Depth first, so that an answer
/// is there soon. Bounds are those of the problem itself, without the curvature that λ, which has
/// no cost of its own, is given in the QPs; plans are simulated and checked before they count. Not
/// RT. Deterministic unless the deadline strikes.
/// @param known  a plan that meets the problem, for example C3's; others are left alone
SearchResult search(const Problem& problem, const SearchSettings& settings,
                    const std::optional<Plan>& known = {}, const c3::Deadline& deadline = {});

/// "the best plan is proven to a gap of 1e-07", "max_nodes = 1000 QPs were solved before a plan was
/// found".
std::string describe(const SearchResult& result);

}  // namespace c3rt::horizon
