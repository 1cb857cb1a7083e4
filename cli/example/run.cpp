#include "cli/example/run.hpp"

#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/example/pictures.hpp"
#include "cli/example/tables.hpp"
#include "cli/example/trials.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"

namespace c3rt::cli {

int run_example(const ExampleSettings& settings, const Stop& stop) {
  const ExampleScenario scenario = load_example(settings.file, settings.overrides);
  const std::filesystem::path out = make_folder(
      settings.out.empty() ? new_folder(scenario.name) : std::filesystem::path(settings.out));
  fmt::print("c3rt run {} (seed {}): {}\nresults in {}\n", scenario.name, settings.seed,
             scenario.description, out.string());
  std::fflush(stdout);

  const TrialsResult result = run_trials(scenario, settings.seed, stop, settings.deciding);
  const ExampleReport report = report_on(scenario, settings.seed, result);
  write_text(out / "report.json", to_json(report).dump(2) + "\n");
  write_decisions(out / "decisions.csv", scenario.experiment, result);
  if (settings.deciding.trace) write_iterates(out / "iterates.csv", scenario.experiment, result);
  write_trajectory(out / "trajectory.csv", scenario.experiment, result.first);
  const std::string missing = draw({{out / "trajectory.png",
                                     {fmt::format("{}, first trial", scenario.name),
                                      trajectory_panels(scenario.experiment, result.first)}}});

  fmt::print("\n{}", summary(report));
  if (!missing.empty()) fmt::print(stderr, "c3rt: {}\n", missing);
  fmt::print("  {:<22}{}\n", "report and picture", out.string());
  std::fflush(stdout);
  return report.result == "passed" ? kDone : kCriterionFailed;
}

}  // namespace c3rt::cli
