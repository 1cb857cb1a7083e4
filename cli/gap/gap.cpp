#include "cli/gap/gap.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_status.hpp"
#include "cli/gap/decisions.hpp"
#include "cli/gap/recorded.hpp"
#include "cli/paths.hpp"
#include "cli/recorded.hpp"
#include "cli/report/figure.hpp"
#include "cli/report/text_table.hpp"
#include "controller/base/quantile.hpp"
#include "controller/horizon/modes.hpp"
#include "controller/horizon/search.hpp"

namespace c3rt::cli::gap {
namespace fs = std::filesystem;
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr double kMeets = 1e-6;       // in relation to a row's terms: a plan is not solved to more
constexpr double kLeastShown = 1e-3;  // in the picture [%]

/// One plan beside the optimum.
struct Row {
  double t;                  // [s]
  double cost;               // of the plan, simulated; NaN where there is none
  bool meets;                // it meets the constraints
  double optimum;            // the best that is known; NaN where no plan meets the constraints
  double optimum_simulated;  // cost of its inputs, simulated as the plan's are
  double bound;              // no plan costs less
  bool proven;               // optimum and bound differ by no more than was asked for
  double solve_time_s, search_time_s;
  long nodes;
  std::vector<std::pair<double, double>> others;  // of other planners: cost, time of the solve [s]

  /// Of the cost, above what is proven: at most so much too much. NaN where one is missing.
  double above() const { return above(cost); }
  double above(double another_cost) const {
    return another_cost / (proven ? optimum : bound) - 1.0;
  }
};

/// All that is looked at.
struct Work {
  Decisions decisions;
  std::vector<std::vector<Answer>> others;  // of each of the planners, one for each decision
};

/// Ends a search at its limit, or when a person wants.
struct Limit {
  Clock::time_point end;
  const Stop* stop;
  static bool reached(void* context) noexcept {
    const Limit& limit = *static_cast<const Limit*>(context);
    return Clock::now() >= limit.end || (*limit.stop)();
  }
};

Row search(const Work& work, std::size_t index, const Settings& settings, const Stop& stop) {
  const Decisions& decisions = work.decisions;
  const Clock::time_point start = Clock::now();
  Limit limit{start + std::chrono::duration_cast<Clock::duration>(
                          std::chrono::duration<double>(settings.limit_s)),
              &stop};
  const horizon::Problem problem = decisions.problem(index);
  const std::optional<horizon::Plan> plan = decisions.simulated(index, decisions.all[index].u);
  // the plan's own modes, made the best of: where the search begins
  std::optional<horizon::Plan> known;
  if (plan) known = horizon::solve_modes(problem, horizon::modes(problem, *plan));
  const horizon::SearchResult found =
      horizon::search(problem, {std::numeric_limits<long>::max(), settings.relative_gap}, known,
                      {&Limit::reached, &limit});
  const double search_time_s = std::chrono::duration<double>(Clock::now() - start).count();
  const auto cost_of = [&](const Eigen::MatrixXd& u) {
    const std::optional<horizon::Plan> came = decisions.simulated(index, u);
    return came ? came->objective : kNone;
  };
  std::vector<std::pair<double, double>> others;
  for (const std::vector<Answer>& answers : work.others)
    others.emplace_back(cost_of(answers[index].u), answers[index].solve_time_s);
  return {decisions.all[index].t,
          plan ? plan->objective : kNone,
          plan && horizon::residual(problem, *plan) <= kMeets,
          found.plan ? found.plan->objective : kNone,
          found.plan ? cost_of(found.plan->u) : kNone,
          found.lower_bound,
          found.is_proven(),
          decisions.all[index].solve_time_s,
          search_time_s,
          found.nodes,
          others};
}

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

ordered_json to_json(const Row& row, const std::vector<std::string>& planners) {
  ordered_json json{{"time_s", row.t},
                    {"cost", number(row.cost)},
                    {"meets_constraints", row.meets},
                    {"optimum", number(row.optimum)},
                    {"optimum_simulated", number(row.optimum_simulated)},
                    {"lower_bound", number(row.bound)},
                    {"proven", row.proven},
                    {"above", number(row.above())},
                    {"solve_time_s", row.solve_time_s},
                    {"search_time_s", row.search_time_s},
                    {"nodes", row.nodes}};
  for (std::size_t i = 0; i < planners.size(); ++i) {
    json["planners"][planners[i]] = {{"cost", number(row.others[i].first)},
                                     {"solve_time_s", row.others[i].second}};
  }
  return json;
}

std::string percent(double share) { return shown(100.0 * share, 3) + " %"; }

/// Of the plans that have a figure, sorted.
template <typename Above>
std::vector<double> figures(const std::vector<Row>& rows, Above above) {
  std::vector<double> all;
  for (const Row& row : rows) {
    if (std::isfinite(above(row))) all.push_back(above(row));
  }
  std::sort(all.begin(), all.end());
  return all;
}
std::vector<double> figures(const std::vector<Row>& rows) {
  return figures(rows, [](const Row& row) { return row.above(); });
}

/// @param above sorted
std::vector<std::string> table_row(const std::string& name, const std::vector<double>& above) {
  if (above.empty()) return {name, "-", "-", "-"};
  return {name, percent(base::quantile_linear(above, 0.5)),
          percent(base::quantile_linear(above, 0.9)), percent(above.back())};
}

Rows table(const std::vector<Row>& rows, const std::vector<std::string>& planners) {
  Rows table{{"", "median", "90 %", "worst"}, table_row("above the optimum", figures(rows))};
  for (std::size_t i = 0; i < planners.size(); ++i) {
    const auto above = [i](const Row& row) { return row.above(row.others[i].first); };
    table.push_back(table_row("by " + fs::path(planners[i]).stem().string(), figures(rows, above)));
  }
  return table;
}

Figure picture(const Decisions& decisions, const std::vector<Row>& rows) {
  Curve curve{"C3's plan, simulated", kBlue, {}, {}, false, true};
  const auto count = static_cast<Eigen::Index>(rows.size());
  curve.x = Eigen::VectorXd::LinSpaced(count, 0.0, static_cast<double>(count - 1));
  curve.y.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double above = rows[static_cast<std::size_t>(i)].above();
    // a logarithm has no 0
    curve.y[i] = std::isfinite(above) ? std::max(kLeastShown, 100.0 * above) : kNone;
  }
  Panel panel{"", "control step", "above [%]", {curve}, {}, true};
  panel.legend_below = true;
  return {decisions.name + ": plans above the optimum of (15)", {panel}, 1, 900, 420};
}

