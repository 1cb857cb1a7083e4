// Objects from anywhere to a goal pose with sampled places: no table of the C3 paper, but what its
// successors publish [Push Anything, arXiv 2510.19974; push T on hardware, its plotting script].
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "cli/reproduce/context.hpp"
#include "controller/base/quantile.hpp"

namespace c3rt::cli::reproduce {
namespace {

struct Case {
  const char *scenario, *label;
  Overrides overrides;    // what the plant or the sensing has apart from the plan
  const char* published;  // seconds to a goal, of others
};

const std::vector<Case> kCases{
    {"push_box", "box", {}, "-"},
    {"push_t", "T", {}, "mean 26.9, median 22.8"},
    {"push_l", "L", {}, "-"},
    {"push_h", "H", {}, "-"},
    {"push_e", "E", {}, "-"},
    {"push_t_cameras", "T, three cameras", {}, "mean 26.9, median 22.8"},
    {"jack", "jack", {}, "-"},
    {"cone_and_ball", "cone and ball", {}, "-"},
    {"two_objects", "two objects", {}, "mean 96"},
    {"three_objects", "three objects", {}, "mean 192"},
    {"four_objects", "four objects", {}, "mean 318"},
    {"push_t", "T, friction 0.2 on the table", {"plant.objects.0.friction_table=0.2"}, "-"},
    {"push_t", "T, friction 0.8 on the table", {"plant.objects.0.friction_table=0.8"}, "-"},
    {"push_t", "T, plan with half the mass", {"planner.model.mass_scale=0.5"}, "-"},
    {"push_t", "T, plan with twice the mass", {"planner.model.mass_scale=2"}, "-"},
    {"push_t", "T, plan 10 % smaller", {"planner.model.size_scale=0.9"}, "-"},
    {"push_t", "T, plan 10 % larger", {"planner.model.size_scale=1.1"}, "-"},
    {"push_t",
     "T, noise of 3 mm and 1 degree",
     {"vision.emulated.noise_m=0.003", "vision.emulated.angle_noise_rad=0.0175"},
     "-"},
    {"push_t", "T, plans 20 ms late", {"timing.solve_time_s=0.02"}, "-"}};

/// Sorted, of the runs that give it.
std::vector<double> of_runs(const std::vector<Run>& runs, const char* path, double factor) {
  std::vector<double> values;
  for (const Run& run : runs) {
    const ordered_json& value =
        run.report.at(ordered_json::json_pointer(std::string("/task/") + path));
    if (value.is_number()) values.push_back(factor * value.get<double>());
  }
  std::sort(values.begin(), values.end());
  return values;
}

/// @param values sorted
std::string median_and_95(const std::vector<double>& values) {
  if (values.empty()) return "-";
  return fmt::format("{}; {}", shown(base::quantile_linear(values, 0.5), 3),
                     shown(base::quantile_linear(values, 0.95), 3));
}

}  // namespace

void push_anything(const Context& context) {
  const std::vector<std::string> names = scenario_names();
  std::vector<Case> cases;
  std::copy_if(kCases.begin(), kCases.end(), std::back_inserter(cases), [&names](const Case& c) {
    return std::find(names.begin(), names.end(), c.scenario) != names.end();
  });
  if (context.settings().quick) cases.resize(2);
  std::vector<RunSpec> specs;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    RunSpec spec;
    spec.name = fmt::format("{:02}-{}", i, cases[i].scenario);
    spec.scenario = cases[i].scenario;
    spec.seeds = context.settings().seeds;
    spec.overrides = cases[i].overrides;
    spec.in_process = true;
    specs.push_back(spec);
  }
  const std::vector<RunGroup> groups = context.groups(specs);

  ordered_json results{{"what", "push_anything"}, {"seeds", context.settings().seeds}};
  Rows rows{{"", "reached", "share, 95 % interval [%]", "time, median; 95 % [s]",
             "end, median; 95 % [mm]", "and [deg]", "published [s]"}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::vector<Run>& runs = groups[i].runs;
    const ordered_json& success = groups[i].summary.at("success");
    const int reached = success.at("successes");
    const std::vector<double> times = of_runs(runs, "goal_time_s", 1.0),
                              ends = of_runs(runs, "end_position_error_m", 1e3),
                              turns = of_runs(runs, "end_angle_error_rad", 180.0 / M_PI);
    rows.push_back({cases[i].label, fmt::format("{} of {}", reached, runs.size()),
                    fmt::format("{:.0f} to {:.0f}", 100.0 * success.at("low").get<double>(),
                                100.0 * success.at("high").get<double>()),
                    median_and_95(times), median_and_95(ends), median_and_95(turns),
                    cases[i].published});
    results["cases"].push_back({{"case", cases[i].label},
                                {"scenario", cases[i].scenario},
                                {"overrides", cases[i].overrides},
                                {"reached", reached},
                                {"runs", runs.size()},
                                {"goal_times_s", times},
                                {"end_position_errors_mm", ends},
                                {"end_angle_errors_deg", turns}});
  }
  fmt::print(
      "Objects pushed to a goal pose from anywhere, seeds {}: each run as its scenario judges it; "
      "times until the goal is held within the task's tolerance\n\n",
      context.settings().seeds);
  print_table(rows);
  context.finish(results);
}

}  // namespace c3rt::cli::reproduce
