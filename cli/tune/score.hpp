#pragma once
// How good one candidate is.
#include <limits>
#include <string>
#include <vector>

#include "cli/campaign/runs.hpp"

namespace c3rt::cli::tune {

/// Compared in this order: less is better.
struct Score {
  int failed = 0;          // runs whose process failed
  double shortfall = 0.0;  // by how much of themselves criteria were missed, summed over the runs
  double figure = std::numeric_limits<double>::infinity();  // mean over the runs; negative where
                                                            // more is better
};
bool operator<(const Score& a, const Score& b);

/// @param results of one candidate, at least one
/// @param figure its path in report.json ("loop_times_s.median"), as campaign::figures() has it; of
/// a run that does not give it, it is infinite
/// @param more_is_better of the figure
Score score(const std::vector<campaign::RunResult>& results, const std::string& figure,
            bool more_is_better);

/// The place of each among all, from 0; equals share theirs. What CMA-ES needs to know.
std::vector<double> ranks(const std::vector<Score>& scores);

/// "all criteria met, loop_times_s.median 9.7", "criteria missed by 1.3, …", "2 runs failed"
std::string text(const Score& score, const std::string& figure, bool more_is_better);

}  // namespace c3rt::cli::tune
