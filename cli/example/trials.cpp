#include "cli/example/trials.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/example/plants.hpp"
#include "cli/report/json.hpp"
#include "cli/report/report.hpp"

namespace c3rt::cli {
namespace {

using nlohmann::ordered_json;

class Watch final : public example::Observer {
 public:
  Watch(const ExampleScenario& scenario, const Stop& stop)
      : scenario_(scenario), stop_(stop), progress_(scenario.name) {}

  bool go_on(double t) override {
    if (stop_()) return false;
    const int trials = scenario_.experiment.trials;
    progress_.update(
        (trial + t / scenario_.experiment.duration) / trials,
        fmt::format("trial {} of {}, t = {:.1f} s, {} succeeded", trial + 1, trials, t, succeeded));
    return true;
  }

  int trial = 0, succeeded = 0;

 private:
  const ExampleScenario& scenario_;
  const Stop& stop_;
  Progress progress_;
};

template <typename Value>
double mean(const std::vector<Trial>& trials, Value value) {
  if (trials.empty()) return kNone;
  double sum = 0.0;
  for (const Trial& trial : trials) sum += value(trial);
  return sum / static_cast<double>(trials.size());
}

double overshoot(const c3::Constraints& constraints, const Eigen::MatrixXd& x) {
  const double above = (x.colwise() - constraints.x_max[0]).maxCoeff();
  const double below = ((-x).colwise() + constraints.x_min[0]).maxCoeff();
  return std::max({0.0, above, below});
}

}  // namespace

Trial summarise(const example::Experiment& experiment, const example::Trajectory& trajectory) {
  Trial trial{trajectory.succeeded,
              trajectory.cost.tail(1)[0],
              kNone,
              0,
              trajectory.controller_failures,
              trajectory.plant_failed,
              overshoot(experiment.constraints, trajectory.x),
              trajectory.x.rightCols(1)};
  double sum = 0.0;
  int count = 0;
  for (const double cost : trajectory.cost_to_go) {
    if (!std::isfinite(cost)) continue;
    sum += cost;
    ++count;
  }
  if (count > 0) trial.mean_cost_to_go = sum / count;
  trial.plans_not_rolled_out =
      static_cast<int>(trajectory.cost_to_go.size()) - count - trajectory.controller_failures;
  return trial;
}

TrialsResult run_trials(const ExampleScenario& scenario, std::uint64_t seed, const Stop& stop,
                        const Deciding& deciding) {
  const example::Experiment experiment =
      deciding.trace ? traced(scenario.experiment) : scenario.experiment;
  example::C3Controller c3(experiment);
  std::optional<ExactController> exact;
  if (deciding.exact_limit) exact.emplace(experiment, *deciding.exact_limit, stop);
  TimedController timed(exact ? static_cast<example::Controller&>(*exact) : c3);
  std::optional<TracedController> trace;
  if (deciding.trace) trace.emplace(experiment, c3, timed);
  example::Controller& controller = trace ? static_cast<example::Controller&>(*trace) : timed;
  const std::unique_ptr<example::Plant> plant = make_plant(experiment);
  Watch watch(scenario, stop);
  TrialsResult result;
  for (watch.trial = 0; watch.trial < experiment.trials; ++watch.trial) {
    example::Trajectory trajectory =
        example::run(experiment, seed, watch.trial, controller, *plant, &watch);
    // a stop may also have cut the last decision short
    result.interrupted = trajectory.stopped || (exact && stop());
    if (!result.interrupted) {
      result.trials.push_back(summarise(experiment, trajectory));
      watch.succeeded += trajectory.succeeded ? 1 : 0;
    }
    if (watch.trial == 0) result.first = std::move(trajectory);
    if (result.interrupted) break;
  }
  result.solve_times = timed.seconds();
  if (exact) result.exact = exact->decisions();
  if (trace) {
    result.projections = trace->projections();
    result.first_iterates = trace->first_iterates();
    result.first_system = trace->first_system();
  }
  return result;
}

ExampleReport report_on(const ExampleScenario& scenario, std::uint64_t seed,
                        const TrialsResult& result) {
  ExampleReport report;
  report.scenario = scenario.name;
  report.seed = seed;
  report.trials_wanted = scenario.experiment.trials;
  report.trials = result.trials;
  report.success_rate = mean(result.trials, [](const Trial& t) { return t.succeeded ? 1.0 : 0.0; });
  report.mean_cost_to_go = mean(result.trials, [](const Trial& t) { return t.mean_cost_to_go; });
  report.accumulated_cost = mean(result.trials, [](const Trial& t) { return t.accumulated_cost; });
  report.solve_time = spread(result.solve_times);
  report.solves = result.solve_times.size();
  report.exact = result.exact.size();
  report.proven = static_cast<std::size_t>(
      std::count_if(result.exact.begin(), result.exact.end(),
                    [](const ExactDecision& decision) { return decision.proven; }));
  report.criteria = judge(scenario.criteria, [&](const std::string& name) {
    if (name == "success_rate") return report.success_rate;
    if (name == "mean_cost_to_go") return report.mean_cost_to_go;
    if (name == "accumulated_cost") return report.accumulated_cost;
    return kNone;
  });
  report.result = result.interrupted         ? "interrupted"
                  : all_met(report.criteria) ? "passed"
                                             : "criteria not met";
  return report;
}

ordered_json to_json(const ExampleReport& report) {
  ordered_json trials = ordered_json::array();
  for (const Trial& trial : report.trials) {
    trials.push_back({{"succeeded", trial.succeeded},
                      {"accumulated_cost", number(trial.accumulated_cost)},
                      {"mean_cost_to_go", number(trial.mean_cost_to_go)},
                      {"plans_not_rolled_out", trial.plans_not_rolled_out},
                      {"controller_failures", trial.controller_failures},
                      {"plant_failed", trial.plant_failed},
                      {"overshoot", number(trial.overshoot)},
                      {"final_state", numbers(trial.final_state)}});
  }
  return {{"scenario", report.scenario},
          {"seed", report.seed},
          {"result", report.result},
          {"criteria", to_json(report.criteria)},
          {"trials_wanted", report.trials_wanted},
          {"success_rate", number(report.success_rate)},
          {"mean_cost_to_go", number(report.mean_cost_to_go)},
          {"accumulated_cost", number(report.accumulated_cost)},
          {"solves", report.solves},
          {"solve_time_s", quantiles(report.solve_time)},
          {"trials", trials}};
}

std::string summary(const ExampleReport& report) {
  std::string text = fmt::format("{} (seed {}): {}\n", report.scenario, report.seed, report.result);
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("  {:<22}{}\n", name, value);
  };
  const auto shown = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.5g}", value) : std::string("-");
  };
  int succeeded = 0, failures = 0;
  for (const Trial& trial : report.trials) {
    succeeded += trial.succeeded ? 1 : 0;
    failures += trial.controller_failures;
  }
  line("trials", fmt::format("{} of {} succeeded{}", succeeded, report.trials.size(),
                             static_cast<int>(report.trials.size()) < report.trials_wanted
                                 ? fmt::format(" ({} wanted)", report.trials_wanted)
                                 : ""));
  if (report.trials.size() == 1) {
    std::string state;
    for (const double x : report.trials[0].final_state) state += fmt::format(" {:.4g}", x);
    line("final state", state.substr(1));
  }
  line("accumulated cost", shown(report.accumulated_cost));
  line("mean cost-to-go", shown(report.mean_cost_to_go));
  line(report.exact > 0 ? "exact search" : "C3 solve",
       fmt::format("{} solves, p50 {}  p95 {}  p99 {}  max {} ms; {} failed", report.solves,
                   shown(report.solve_time.p50 * 1e3), shown(report.solve_time.p95 * 1e3),
                   shown(report.solve_time.p99 * 1e3), shown(report.solve_time.max * 1e3),
                   failures));
  if (report.exact > 0)
    line("proven to 1e-4", fmt::format("{} of {} solves", report.proven, report.exact));
  for (const CriterionResult& c : report.criteria) {
    line(c.met ? "met" : "NOT MET",
         fmt::format("{}: {} (limit {:g})", c.name, shown(c.value), c.limit));
  }
  return text;
}

}  // namespace c3rt::cli
