#include "cli/campaign/table.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "cli/exit_status.hpp"

namespace c3rt::cli::campaign {
namespace {

/// Values of one figure over the runs, and whose each is.
struct Sample {
  std::vector<double> values;
  std::vector<std::uint64_t> seeds;
};

bool met(const ordered_json& criterion) { return criterion.value("met", false); }

int unmet(const ordered_json& report) {
  const ordered_json criteria = report.value("criteria", ordered_json::array());
  return static_cast<int>(
      std::count_if(criteria.begin(), criteria.end(),
                    [](const ordered_json& criterion) { return !met(criterion); }));
}

/// A failed process is worse than any report; then what misses more criteria; then the first
/// criterion in the scenario's order that tells two runs apart.
bool worse(const RunResult& a, const RunResult& b) {
  if (a.report.is_null() != b.report.is_null()) return a.report.is_null();
  if (a.report.is_null()) return false;
  if (unmet(a.report) != unmet(b.report)) return unmet(a.report) > unmet(b.report);
  const ordered_json& ours = a.report.at("criteria");
  const ordered_json& others = b.report.at("criteria");
  for (std::size_t i = 0; i < std::min(ours.size(), others.size()); ++i) {
    const ordered_json &x = ours[i].at("value"), &y = others[i].at("value");
    if (x == y || !x.is_number() || !y.is_number()) continue;
    const bool higher = higher_is_better(ours[i].at("name"));
    return higher ? x.get<double>() < y.get<double>() : x.get<double>() > y.get<double>();
  }
  return false;
}

std::vector<CriterionSummary> summarise_criteria(const std::vector<RunResult>& results) {
  std::vector<CriterionSummary> summaries;
  std::vector<Sample> samples;
  std::vector<int> successes;
  int count = 0;
  for (const RunResult& result : results) {
    if (result.report.is_null()) continue;
    ++count;
    std::size_t i = 0;
    for (const ordered_json& criterion : result.report.at("criteria")) {
      if (i == summaries.size()) {
        summaries.push_back({criterion.at("name"), criterion.at("limit"), {}, {}});
        samples.emplace_back();
        successes.push_back(0);
      }
      successes[i] += met(criterion) ? 1 : 0;
      if (criterion.at("value").is_number()) {
        samples[i].values.push_back(criterion.at("value"));
        samples[i].seeds.push_back(result.spec.seed);
      }
      ++i;
    }
  }
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    summaries[i].met = wilson(successes[i], count);
    if (samples[i].values.empty()) continue;
    summaries[i].values = distribution(samples[i].values, higher_is_better(summaries[i].name));
    summaries[i].worst_seed = samples[i].seeds[summaries[i].values->worst_index];
  }
  return summaries;
}

std::vector<FigureSummary> summarise_figures(const std::vector<RunResult>& results) {
  std::vector<std::string> names;  // in the order of the report
  std::map<std::string, Sample> samples;
  for (const RunResult& result : results) {
    if (result.report.is_null()) continue;
    for (const auto& [name, value] : figures(result.report)) {
      Sample& sample = samples[name];
      if (sample.values.empty()) names.push_back(name);
      sample.values.push_back(value);
      sample.seeds.push_back(result.spec.seed);
    }
  }
  std::vector<FigureSummary> summaries;
  for (const std::string& name : names) {
    const Sample& sample = samples.at(name);
    const Distribution values = distribution(sample.values, higher_is_better(name));
    summaries.push_back({name, values, sample.seeds[values.worst_index]});
  }
  return summaries;
}

std::vector<std::string> cells(const Distribution& values, std::uint64_t worst_seed) {
  return {std::to_string(values.count), shown(values.p05),
          shown(values.median),         shown(values.p95),
          shown(values.worst),          std::to_string(worst_seed)};
}

ordered_json to_json(const Proportion& share) {
  return {{"successes", share.successes},
          {"count", share.count},
          {"share", share.share},
          {"low", share.low},
          {"high", share.high}};
}

ordered_json to_json(const Distribution& values, std::uint64_t worst_seed) {
  return {{"count", values.count},   {"mean", values.mean}, {"p05", values.p05},
          {"median", values.median}, {"p95", values.p95},   {"worst", values.worst},
          {"worst_seed", worst_seed}};
}

}  // namespace

