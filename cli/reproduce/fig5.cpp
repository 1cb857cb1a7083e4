// Figure 5: pivoting with process noise σ = 0.1 and 0.5.
#include <fmt/format.h>

#include "cli/example/pictures.hpp"
#include "cli/reproduce/loop.hpp"
#include "controller/model/pivoting.hpp"

namespace c3rt::cli::reproduce {

void fig5(const Context& context) {
  using L = model::PivotingLayout;
  ordered_json results = ordered_json::object();
  std::vector<Panel> panels;
  std::vector<std::vector<std::string>> rows{
      {"σ", "α at the end [rad]", "x [m]", "y [m]", "f1 [m]", "f2 [m]", "balanced"},
      {"goal", "0.785", "0", "1.414", "0.9", "0.9", ""}};
  for (const char* sigma : {"0.1", "0.5"}) {
    const ExampleScenario scenario =
        context.scenario("pivoting", {std::string("plant.noise_sigma=") + sigma, "start.trials=1"});
    example::C3Controller controller(scenario.experiment);
    const example::Trajectory run =
        run_loop(context, std::string("Figure 5, σ = ") + sigma, scenario, controller);
    const Eigen::VectorXd end = run.x.rightCols(1);
    rows.push_back({sigma, fmt::format("{:.3f}", end[L::alpha]), fmt::format("{:.3f}", end[L::x]),
                    fmt::format("{:.3f}", end[L::y]), fmt::format("{:.3f}", end[L::finger_1]),
                    fmt::format("{:.3f}", end[L::finger_2]), run.succeeded ? "yes" : "no"});
    std::vector<Panel> all = trajectory_panels(scenario.experiment, run);
    for (std::size_t i : {std::size_t{0}, std::size_t{2}}) {  // the angle and the fingers
      all[i].title = std::string("σ = ") + sigma;
      panels.push_back(all[i]);
    }
    ordered_json& result = results[sigma] = loop_figures(scenario.experiment, run, {});
    result["alpha_rad"] = numbers(run.x.row(L::alpha));
    result["normal_1_n"] = numbers(run.u.row(L::normal_1));
    result["normal_2_n"] = numbers(run.u.row(L::normal_2));
  }
  panels.back().x_label = "time [s]";
  fmt::print("Figure 5: pivoting with process noise of σ × 1 ms per step, equations corrected\n\n");
  print_table(rows);
  context.finish(results, "Figure 5: pivoting with process noise", panels);
}

}  // namespace c3rt::cli::reproduce
