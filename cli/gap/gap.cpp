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

using Eigen::VectorXd;
using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMeets = 1e-6;       // in relation to a row's terms: a plan is not solved to more
constexpr double kLeastShown = 1e-3;  // in the picture [%]

/// A planner's plan, simulated.
struct Judged {
  double cost;  // NaN where there is none
  bool meets;   // it meets the constraints
  double solve_time_s;
  double first_input = kNone;  // cost of the best that follows its first input, where it is asked
};

/// A state's plans beside the optimum.
struct Row {
  double t;                   // [s]
  std::vector<Judged> plans;  // the own, then those of other planners
  double optimum;             // the best that is known; NaN where no plan meets the constraints
  double optimum_simulated;   // cost of its inputs, simulated as the plans are
  double bound;               // no plan costs less
  bool proven;                // optimum and bound differ by no more than was asked for
  double search_time_s;
  long nodes;

  /// Of a cost, above what is proven: at most so much too much. NaN where one is missing.
  double above(double cost) const { return cost / (proven ? optimum : bound) - 1.0; }
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

/// The optimum where the first input is given. Its modes, made the best of, are where it begins.
/// @param plan that has this first input
double best_after(const horizon::Problem& problem, const horizon::Plan& plan, double relative_gap,
                  const c3::Deadline& deadline) {
  const c3::Sizes& sizes = problem.sizes;
  c3::Constraints held = *problem.constraints;
  const auto bounds = [&](const qp::PerStage<VectorXd>& of, double where_there_is_none) {
    std::vector<VectorXd> all{plan.u.col(0)};
    for (int k = 1; k < sizes.N; ++k) {
      all.push_back(of[k].size() > 0 ? of[k] : VectorXd::Constant(sizes.n_u, where_there_is_none));
    }
    return all;
  };
  held.u_min = bounds(problem.constraints->u_min, -kInfinity);
  held.u_max = bounds(problem.constraints->u_max, kInfinity);
  horizon::Problem rest = problem;
  rest.constraints = &held;
  const horizon::SearchResult found =
      horizon::search(rest, {std::numeric_limits<long>::max(), relative_gap},
                      horizon::solve_modes(rest, horizon::modes(rest, plan)), deadline);
  return found.plan ? found.plan->objective : kNone;
}

Row search(const Work& work, std::size_t index, const Settings& settings, const Stop& stop) {
  const Decisions& decisions = work.decisions;
  const horizon::Problem problem = decisions.problem(index);
  Limit limit{{}, &stop};
  const auto deadline = [&]() -> c3::Deadline {
    limit.end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(settings.limit_s));
    return {&Limit::reached, &limit};
  };
  std::vector<Answer> answers{{decisions.all[index].u, decisions.all[index].solve_time_s}};
  for (const std::vector<Answer>& of_planner : work.others) answers.push_back(of_planner[index]);
  std::vector<std::optional<horizon::Plan>> plans;
  for (const Answer& answer : answers) plans.push_back(decisions.simulated(index, answer.u));

  const double began = processor_seconds_now();
  // the plans' own modes, made the best of: where the search begins
  std::optional<horizon::Plan> known;
  for (const std::optional<horizon::Plan>& plan : plans) {
    if (!plan) continue;
    const auto best_of_modes = horizon::solve_modes(problem, horizon::modes(problem, *plan));
    if (best_of_modes && (!known || best_of_modes->objective < known->objective))
      known = best_of_modes;
  }
  const horizon::SearchResult found = horizon::search(
      problem, {std::numeric_limits<long>::max(), settings.relative_gap}, known, deadline());
  const double search_time_s = processor_seconds_now() - began;