std::string one_problem(const Row& row) {
  return fmt::format("cost {:.6g}, optimum {:.6g}, no plan below {:.6g}: {} above", row.cost,
                     row.optimum, row.bound, percent(row.above()));
}

Work of_recording(const Settings& settings) {
  const std::string& file = settings.what;
  Listener nobody;
  Contents contents;
  try {
    contents = play(file, nobody);
  } catch (const mcap::Error& error) {
    throw UsageError(error.what());
  }
  config::Scenario scenario = scenario_of(contents, file, "", settings.overrides);
  scenario.planner.c3.polish = settings.polish.value_or(scenario.planner.c3.polish);
  std::vector<config::Scenario> planners;
  for (const std::string& name : settings.planners)
    planners.push_back(config::load_scenario(scenario_path(name).string(), {}));
  const std::vector<Question> asked = questions(file, scenario, settings.states);
  Work work{of_questions(asked, scenario), {}};
  for (const config::Scenario& planner : planners) work.others.push_back(answers(asked, planner));
  return work;
}

Work work_of(const Settings& settings, const Stop& stop) {
  const fs::path file = settings.what;
  if (file.extension() == ".mcap") return of_recording(settings);
  if (!settings.planners.empty())
    throw UsageError("--planner: of a recording (.mcap), got " + settings.what);
  if (file.extension() == ".json") {
    if (!settings.overrides.empty())
      throw UsageError("--set: a problem file has its settings in params, " + settings.what);
    config::ProblemFile problem = config::load_problem(settings.what);
    problem.settings.polish = settings.polish.value_or(problem.settings.polish);
    return {of_problem(problem, file.stem().string()), {}};
  }
  const fs::path scenario = scenario_path(settings.what);
  if (!is_example(scenario)) {
    throw UsageError(
        "expected a problem file (.json), a recording (.mcap) or a numerical example, got " +
        settings.what + ", whose planner is no example");
  }
  ExampleScenario example = load_example(scenario, settings.overrides);
  example.experiment.c3.polish = settings.polish.value_or(example.experiment.c3.polish);
  return {of_example(example, settings.seed, settings.states, stop), {}};
}

}  // namespace

