#include "cli/campaign/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "controller/base/quantile.hpp"

namespace c3rt::cli::campaign {
namespace {

constexpr double kNormal95 = 1.959963984540054;  // quantile 0.975 of the normal distribution

// what a seed is called or how long it was recorded says nothing of how well it went; trials are
// runs themselves
constexpr const char* kNoFigures[] = {"criteria", "seed", "trials"};
// a longer time until something, a larger error, more events are worse, but not these
constexpr const char* kHigherIsBetter[] = {"in_band",     "success_rate",     "loops_completed",
                                           "rate_hz",     "real_time_factor", "turns",
                                           "cameras_used"};

void collect(const std::string& path, const ordered_json& value,
             std::vector<std::pair<std::string, double>>& out) {
  if (value.is_number()) {
    out.emplace_back(path, value.get<double>());
  } else if (value.is_object()) {
    for (const auto& [name, member] : value.items()) {
      const auto is = [&name = name](const char* other) { return name == other; };
      if (std::any_of(std::begin(kNoFigures), std::end(kNoFigures), is)) continue;
      if (name == "reflexes" && member.is_array()) {
        out.emplace_back(path + name, static_cast<double>(member.size()));
      } else {
        collect(path + name + (member.is_structured() ? "." : ""), member, out);
      }
    }
  } else if (value.is_array()) {
    const bool numbers = std::all_of(value.begin(), value.end(),
                                     [](const ordered_json& item) { return item.is_number(); });
    if (!numbers) {
      for (std::size_t i = 0; i < value.size(); ++i)
        collect(path + std::to_string(i) + (value[i].is_structured() ? "." : ""), value[i], out);
    } else if (!value.empty()) {
      const Distribution d = distribution(value.get<std::vector<double>>(), higher_is_better(path));
      out.emplace_back(path + "median", d.median);
      out.emplace_back(path + "worst", d.worst);
    }
  }
}

}  // namespace

Proportion wilson(int successes, int count) {
  const double n = count, p = successes / n, z2 = kNormal95 * kNormal95;
  const double centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half =
      kNormal95 / (1.0 + z2 / n) * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  // rounding must not exclude what happened
  return {successes, count, p, std::min(p, std::max(0.0, centre - half)),
          std::max(p, std::min(1.0, centre + half))};
}

Distribution distribution(const std::vector<double>& values, bool higher_is_better) {
  const auto worst = higher_is_better ? std::min_element(values.begin(), values.end())
                                      : std::max_element(values.begin(), values.end());
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  return {static_cast<int>(values.size()),
          std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()),
          base::quantile_linear(sorted, 0.05),
          base::quantile_linear(sorted, 0.5),
          base::quantile_linear(sorted, 0.95),
          *worst,
          static_cast<std::size_t>(worst - values.begin())};
}

std::vector<std::pair<std::string, double>> figures(const ordered_json& report) {
  std::vector<std::pair<std::string, double>> all;
  collect("", report, all);
  return all;
}

bool higher_is_better(const std::string& figure) {
  return std::any_of(std::begin(kHigherIsBetter), std::end(kHigherIsBetter),
                     [&](const char* part) { return figure.find(part) != std::string::npos; });
}

}  // namespace c3rt::cli::campaign