  std::vector<Judged> judged;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    judged.push_back({plans[i] ? plans[i]->objective : kNone,
                      plans[i] && horizon::residual(problem, *plans[i]) <= kMeets,
                      answers[i].solve_time_s});
    if (settings.first_input && plans[i])
      judged.back().first_input = best_after(problem, *plans[i], settings.relative_gap, deadline());
  }
  std::optional<horizon::Plan> optimum;
  if (found.plan) optimum = decisions.simulated(index, found.plan->u);
  return {decisions.all[index].t,
          judged,
          found.plan ? found.plan->objective : kNone,
          optimum ? optimum->objective : kNone,
          found.lower_bound,
          found.is_proven(),
          search_time_s,
          found.nodes};
}

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

ordered_json to_json(const Row& row, const Judged& plan, bool first_input) {
  ordered_json json{{"cost", number(plan.cost)},
                    {"meets_constraints", plan.meets},
                    {"above", number(row.above(plan.cost))}};
  if (first_input) json["first_input_above"] = number(row.above(plan.first_input));
  json["solve_time_s"] = plan.solve_time_s;
  return json;
}

ordered_json to_json(const Row& row, const Settings& settings) {
  ordered_json json{{"time_s", row.t}};
  json.update(to_json(row, row.plans.front(), settings.first_input));
  json.update({{"optimum", number(row.optimum)},
               {"optimum_simulated", number(row.optimum_simulated)},
               {"lower_bound", number(row.bound)},
               {"proven", row.proven},
               {"search_time_s", row.search_time_s},
               {"nodes", row.nodes}});
  for (std::size_t i = 0; i < settings.planners.size(); ++i) {
    json["planners"][settings.planners[i]] = to_json(row, row.plans[i + 1], settings.first_input);
  }
  return json;
}

std::string percent(double share) { return shown(100.0 * share, 3) + " %"; }

/// Those that are there, sorted.
/// @param of the figure of a row and of one plan there
template <typename Of>
std::vector<double> figures(const std::vector<Row>& rows, std::size_t planner, Of of) {
  std::vector<double> all;
  for (const Row& row : rows) {
    const double figure = of(row, row.plans[planner]);
    if (std::isfinite(figure)) all.push_back(figure);
  }
  std::sort(all.begin(), all.end());
  return all;
}
std::vector<double> above(const std::vector<Row>& rows, std::size_t planner = 0) {
  return figures(rows, planner,
                 [](const Row& row, const Judged& plan) { return row.above(plan.cost); });
}

/// The own planner is 0, the others follow.
std::string planner_name(const Settings& settings, std::size_t planner) {
  return planner == 0 ? "above the optimum"
                      : "by " + fs::path(settings.planners[planner - 1]).stem().string();
}

Rows table(const std::vector<Row>& rows, const Settings& settings) {
  std::vector<std::string> head{"", "median", "90 %", "worst"};
  if (settings.first_input) head.insert(head.end(), {"first input: median", "worst"});
  head.insert(head.end(), {"plans", "solve [ms]"});
  Rows table{head};
  for (std::size_t i = 0; i <= settings.planners.size(); ++i) {
    std::vector<std::string> cells{planner_name(settings, i)};
    const auto add = [&cells](const std::vector<double>& sorted,
                              const std::vector<double>& shares) {
      for (const double share : shares)
        cells.push_back(sorted.empty() ? "-" : percent(base::quantile_linear(sorted, share)));
    };
    add(above(rows, i), {0.5, 0.9, 1.0});
    if (settings.first_input) {
      add(figures(rows, i,
                  [](const Row& row, const Judged& p) { return row.above(p.first_input); }),
          {0.5, 1.0});
    }
    const auto cost = [](const Row&, const Judged& plan) { return plan.cost; };
    const auto time = [](const Row&, const Judged& plan) { return plan.solve_time_s; };
    cells.push_back(fmt::format("{} of {}", figures(rows, i, cost).size(), rows.size()));
    cells.push_back(shown(1e3 * base::quantile_linear(figures(rows, i, time), 0.5), 3));
    table.push_back(cells);
  }
  return table;
}

