#include "cli/judge.hpp"

#include <vector>

#include "cli/table.hpp"
#include "plant_emulator/errors.hpp"
#include "plant_emulator/pushes.hpp"

namespace c3rt::cli {
namespace {

Spread spread_of(const wire::Quantiles& quantiles) {
  if (quantiles.count == 0) return {};
  return {quantiles.p50_s, quantiles.p95_s, quantiles.p99_s, quantiles.max_s};
}

ServiceFigures service_figures(const Services& words) {
  ServiceFigures figures;
  if (const auto& impedance = words[c3rt_v2_PROCESS_IMPEDANCE]) {
    figures.impedance_wakeup = spread_of(impedance->wakeup_latency);
    figures.impedance_compute = spread_of(impedance->compute);
    figures.impedance_missed_cycles = counter(*impedance, "missed_cycles");
    figures.stale_plan_events = counter(*impedance, "stale_plan_events");
  }
  return figures;
}

std::vector<std::string> reflex_names(std::uint64_t bits) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < plant::kErrorNames.size(); ++i) {
    if ((bits >> i & 1U) != 0) names.emplace_back(plant::kErrorNames[i]);
  }
  return names;
}

}  // namespace

Figures judge(const Series& series, const config::Scenario& scenario, const task::Task& task,
              std::uint64_t seed) {
  std::vector<Limit> limits;
  for (const config::Criterion& c : scenario.criteria) limits.push_back({c.name, c.min, c.max});
  const auto objects = static_cast<int>(scenario.plant.world.objects.size());
  return evaluate(series, task, limits, plant::drawn_pushes(scenario.plant.pushes, objects, seed));
}

Report judge(const Samples& samples, const config::Scenario& scenario, std::uint64_t seed) {
  Report report;
  report.scenario = scenario.name;
  report.seed = seed;
  report.figures = judge(samples.series(), scenario, scenario.task.motion.seeded(seed), seed);
  report.services = service_figures(samples.words());
  report.reflexes = reflex_names(report.figures.error_bits);
  report.log_hash = samples.log_hash();
  return report;
}

std::string result_of(const Report& report, bool robot_stopped) {
  if (!robot_stopped) return all_met(report.figures.criteria) ? "passed" : "criteria not met";
  std::string text = "the robot stopped";
  for (const std::string& reflex : report.reflexes) text += ": " + reflex;
  return text;
}

}  // namespace c3rt::cli
