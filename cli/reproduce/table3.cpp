// Table III: the projections on the cart-pole between soft walls.
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "cli/reproduce/loop.hpp"
#include "controller/c3/projection.hpp"

namespace c3rt::cli::reproduce {
namespace {

constexpr const char* kCartPole = "cart_pole";

struct Method {
  std::string key, name, color;
  // the paper's; the authors' code on one core of a 2-core machine, without its limit of 1 ms
  const char *paper_time, *paper_cost, *authors_time, *authors_cost;
};

const std::vector<Method>& methods() {
  static const std::vector<Method> all{
      {"lcp", "LCP", "#1f5fd0", "14 ± 1.8", "22.09", "14.4 ± 4.6", "22.12"},
      {"miqp", "MIQP, exact", "#d04020", "1000 ± 120", "24.98", "850 ± 230", "25.03"},
      // not the paper's cost: the authors' code leaves its nested ADMM after one turn
      {"admm", "ADMM", "#c8a000", "530 ± 33", "35.74", "900 ± 230", "35.82"},
      {"convex", "convex (24)", "#2a8f4a", "-", "-", "-", "-"},
      {"plus", "C3+", "#9050a0", "-", "-", "-", "-"}};
  return all;
}

/// Lets C3 decide, then projects once more what each of its projections was given, with a
/// stopwatch: inside the solver there is no clock.
class Rehearsal final : public example::Controller {
 public:
  explicit Rehearsal(const example::Experiment& experiment)
      : controller_(traced(experiment)),
        sizes_(example::sizes(experiment)),
        projection_(c3::make_projection(sizes_, experiment.c3)),
        rho_scale_(experiment.c3.rho_scale) {
    projection_->set_weights(experiment.costs);
  }

  void reset() override { controller_.reset(); }

  const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x, double t) override {
    const Eigen::MatrixXd* inputs = controller_.decide(lcs, x, t);
    if (inputs == nullptr) return nullptr;
    const c3::Solution& solution = controller_.solution();
    projection_->start(lcs);
    double total = 0.0;
    int count = 0;
    for (int i = 0; i < solution.iterations; ++i) {
      const c3::Iterate& iterate = solution.trace[static_cast<std::size_t>(i)];
      if (iterate.projections == 0) continue;
      // w was z + w − δ before it was divided by ρ_s
      const Eigen::MatrixXd v = rho_scale_ * iterate.w + iterate.delta;
      delta_ = v;
      const double start = seconds_now();
      for (int k = 0; k < iterate.projections; ++k)
        failed_ += projection_->project(v.col(k), delta_.col(k), {}).status !=
                           c3::ProjectionStatus::kSolved
                       ? 1
                       : 0;
      total += seconds_now() - start;
      count += iterate.projections;
    }
    if (count > 0) seconds_.push_back(total / count);
    return inputs;
  }

  /// Mean of one projection, of each decision [s].
  const std::vector<double>& seconds() const { return seconds_; }
  int failed() const { return failed_; }

 private:
  static example::Experiment traced(example::Experiment experiment) {
    experiment.c3.trace = true;
    return experiment;
  }

  example::C3Controller controller_;
  c3::Sizes sizes_;
  std::unique_ptr<c3::Projection> projection_;
  double rho_scale_;
  Eigen::MatrixXd delta_;
  std::vector<double> seconds_;
  int failed_ = 0;
};

ordered_json measure(const Context& context, const Method& method, const Overrides& overrides) {
  const ExampleScenario scenario = context.scenario(kCartPole, overrides);
  Rehearsal rehearsal(scenario.experiment);
  const example::Trajectory trajectory = run_loop(context, method.name, scenario, rehearsal);
  const Eigen::Map<const Eigen::VectorXd> times(
      rehearsal.seconds().data(), static_cast<Eigen::Index>(rehearsal.seconds().size()));
  const double mean = times.mean();
  ordered_json figures = loop_figures(scenario.experiment, trajectory, rehearsal.seconds());
  figures.erase("solve_time_s");
  figures["projection_s"] = {{"mean", number(mean)},
                             {"std", number(std::sqrt((times.array() - mean).square().mean()))},
                             {"p50", number(spread(rehearsal.seconds()).p50)}};
  figures["projections_not_solved"] = rehearsal.failed();
  figures["cost_to_go"] = numbers(trajectory.cost_to_go);
  figures["period_s"] = scenario.experiment.control_period;
  return figures;
}

}  // namespace

void table3(const Context& context) {
  std::vector<std::vector<std::string>> rows{
      {"", "one projection [µs], mean ± std", "", "", "", "mean cost-to-go", "", ""},
      {"projection", "paper", "authors' code", "here", "median", "paper", "authors' code", "here"}};
  ordered_json results{{"what", "table3"}};
  Panel costs{"", "time [s]", "cost-to-go of the plans", {}, {}, true};
  for (const Method& method : methods()) {
    const Overrides overrides{"c3.projection=" + method.key};
    const ordered_json figures = context.part(method.key, kCartPole, overrides, {},
                                              [&] { return measure(context, method, overrides); });
    const ordered_json& time = figures["projection_s"];
    rows.push_back({method.name, method.paper_time, method.authors_time,
                    shown(time["mean"], 1e6, 3) + " ± " + shown(time["std"], 1e6, 2),
                    shown(time["p50"], 1e6, 3), method.paper_cost, method.authors_cost,
                    shown(figures["mean_cost_to_go"])});
    results[method.key] = figures;
    const Eigen::VectorXd cost = to_vector(figures["cost_to_go"]);
    costs.curves.push_back({method.name, method.color,
                            Eigen::VectorXd::LinSpaced(cost.size(), 0.0,
                                                       figures["period_s"].get<double>() *
                                                           static_cast<double>(cost.size() - 1)),
                            cost});
  }
  fmt::print("Table III: cart-pole with soft walls, one core\n\n");
  print_table(rows);
  context.finish(results, "Table III: cart-pole with soft walls", {costs});
}

}  // namespace c3rt::cli::reproduce
