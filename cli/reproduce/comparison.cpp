// The single object's circle with every projection, and the monolithic problem (15) on the states
// of such a run: no table of the paper, but what its section VII-A says of (15).
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "cli/reproduce/open_loop.hpp"
#include "cli/reproduce/rolling.hpp"
#include "controller/base/quantile.hpp"

namespace c3rt::cli::reproduce {
namespace {

struct Variant {
  const char *name, *label;
  Overrides overrides;  // where the projection has no scenario of its own
};

const std::vector<Variant> kVariants{
    {"miqp", "C3, exact MIQP", {}},
    {"lcp", "C3, LCP", {"planner.c3.projection=lcp"}},
    {"admm", "C3, ADMM", {"planner.c3.projection=admm"}},
    {"convex",
     "C3, convex",
     {"planner.c3.projection=convex", "planner.model.contact_model=anitescu"}},
    {"plus", "C3+", {"planner.c3.projection=plus"}}};
const std::vector<std::string> kScenarios{"circle_slow", "circle_fast"};
constexpr int kQuestions = 40;

/// The scenario with settings of the projection's own, if there is one, else that of all.
RunSpec spec_of(const std::string& scenario, const Variant& variant) {
  const std::vector<std::string> names = scenario_names();
  const std::string own = scenario + "_" + variant.name;
  RunSpec spec;
  if (std::find(names.begin(), names.end(), own) != names.end()) {
    spec.scenario = own;
  } else {
    spec.scenario = scenario;
    spec.overrides = variant.overrides;
  }
  return spec;
}

/// Median over the runs of one figure of their reports; NaN where none gives it.
template <typename Figure>
double median(const std::vector<Run>& runs, Figure figure_of) {
  std::vector<double> values;
  for (const Run& run : runs) {
    const double value = figure_of(run.report);
    if (std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return kNone;
  std::sort(values.begin(), values.end());
  return base::quantile_linear(values, 0.5);
}

/// Each question's cost above that of the best answer to it that anybody found.
std::vector<double> excess(const std::vector<double>& costs, const std::vector<double>& best) {
  std::vector<double> shares;
  for (std::size_t i = 0; i < costs.size(); ++i) shares.push_back(costs[i] / best[i] - 1.0);
  return shares;
}

void closed_loop(const Context& context, const std::string& scenario, Rows& rows,
                 ordered_json& results) {
  std::vector<RunSpec> specs;
  for (const Variant& variant : kVariants) {
    RunSpec spec = spec_of(scenario, variant);
    spec.name = fmt::format("{}-{}", scenario, variant.name);
    spec.seeds = context.settings().seeds;
    specs.push_back(spec);
  }
  const std::vector<RunGroup> groups = context.groups(specs);
  rows.push_back({scenario + ", closed loop"});
  for (std::size_t i = 0; i < kVariants.size(); ++i) {
    const std::vector<Run>& runs = groups[i].runs;
    const ordered_json& success = groups[i].summary.at("success");
    const auto value = [&runs](const char* path, double factor) {
      const auto of_report = [path](const ordered_json& report) { return figure(report, path); };
      return shown(median(runs, of_report) * factor, 3);
    };
    const double seconds_a_circle = median(runs, mean_loop_time);
    rows.push_back({kVariants[i].label,
                    fmt::format("{} of {}", success.at("successes").get<int>(),
                                success.at("count").get<int>()),
                    value("loops_completed", 1), shown(seconds_a_circle, 3),
                    value("objects.0.in_band_2cm", 100), value("objects.0.in_band_1cm", 100),
                    value("objects.0.rms_error_m", 1e3), value("objects.0.max_error_m", 1e3),
                    value("planner.solve_time_s.p50", 1e3),
                    value("planner.solve_time_s.p99", 1e3)});
    results[scenario][kVariants[i].name] = groups[i].summary;
    results[scenario][kVariants[i].name]["seconds_a_circle"] = cli::number(seconds_a_circle);
    results[scenario][kVariants[i].name]["scenario"] = runs.front().spec.scenario;
    results[scenario][kVariants[i].name]["overrides"] = runs.front().spec.overrides;
  }
}

ordered_json to_json(const std::vector<double>& values) {
  return numbers(
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
}

void open_loop(const Context& context, Rows& rows, ordered_json& results) {
  RunSpec spec = spec_of(kScenarios.front(), kVariants.front());
  spec.name = "recorded";
  spec.logs = true;
  const Run run = context.runs({spec}).front();
  const config::Scenario judge = scenario_of(spec);
  const std::vector<Question> asked = questions(run, judge, kQuestions);
  const double period = 1.0 / judge.planner.rate;  // what a planner has for one answer [s]

  std::vector<std::pair<std::string, Answers>> answers;
  for (const Variant& variant : kVariants)
    answers.emplace_back(
        variant.label,
        answer_with_c3(asked, scenario_of(spec_of(kScenarios.front(), variant)), judge));
  const ordered_json kept = context.part(
      "monolithic", spec.scenario, spec.overrides,
      {{"limit_s", context.settings().miqp_limit}, {"log_hash", run.report.at("log_hash")}}, [&] {
        const MonolithicAnswers monolithic =
            answer_monolithic(asked, judge, context.settings().miqp_limit, context);
        return ordered_json{{"costs", to_json(monolithic.costs)},
                            {"times_s", to_json(monolithic.times)},
                            {"proven", monolithic.proven}};
      });
  const auto list = [&kept](const char* name) {
    const Eigen::VectorXd values = to_vector(kept.at(name));
    return std::vector<double>(values.begin(), values.end());
  };
  answers.emplace_back(fmt::format("(15), exact search, {:g} s", context.settings().miqp_limit),
                       Answers{list("costs"), list("times_s")});

  std::vector<double> best(asked.size(), std::numeric_limits<double>::infinity());
  for (const auto& [label, answer] : answers) {
    for (std::size_t i = 0; i < best.size(); ++i) {
      if (answer.costs[i] < best[i]) best[i] = answer.costs[i];
    }
  }
  rows.push_back({"", "answers", "cost above best, p50 [%]", "p95 [%]", "time, p50 [ms]",
                  "p95 [ms]", fmt::format("in a period of {:g} ms [%]", 1e3 * period)});
  rows.push_back({fmt::format("{} states of {}, open loop", asked.size(), spec.scenario)});
  for (const auto& [label, answer] : answers) {
    const std::vector<double> above = excess(answer.costs, best);
    std::vector<double> finite;
    std::copy_if(above.begin(), above.end(), std::back_inserter(finite),
                 [](double v) { return std::isfinite(v); });
    std::sort(finite.begin(), finite.end());
    std::vector<double> times = answer.times;
    std::sort(times.begin(), times.end());
    const auto fast =
        std::count_if(times.begin(), times.end(), [&](double time) { return time <= period; });
    const auto share = [&](double p) {
      return finite.empty() ? "-" : shown(100.0 * base::quantile_linear(finite, p), 3);
    };
    rows.push_back(
        {label, fmt::format("{} of {}", finite.size(), asked.size()), share(0.5), share(0.95),
         shown(1e3 * base::quantile_linear(times, 0.5), 3),
         shown(1e3 * base::quantile_linear(times, 0.95), 3),
         shown(100.0 * static_cast<double>(fast) / static_cast<double>(times.size()), 3)});
    results["open_loop"][label] = {{"costs", to_json(answer.costs)},
                                   {"times_s", to_json(answer.times)}};
  }
  results["open_loop"]["proven"] = kept.at("proven");
  results["open_loop"]["states"] = asked.size();
  rows.push_back(
      {fmt::format("(15) proven to 1e-4: {} of {}", kept.at("proven").get<int>(), asked.size())});
}

}  // namespace

void comparison(const Context& context) {
  ordered_json results{{"what", "comparison"},
                       {"seeds", context.settings().seeds},
                       {"paper", "VII-A: C3 at 73 Hz succeeds; (15) at about 5 Hz fails"}};
  Rows closed{{"", "passed", "circles", "s a circle", "in 2 cm [%]", "in 1 cm [%]", "rms [mm]",
               "max [mm]", "solve p50 [ms]", "p99 [ms]"}};
  for (const std::string& scenario : kScenarios) closed_loop(context, scenario, closed, results);
  Rows open;
  open_loop(context, open, results);
  fmt::print("The circle with every projection, lockstep, seeds {}, medians over the seeds\n\n",
             context.settings().seeds);
  print_table(closed);
  fmt::print(
      "\nThe same question to all: the cost of (15) when the planning system is simulated with "
      "each one's inputs\n\n");
  print_table(open);
  context.finish(results);
}

}  // namespace c3rt::cli::reproduce
