// Figure 3: finger gaiting with s = 10.
#include <cmath>

#include <fmt/format.h>

#include "cli/example/pictures.hpp"
#include "cli/reproduce/loop.hpp"
#include "controller/model/finger_gaiting.hpp"

namespace c3rt::cli::reproduce {

void fig3(const Context& context) {
  // the initial state of the published code
  const ExampleScenario scenario = context.scenario(
      "finger_gaiting", {"c3.admm_iterations=10", "control.duration_s=3", "start.trials=1",
                         "start.x0=[-8, 0, 3, 0, 4, 0]", "start.spread_min=[0, 0, 0, 0, 0, 0]",
                         "start.spread_max=[0, 0, 0, 0, 0, 0]"});
  example::C3Controller controller(scenario.experiment);
  const example::Trajectory run = run_loop(context, "Figure 3", scenario, controller);
  using L = model::FingerGaitingLayout;
  std::vector<std::vector<std::string>> rows{
      {"t [s]", "object", "finger 1", "finger 2", "the authors' code: object"}};
  // object of the published code, run independently with exact projections
  const std::vector<std::pair<double, const char*>> published{
      {0.25, "-6.70"}, {0.5, "-5.03"}, {0.75, "-3.97"}, {1.0, "-3.52"},
      {1.5, "-2.41"},  {2.0, "-1.62"}, {3.0, "-1.10"}};
  for (const auto& [t, object] : published) {
    const Eigen::Index step = std::lround(t / scenario.experiment.simulation_step);
    if (step >= run.x.cols()) break;
    rows.push_back({shown(t), fmt::format("{:.2f}", run.x(L::object, step)),
                    fmt::format("{:.2f}", run.x(L::finger_1, step)),
                    fmt::format("{:.2f}", run.x(L::finger_2, step)), object});
  }
  fmt::print("Figure 3: finger gaiting with s = 10; heights [m]\n\n");
  print_table(rows);
  ordered_json results = loop_figures(scenario.experiment, run, {});
  results["object_m"] = numbers(run.x.row(L::object));
  results["finger_1_m"] = numbers(run.x.row(L::finger_1));
  results["finger_2_m"] = numbers(run.x.row(L::finger_2));
  results["normal_1_n"] = numbers(run.u.row(L::normal_1));
  results["normal_2_n"] = numbers(run.u.row(L::normal_2));
  context.finish(results, "Figure 3: finger gaiting with s = 10",
                 trajectory_panels(scenario.experiment, run));
}

}  // namespace c3rt::cli::reproduce
