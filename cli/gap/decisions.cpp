#include "cli/gap/decisions.hpp"

#include <fmt/format.h>

#include "cli/example/plants.hpp"
#include "cli/paths.hpp"
#include "controller/lcs/simulate.hpp"

namespace c3rt::cli::gap {
namespace {

/// A plan, each input within the example's bounds; no column where there is none.
Eigen::MatrixXd clipped(const example::Experiment& experiment, const Eigen::MatrixXd* plan) {
  if (plan == nullptr) return {};
  Eigen::MatrixXd u = *plan;
  for (Eigen::Index k = 0; k < u.cols(); ++k) example::clip(experiment, u.col(k));
  return u;
}

/// Writes down what another controller decides.
class Scribe final : public example::Controller {
 public:
  Scribe(const example::Experiment& experiment, example::Controller& controller,
         std::vector<Decision>& decisions)
      : experiment_(experiment), controller_(controller), decisions_(decisions) {}
  void reset() override { controller_.reset(); }
  const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x, double t) override {
    const double began = processor_seconds_now();
    const Eigen::MatrixXd* plan = controller_.decide(lcs, x, t);
    const double solve_time_s = processor_seconds_now() - began;
    decisions_.push_back({t,
                          {lcs},
                          x,
                          clipped(experiment_, plan),
                          solve_time_s,
                          experiment_.x_desired.replicate(1, experiment_.N + 1)});
    return plan;
  }

 private:
  const example::Experiment& experiment_;
  example::Controller& controller_;
  std::vector<Decision>& decisions_;
};

class UpTo final : public example::Observer {
 public:
  UpTo(const std::vector<Decision>& decisions, int count, const Stop& stop)
      : decisions_(decisions), count_(static_cast<std::size_t>(count)), stop_(stop) {}
  bool go_on(double) override { return decisions_.size() < count_ && !stop_(); }

 private:
  const std::vector<Decision>& decisions_;
  std::size_t count_;
  const Stop& stop_;
};

}  // namespace

horizon::Problem Decisions::problem(std::size_t index) const {
  const Decision& decision = all[index];
  return {sizes,
          {decision.lcs.data(), decision.lcs.size() == 1 ? 0 : 1},
          &costs[decision.costs],
          &constraints,
          decision.x_desired,
          decision.x0};
}

std::optional<horizon::Plan> Decisions::simulated(std::size_t index,
                                                  const Eigen::MatrixXd& u) const {
  const Decision& decision = all[index];
  if (u.cols() == 0) return std::nullopt;
  const lcs::Simulation simulation = decision.lcs.size() == 1
                                         ? lcs::simulate(decision.lcs.front(), decision.x0, u)
                                         : lcs::simulate(decision.lcs, decision.x0, u);
  if (!simulation.report.ok()) return std::nullopt;
  return horizon::roll_out(problem(index), simulation.lambda, u);
}

Decisions of_problem(const config::ProblemFile& problem, const std::string& name) {
  c3::Solver solver(problem.sizes, problem.settings);
  solver.set_costs(problem.costs, problem.constraints);
  const double began = processor_seconds_now();
  const c3::Solution& solution =
      problem.lcs.size() == 1 ? solver.solve(problem.lcs.front(), problem.x0, problem.x_desired)
                              : solver.solve(problem.lcs, problem.x0, problem.x_desired);
  Decision decision{
      0.0, problem.lcs, problem.x0, {}, processor_seconds_now() - began, problem.x_desired};
  if (solution.status != c3::SolveStatus::kFailed)
    decision.u = config::to_result(problem, solution, decision.solve_time_s).u;
  return {name, problem.sizes, {problem.costs}, problem.constraints, {decision}};
}

Decisions of_example(const ExampleScenario& scenario, std::uint64_t seed, int count,
                     const Stop& stop) {
  const example::Experiment& experiment = scenario.experiment;
  Decisions decisions{
      scenario.name, example::sizes(experiment), {experiment.costs}, experiment.constraints, {}};
  example::C3Controller controller(experiment);
  Scribe scribe(experiment, controller, decisions.all);
  const std::unique_ptr<example::Plant> plant = make_plant(experiment);
  UpTo observer(decisions.all, count, stop);
  (void)example::run(experiment, seed, 0, scribe, *plant, &observer);
  return decisions;
}

std::vector<Answer> answers(const Decisions& decisions, const ExampleScenario& scenario,
                            const ExampleScenario& planner) {
  const example::Experiment& experiment = planner.experiment;
  const c3::Sizes sizes = example::sizes(experiment);
  const auto told = [](const c3::Sizes& of, double step) {
    return fmt::format("{} states, {} inputs, a horizon of {} and a planning step of {:g} s",
                       of.n_x, of.n_u, of.N, step);
  };
  const std::string expected = told(decisions.sizes, scenario.experiment.planning_step),
                    got = told(sizes, experiment.planning_step);
  if (got != expected)
    throw UsageError(fmt::format("{}: expected {}, got {}", planner.name, expected, got));
  example::C3Controller controller(experiment);
  std::vector<Answer> all;
  for (const Decision& decision : decisions.all) {
    const lcs::Lcs lcs = example::planning_system(experiment, decision.x0);
    const double began = processor_seconds_now();
    const Eigen::MatrixXd* plan = controller.decide(lcs, decision.x0, decision.t);
    const double solve_time_s = processor_seconds_now() - began;
    all.push_back({clipped(experiment, plan), solve_time_s});
  }
  return all;
}

}  // namespace c3rt::cli::gap
