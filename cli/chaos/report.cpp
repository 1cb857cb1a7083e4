#include "cli/chaos/report.hpp"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/report/figure.hpp"
#include "cli/soak/report.hpp"
#include "controller/base/quantile.hpp"

namespace c3rt::cli::chaos {
namespace {

using nlohmann::ordered_json;

ordered_json quantiles(const std::vector<double>& sorted) {
  if (sorted.empty()) return nullptr;
  return {{"count", sorted.size()},
          {"p50", base::quantile_nearest(sorted, 0.5)},
          {"p95", base::quantile_nearest(sorted, 0.95)},
          {"p99", base::quantile_nearest(sorted, 0.99)},
          {"max", sorted.back()}};
}

ordered_json number_or_null(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

/// Who has not recovered took for ever; who was overtaken says nothing.
double p99(const Times& times) {
  std::vector<double> all = times.resumed;
  all.insert(all.end(), times.not_resumed, kNever);
  return base::quantile_nearest(all, 0.99);
}

}  // namespace

std::vector<Criterion> criteria_of(const std::vector<Outcome>& outcomes) {
  std::vector<Criterion> criteria;
  const auto add = [&](const char* name, bool plant, double limit) {
    const Times times = of_plant(outcomes, plant);
    if (times.resumed.empty() && times.not_resumed == 0) return;
    const double value = p99(times);
    criteria.push_back({name, value, limit, value <= limit});
  };
  add("recovery_p99_s", false, kLimit);
  add("recovery_of_plant_p99_s", true, kPlantLimit);
  return criteria;
}

ordered_json to_json(const Summary& summary, const std::vector<Outcome>& outcomes,
                     const invariants::Violations& violations, const Courses& courses) {
  ordered_json kinds = ordered_json::object(), criteria = ordered_json::array();
  for (const auto& [name, times] : by_kind(outcomes)) {
    kinds[name] = {{"count", times.count},
                   {"overtaken", times.overtaken},
                   {"not_resumed", times.not_resumed},
                   {"resumed_s", quantiles(times.resumed)},
                   {"at_task_s", quantiles(times.at_task)}};
  }
  for (const Criterion& criterion : criteria_of(outcomes)) {
    criteria.push_back({{"name", criterion.name},
                        {"value", number_or_null(criterion.value)},
                        {"limit", criterion.limit},
                        {"met", criterion.met}});
  }
  return {{"scenario", summary.scenario},   {"clock", summary.clock},
          {"seed", summary.seed},           {"rate_per_min", summary.rate},
          {"result", summary.result},       {"lasted_s", summary.lasted},
          {"wall_s", summary.wall},         {"passes", summary.passes},
          {"samples", summary.samples},     {"reflexes", summary.reflexes},
          {"rows_lost", summary.rows_lost}, {"log_hashes", summary.log_hashes},
          {"faults", outcomes.size()},      {"kinds", kinds},
          {"criteria", criteria},           {"violations", soak::to_json(violations)},
          {"reproduce", summary.again},     {"processes", soak::to_json(courses)}};
}

std::string to_text(const Summary& summary, const std::vector<Outcome>& outcomes,
                    const invariants::Violations& violations) {
  std::string text = fmt::format("c3rt chaos {} ({}, seed {}): {}\n", summary.scenario,
                                 summary.clock, summary.seed, summary.result);
  const auto line = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:<12}{}\n", name, value);
  };
  line("lasted", fmt::format("{} in {} of the wall, {} faults, {} samples, {} reflexes",
                             soak::time_text(summary.lasted), soak::time_text(summary.wall),
                             outcomes.size(), summary.samples, summary.reflexes));
  if (summary.rows_lost > 0) {
    line("lost",
         fmt::format("{} lines of processes.csv: there was no room for them", summary.rows_lost));
  }
  text += fmt::format("  {:<20}{:>6}  {:>7}{:>7}{:>7}{:>7}   {:>7}{:>7}  {}\n", "the arm goes on",
                      "times", "p50", "p95", "p99", "max", "at task", "max", "[s] after its end");
  for (const auto& [name, times] : by_kind(outcomes)) {
    text += fmt::format("  {:<20}{:>6}  ", name, times.count);
    if (times.resumed.empty()) {
      text += fmt::format("{:>28}", "");
    } else {
      for (const double share : {0.5, 0.95, 0.99, 1.0})
        text += fmt::format("{:>7.2f}", base::quantile_nearest(times.resumed, share));
    }
    text += "   ";
    if (times.at_task.empty()) {
      text += fmt::format("{:>14}", "");
    } else {
      for (const double share : {0.5, 1.0})
        text += fmt::format("{:>7.2f}", base::quantile_nearest(times.at_task, share));
    }
    if (times.overtaken > 0) text += fmt::format("  {} overtaken by the next", times.overtaken);
    if (times.not_resumed > 0) text += fmt::format("  {} NOT RECOVERED", times.not_resumed);
    text += "\n";
  }
  for (const Criterion& criterion : criteria_of(outcomes)) {
    line(criterion.met ? "met" : "NOT MET",
         fmt::format("{} {:.2f}, at most {:g}", criterion.name, criterion.value, criterion.limit));
  }
  text += soak::to_text(violations);
  if (!summary.again.empty()) line("again by", summary.again);
  return text;
}

std::string to_csv(const std::vector<Outcome>& outcomes) {
  std::string text = "number,kind,target,begin_s,duration_s,amount,resumed_s,at_task_s,overtaken\n";
  for (const Outcome& outcome : outcomes) {
    const Fault& fault = outcome.fault;
    text += fmt::format("{},{},{},{:.3f},{:g},{:.6g},{:.3f},{:.3f},{:d}\n", fault.number,
                        fault.kind->name, fault.target, fault.begin, fault.duration, fault.amount,
                        outcome.resumed, outcome.at_task, outcome.overtaken);
  }
  return text;
}

std::string draw_recovery(const std::filesystem::path& folder, const std::string& title,
                          const std::vector<Outcome>& outcomes) {
  Panel panel;
  panel.title = "share of the faults after which the arm goes on within that time";
  panel.x_label = "time after the fault's end [s]";
  panel.y_label = "share";
  for (const auto& [name, times] : by_kind(outcomes)) {
    if (times.resumed.empty()) continue;
    Curve curve;
    curve.name = name;
    const auto count = static_cast<Eigen::Index>(times.resumed.size());
    curve.x = Eigen::Map<const Eigen::VectorXd>(times.resumed.data(), count);
    curve.y = Eigen::VectorXd::LinSpaced(count, 1.0 / static_cast<double>(count), 1.0);
    curve.points = true;
    panel.curves.push_back(curve);
  }
  if (panel.curves.empty()) return "";
  return draw({{folder / "recovery.png", {title, {panel}}}});
}

}  // namespace c3rt::cli::chaos
