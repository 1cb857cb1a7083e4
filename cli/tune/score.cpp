#include "cli/tune/score.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "cli/campaign/statistics.hpp"
#include "cli/exit_status.hpp"

namespace c3rt::cli::tune {
namespace {

using campaign::ordered_json;

constexpr double kLeast = 0.01;  // of a criterion that is missed by a hair

/// In (0, 1]: 1 where there is no value at all.
double shortfall(const ordered_json& criterion) {
  if (criterion.value("met", false)) return 0.0;
  const ordered_json value = criterion.value("value", ordered_json()),
                     limit = criterion.value("limit", ordered_json());
  if (!value.is_number() || !limit.is_number()) return 1.0;
  const double got = value.get<double>(), wanted = limit.get<double>();
  const double largest = std::max(std::abs(got), std::abs(wanted));
  return largest > 0.0 ? std::clamp(std::abs(got - wanted) / largest, kLeast, 1.0) : kLeast;
}

}  // namespace

bool operator<(const Score& a, const Score& b) {
  return std::tie(a.failed, a.shortfall, a.figure) < std::tie(b.failed, b.shortfall, b.figure);
}

Score score(const std::vector<campaign::RunResult>& results, const std::string& figure,
            bool more_is_better) {
  Score score{0, 0.0, 0.0};
  for (const campaign::RunResult& result : results) {
    if (result.status == kProcessFailed) {
      ++score.failed;
      continue;
    }
    for (const ordered_json& criterion : result.report.value("criteria", ordered_json::array()))
      score.shortfall += shortfall(criterion);
    const auto figures = campaign::figures(result.report);
    const auto found = std::find_if(figures.begin(), figures.end(),
                                    [&](const auto& known) { return known.first == figure; });
    const double value = found == figures.end() ? std::numeric_limits<double>::infinity()
                                                : (more_is_better ? -found->second : found->second);
    score.figure += value / static_cast<double>(results.size());
  }
  return score;
}

std::vector<double> ranks(const std::vector<Score>& scores) {
  std::vector<double> all;
  for (const Score& score : scores) {
    all.push_back(static_cast<double>(std::count_if(
        scores.begin(), scores.end(), [&](const Score& other) { return other < score; })));
  }
  return all;
}

std::string text(const Score& score, const std::string& figure, bool more_is_better) {
  if (score.failed > 0) return fmt::format("{} runs failed", score.failed);
  const std::string criteria = score.shortfall > 0.0
                                   ? fmt::format("criteria missed by {:.3g}", score.shortfall)
                                   : std::string("all criteria met");
  const double value = more_is_better ? -score.figure : score.figure;
  return fmt::format("{}, {} {}", criteria, figure,
                     std::isfinite(value) ? fmt::format("{:.4g}", value) : "not reached");
}

}  // namespace c3rt::cli::tune