Figure picture(const Decisions& decisions, const std::vector<Row>& rows, const Settings& settings) {
  Panel panel{"", "control step", "above [%]", {}, {}, true};
  const auto count = static_cast<Eigen::Index>(rows.size());
  for (std::size_t planner = 0; planner <= settings.planners.size(); ++planner) {
    Curve curve{planner == 0 ? "the plan, simulated" : planner_name(settings, planner),
                "",
                Eigen::VectorXd::LinSpaced(count, 0.0, static_cast<double>(count - 1)),
                Eigen::VectorXd(count),
                false,
                true};
    for (Eigen::Index i = 0; i < count; ++i) {
      const Row& row = rows[static_cast<std::size_t>(i)];
      const double of_plan = row.above(row.plans[planner].cost);
      // a logarithm has no 0
      curve.y[i] = std::isfinite(of_plan) ? std::max(kLeastShown, 100.0 * of_plan) : kNone;
    }
    panel.curves.push_back(curve);
  }
  panel.legend_below = true;
  return {decisions.name + ": plans above the optimum of (15)", {panel}, 1, 900, 420};
}

std::string one_problem(const Row& row) {
  const Judged& plan = row.plans.front();
  std::string text = fmt::format("cost {:.6g}, optimum {:.6g}, no plan below {:.6g}: {} above",
                                 plan.cost, row.optimum, row.bound, percent(row.above(plan.cost)));
  if (std::isfinite(plan.first_input))
    text += fmt::format("; the first input alone {}", percent(row.above(plan.first_input)));
  return text;
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
  for (const config::Scenario& planner : planners)
    work.others.push_back(answers(asked, scenario, planner));
  return work;
}

Work work_of(const Settings& settings, const Stop& stop) {
  const fs::path file = settings.what;
  if (file.extension() == ".mcap") return of_recording(settings);
  if (file.extension() == ".json") {
    if (!settings.planners.empty())
      throw UsageError("--planner: of an example or a recording (.mcap), got " + settings.what);
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
  std::vector<ExampleScenario> planners;
  for (const std::string& name : settings.planners) {
    const fs::path of_planner = scenario_path(name);
    if (!is_example(of_planner))
      throw UsageError("--planner: expected a numerical example, got " + name);
    planners.push_back(load_example(of_planner));
  }
  Work work{of_example(example, settings.seed, settings.states, stop), {}};
  for (const ExampleScenario& planner : planners)
    work.others.push_back(answers(work.decisions, example, planner));
  return work;
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
  for (const Row& row : rows) states.push_back(to_json(row, settings));
  const bool complete = rows.size() == decisions.all.size();
  const auto proven =
      std::count_if(rows.begin(), rows.end(), [](const Row& r) { return r.proven; });
  const std::vector<double> own = above(rows);
  ordered_json json{{"name", decisions.name}, {"overrides", settings.overrides},
                    {"complete", complete},   {"relative_gap", settings.relative_gap},
                    {"proven", proven},       {"plans", rows.size()}};
  if (!own.empty()) {
    json["above"] = {{"median", base::quantile_linear(own, 0.5)},
                     {"p90", base::quantile_linear(own, 0.9)},
                     {"worst", own.back()}};
  }
  json["states"] = states;
  write_text(folder / "gap.json", json.dump(1) + "\n");
  if (own.empty()) {
    const bool no_plans = std::none_of(rows.begin(), rows.end(), [](const Row& row) {
      return std::isfinite(row.plans.front().cost);
    });
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
    const std::string missing = draw({{folder / "gap.png", picture(decisions, rows, settings)}});
    fmt::print("\n{}\n", text_table(table(rows, settings)));
    if (!missing.empty()) fmt::print(stderr, "c3rt: {}\n", missing);
  }
  if (own.size() < rows.size())
    fmt::print("  {} of {} plans cannot be simulated\n", rows.size() - own.size(), rows.size());
  const auto breaking = std::count_if(rows.begin(), rows.end(), [](const Row& row) {
    return std::isfinite(row.plans.front().cost) && !row.plans.front().meets;
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