int run(const Settings& settings, const Stop& stop) {
  const Work work = work_of(settings, stop);
  const Decisions& decisions = work.decisions;
  const fs::path folder = make_folder(
      settings.out.empty() ? fs::path("out") / ("gap-" + decisions.name) : fs::path(settings.out));
  fmt::print("c3rt gap {}: {} plans, an exact search of at most {:g} s each, in {}\n",
             decisions.name, decisions.all.size(), settings.limit_s, folder.string());
  std::fflush(stdout);
  std::vector<Row> rows;
  {
    Progress progress("gap " + decisions.name);
    while (rows.size() < decisions.all.size() && !stop()) {
      progress.update(static_cast<double>(rows.size()) / static_cast<double>(decisions.all.size()),
                      fmt::format("plan {} of {}", rows.size() + 1, decisions.all.size()));
      const Row row = search(work, rows.size(), settings, stop);
      if (!stop()) rows.push_back(row);
    }
  }
  ordered_json states = ordered_json::array();
  for (const Row& row : rows) states.push_back(to_json(row, settings.planners));
  const bool complete = rows.size() == decisions.all.size();
  const auto proven =
      std::count_if(rows.begin(), rows.end(), [](const Row& r) { return r.proven; });
  const std::vector<double> above = figures(rows);
  ordered_json json{{"name", decisions.name}, {"overrides", settings.overrides},
                    {"complete", complete},   {"relative_gap", settings.relative_gap},
                    {"proven", proven},       {"plans", rows.size()}};
  if (!above.empty()) {
    json["above"] = {{"median", base::quantile_linear(above, 0.5)},
                     {"p90", base::quantile_linear(above, 0.9)},
                     {"worst", above.back()}};
  }
  json["states"] = states;
  write_text(folder / "gap.json", json.dump(1) + "\n");
  if (above.empty()) {
    const bool no_plans = std::none_of(rows.begin(), rows.end(),
                                       [](const Row& row) { return std::isfinite(row.cost); });
    const std::string limit = fmt::format("no bound within {:g} s", settings.limit_s);
    fmt::print(stderr, "c3rt: nothing to compare: {}\n",
               !complete  ? "interrupted"
               : no_plans ? "no plan can be simulated"
                          : limit.c_str());
    return complete && !no_plans ? kUndecided : kCriterionFailed;
  }
  if (rows.size() == 1) {
    fmt::print("  {}\n", one_problem(rows.front()));
  } else {
    const std::string missing = draw({{folder / "gap.png", picture(decisions, rows)}});
    fmt::print("\n{}\n", text_table(table(rows, settings.planners)));
    if (!missing.empty()) fmt::print(stderr, "c3rt: {}\n", missing);
  }
  if (above.size() < rows.size())
    fmt::print("  {} of {} plans cannot be simulated\n", rows.size() - above.size(), rows.size());
  const auto breaking = std::count_if(rows.begin(), rows.end(), [](const Row& row) {
    return std::isfinite(row.cost) && !row.meets;
  });
  if (breaking > 0) {
    fmt::print("  {} of {} plans do not meet the constraints, which the optimum does\n", breaking,
               rows.size());
  }
  if (static_cast<std::size_t>(proven) < rows.size()) {
    fmt::print(
        "  {} of {} optima are not proven within {:g} s: of these plans the figure is the "
        "distance to a proven bound\n",
        rows.size() - static_cast<std::size_t>(proven), rows.size(), settings.limit_s);
  }
  fmt::print("  {:<16}{}\n", "results in", folder.string());
  if (!complete) {
    fmt::print(stderr, "interrupted after {} of {} plans\n", rows.size(), decisions.all.size());
    return kCriterionFailed;
  }
  return static_cast<std::size_t>(proven) == rows.size() ? kDone : kUndecided;
}

}  // namespace c3rt::cli::gap