Summary summarise(const std::vector<RunResult>& results) {
  Summary summary;
  for (const RunResult& result : results) {
    summary.passed += result.status == kDone ? 1 : 0;
    summary.missed += result.status == kCriterionFailed ? 1 : 0;
    summary.failed += result.status == kProcessFailed ? 1 : 0;
  }
  summary.success = wilson(summary.passed, static_cast<int>(results.size()));
  summary.criteria = summarise_criteria(results);
  summary.figures = summarise_figures(results);
  for (std::size_t i = 1; i < results.size(); ++i) {
    if (worse(results[i], results[summary.worst])) summary.worst = i;
  }
  return summary;
}

Rows rows(const Summary& summary) {
  Rows table{{"", "met", "runs", "p5", "median", "p95", "worst", "of seed"}};
  for (const CriterionSummary& criterion : summary.criteria) {
    std::vector<std::string> row{
        fmt::format("criterion {} (limit {:g})", criterion.name, criterion.limit),
        fmt::format("{} of {}", criterion.met.successes, criterion.met.count)};
    if (criterion.values) {
      const auto more = cells(*criterion.values, criterion.worst_seed);
      row.insert(row.end(), more.begin(), more.end());
    }
    table.push_back(std::move(row));
  }
  for (const FigureSummary& figure : summary.figures) {
    std::vector<std::string> row{figure.name, ""};
    const auto more = cells(figure.values, figure.worst_seed);
    row.insert(row.end(), more.begin(), more.end());
    table.push_back(std::move(row));
  }
  return table;
}

std::string verdict(const Summary& summary) {
  const Proportion& p = summary.success;
  std::string text =
      fmt::format("{} of {} passed ({:.0f} %, 95 % confidence: {:.0f} to {:.0f} %)", p.successes,
                  p.count, 100.0 * p.share, 100.0 * p.low, 100.0 * p.high);
  if (summary.missed > 0) text += fmt::format(", {} missed a criterion", summary.missed);
  if (summary.failed > 0) text += fmt::format(", {} failed", summary.failed);
  return text;
}

ordered_json to_json(const Summary& summary, const std::vector<RunResult>& results) {
  ordered_json runs = ordered_json::array();
  for (const RunResult& result : results) {
    ordered_json missed = ordered_json::array();
    ordered_json criteria = ordered_json::array();
    if (!result.report.is_null()) criteria = result.report.at("criteria");
    for (const ordered_json& criterion : criteria) {
      if (!met(criterion)) missed.push_back(criterion.at("name"));
    }
    runs.push_back({{"seed", result.spec.seed},
                    {"exit_status", result.status},
                    {"result", result.report.is_null() ? ordered_json(result.failure)
                                                       : result.report.at("result")},
                    {"criteria_missed", missed},
                    {"wall_s", result.wall_s},
                    {"folder", result.folder.string()}});
  }
  ordered_json criteria = ordered_json::array();
  for (const CriterionSummary& criterion : summary.criteria) {
    ordered_json entry{
        {"name", criterion.name}, {"limit", criterion.limit}, {"met", to_json(criterion.met)}};
    if (criterion.values) entry["values"] = to_json(*criterion.values, criterion.worst_seed);
    criteria.push_back(std::move(entry));
  }
  ordered_json all = ordered_json::object();
  for (const FigureSummary& figure : summary.figures)
    all[figure.name] = to_json(figure.values, figure.worst_seed);
  const RunResult& worst = results[summary.worst];
  return {{"success", to_json(summary.success)},
          {"missed_criteria", summary.missed},
          {"failed", summary.failed},
          {"worst", {{"seed", worst.spec.seed}, {"command", replay_command(worst.spec)}}},
          {"criteria", criteria},
          {"figures", all},
          {"runs", runs}};
}

}  // namespace c3rt::cli::campaign
