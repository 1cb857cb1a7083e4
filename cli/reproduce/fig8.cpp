// Figure 8: the cost-to-go that C3 and the MIQP expect along a run of the nonlinear cart-pole, and
// the one that came.
#include <cmath>

#include <fmt/format.h>

#include "cli/reproduce/loop.hpp"

namespace c3rt::cli::reproduce {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr const char* kHardware = "cart_pole_hardware";

/// The cost (14) of what the plant did in the N control steps from each on; kNone near the end.
VectorXd actual_costs(const example::Experiment& experiment, const example::Trajectory& run) {
  const Index held = std::lround(experiment.control_period / experiment.simulation_step);
  const Index decisions = run.cost_to_go.size();
  VectorXd costs = VectorXd::Constant(decisions, kNone);
  for (Index i = 0; (i + experiment.N) * held < run.x.cols(); ++i) {
    double cost = 0.0;
    for (Index k = i; k < i + experiment.N; ++k)
      cost += example::stage_cost(experiment, run.x.col(k * held), run.u.col(k * held));
    const VectorXd e = run.x.col((i + experiment.N) * held) - experiment.x_desired;
    costs[i] = cost + e.dot(experiment.costs.Q_N * e);
  }
  return costs;
}

/// The states of the run, decided upon anew by the MIQP.
VectorXd monolithic_costs(const Context& context, const example::Experiment& experiment,
                          const example::Trajectory& run, int& proven) {
  MonolithicController miqp(experiment, experiment, context.settings().miqp_limit,
                            [&context] { return context.stopped(); });
  const Index held = std::lround(experiment.control_period / experiment.simulation_step);
  const Index decisions = run.cost_to_go.size();
  VectorXd costs = VectorXd::Constant(decisions, kNone);
  Progress progress("Figure 8, MIQP");
  for (Index i = 0; i < decisions; ++i) {
    progress.update(static_cast<double>(i) / static_cast<double>(decisions),
                    fmt::format("state {} of {}", i + 1, decisions));
    const VectorXd x = run.x.col(i * held);
    const lcs::Lcs lcs = example::planning_system(experiment, x);
    const Eigen::MatrixXd* u = miqp.decide(lcs, x, 0.0);
    if (context.stopped()) throw Interrupted{};
    if (u != nullptr) costs[i] = example::cost_to_go(experiment, lcs, x, *u);
  }
  proven = miqp.proven();
  return costs;
}

ordered_json measure(const Context& context) {
  const example::Experiment experiment = context.scenario(kHardware, {}).experiment;
  const ExampleScenario scenario = context.scenario(kHardware, {});
  example::C3Controller controller(experiment);
  const example::Trajectory run = run_loop(context, "Figure 8, C3", scenario, controller);
  int proven = 0;
  const VectorXd miqp = monolithic_costs(context, experiment, run, proven);
  return {{"c3", numbers(run.cost_to_go)},
          {"miqp", numbers(miqp)},
          {"miqp_proven", proven},
          {"actual", numbers(actual_costs(experiment, run))},
          {"period_s", experiment.control_period}};
}

}  // namespace

void fig8(const Context& context) {
  const ordered_json costs =
      context.part("costs", kHardware, {}, {{"miqp_limit_s", context.settings().miqp_limit}},
                   [&] { return measure(context); });
  const VectorXd c3 = to_vector(costs["c3"]), miqp = to_vector(costs["miqp"]),
                 actual = to_vector(costs["actual"]);
  const VectorXd times = VectorXd::LinSpaced(
      c3.size(), 0.0, costs["period_s"].get<double>() * static_cast<double>(c3.size() - 1));
  const Index known = (actual.array().isFinite()).count();
  std::vector<std::vector<std::string>> rows{{"cost-to-go", "mean", "largest"}};
  const auto row = [&](const char* name, const VectorXd& cost) {
    rows.push_back({name, shown(cost.head(known).mean()), shown(cost.head(known).maxCoeff())});
  };
  // relative to costs near zero, the search's own gap would be all that is left
  const double c3_excess =
      (miqp.array() > 1.0).select((c3 - miqp).array() / miqp.array(), 0.0).maxCoeff();
  row("C3's inputs, predicted by the LCS", c3);
  row("MIQP's inputs, predicted by the LCS", miqp);
  row("what the plant did", actual);
  fmt::print("Figure 8: cost-to-go (14) along a run of the nonlinear cart-pole\n\n");
  print_table(rows);
  fmt::print(
      "\nMIQP: {} of {} calls proven within a gap of 1e-4; C3's cost is at most {:.2g} % above "
      "where it is over 1\n",
      costs["miqp_proven"].get<int>(), c3.size(), 100.0 * c3_excess);
  const std::vector<Curve> curves{{"actual", "#202020", times, actual},
                                  {"C3", "#1f5fd0", times, c3},
                                  {"MIQP", "#d04020", times, miqp, true}};
  const example::Disturbance push = context.scenario(kHardware, {}).experiment.disturbance;
  const std::vector<Shade> shades{
      {"disturbance", "#e4e4e4", 0.0, 1.0, {{push.start, push.start + push.duration}}}};
  context.finish(costs, "Figure 8: cost-to-go of the cart-pole experiment",
                 {{"", "", "cost-to-go", curves, shades},
                  {"", "time [s]", "cost-to-go", curves, shades, true}});
}

}  // namespace c3rt::cli::reproduce
