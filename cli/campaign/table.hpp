#pragma once
// The one table of a campaign.
#include <string>
#include <vector>

#include "cli/campaign/runs.hpp"
#include "cli/campaign/statistics.hpp"
#include "cli/report/text_table.hpp"

namespace c3rt::cli::campaign {

/// One limit of the scenario over all runs.
struct CriterionSummary {
  std::string name;
  double limit;
  Proportion met;
  std::optional<Distribution> values;  // of the runs that gave one
  std::uint64_t worst_seed = 0;
};

struct FigureSummary {
  std::string name;  // its path in report.json
  Distribution values;
  std::uint64_t worst_seed;
};

struct Summary {
  int passed = 0, missed = 0, failed = 0;  // missed: a criterion; failed: a process
  Proportion success{};                    // of all runs, those whose process failed included
  std::vector<CriterionSummary> criteria;
  std::vector<FigureSummary> figures;
  std::size_t worst = 0;  // index of the run that is worth a look
};

/// @param results at least one
Summary summarise(const std::vector<RunResult>& results);

/// A head line, then criteria, then figures.
Rows rows(const Summary& summary);

/// "18 of 20 passed (90 %, 95 % confidence: 70 to 97 %), 1 missed a criterion, 1 failed"
std::string verdict(const Summary& summary);

ordered_json to_json(const Summary& summary, const std::vector<RunResult>& results);

}  // namespace c3rt::cli::campaign
