#include "cli/reproduce/loop.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "cli/example/plants.hpp"
#include "cli/example/trials.hpp"
#include "controller/lcs/simulate.hpp"

namespace c3rt::cli::reproduce {
namespace {

constexpr std::uint64_t kSeed = 1;

class Watch final : public example::Observer {
 public:
  Watch(const Context& context, const std::string& title, double duration)
      : context_(context), duration_(duration), progress_(title) {}
  bool go_on(double t) override {
    if (context_.stopped()) return false;
    progress_.update(t / duration_, fmt::format("t = {:.2f} of {:g} s", t, duration_));
    return true;
  }

 private:
  const Context& context_;
  double duration_;
  Progress progress_;
};

double overshoot(const c3::Constraints& constraints, const example::Trajectory& trajectory) {
  const Eigen::MatrixXd& x = trajectory.x;
  const double above = (x.colwise() - constraints.x_max[0]).maxCoeff();
  const double below = ((-x).colwise() + constraints.x_min[0]).maxCoeff();
  return std::max({0.0, above, below});
}

}  // namespace

MonolithicController::MonolithicController(const example::Experiment& experiment,
                                           const example::Experiment& starter, double limit,
                                           Stop stop)
    : experiment_(experiment),
      c3_(starter),
      sizes_(example::sizes(experiment)),
      limit_(limit),
      stop_(std::move(stop)) {}

bool MonolithicController::is_late(void* self) noexcept {
  const auto& controller = *static_cast<const MonolithicController*>(self);
  return seconds_now() > controller.end_ || controller.stop_();
}

void MonolithicController::reset() {
  c3_.reset();
  last_.clear();
}

std::optional<horizon::Plan> MonolithicController::first_plan(const horizon::Problem& problem,
                                                              const lcs::Lcs& lcs, double t) {
  std::optional<horizon::Plan> best;
  const auto consider = [&](const std::vector<horizon::Side>& zero) {
    std::optional<horizon::Plan> plan = horizon::solve_modes(problem, zero);
    if (plan && (!best || plan->objective < best->objective)) best = std::move(plan);
  };
  if (const Eigen::MatrixXd* u = c3_.decide(lcs, problem.x0, t); u != nullptr) {
    const c3::Solution& solution = c3_.solution();
    for (const Eigen::MatrixXd* copy : {&solution.z, &solution.delta}) {
      consider(horizon::modes(
          problem, horizon::roll_out(problem, copy->middleRows(sizes_.n_x, sizes_.n_lambda),
                                     copy->middleRows(sizes_.n_x + sizes_.n_lambda, sizes_.n_u))));
    }
    const lcs::Simulation simulation = lcs::simulate(lcs, problem.x0, *u);
    if (simulation.report.ok())
      consider(horizon::modes(problem, horizon::roll_out(problem, simulation.lambda, *u)));
  }
  if (!last_.empty()) {  // the last stage keeps its modes
    std::vector<horizon::Side> shifted(last_.begin() + sizes_.n_lambda, last_.end());
    shifted.insert(shifted.end(), last_.end() - sizes_.n_lambda, last_.end());
    consider(shifted);
  }
  return best;
}

const Eigen::MatrixXd* MonolithicController::decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x,
                                                    double t) {
  end_ = seconds_now() + limit_;
  const horizon::Problem problem{sizes_,
                                 {&lcs, 0},
                                 &experiment_.costs,
                                 &experiment_.constraints,
                                 experiment_.x_desired.replicate(1, sizes_.N + 1),
                                 x};
  const horizon::SearchResult result =
      horizon::search(problem, {}, first_plan(problem, lcs, t), {&is_late, this});
  gaps_.push_back(result.plan ? result.gap : kNone);
  proven_ += result.is_proven() ? 1 : 0;
  last_.clear();
  if (!result.plan) return nullptr;
  last_ = horizon::modes(problem, *result.plan);
  u_ = result.plan->u;
  return &u_;
}

example::Trajectory run_loop(const Context& context, const std::string& title,
                             const ExampleScenario& scenario, example::Controller& controller,
                             int trial) {
  const std::unique_ptr<example::Plant> plant = make_plant(scenario.experiment);
  Watch watch(context, title, scenario.experiment.duration);
  example::Trajectory trajectory =
      example::run(scenario.experiment, kSeed, trial, controller, *plant, &watch);
  if (trajectory.stopped || context.stopped()) throw Interrupted{};
  return trajectory;
}

ordered_json loop_figures(const example::Experiment& experiment,
                          const example::Trajectory& trajectory,
                          const std::vector<double>& solve_times) {
  const Trial trial = summarise(experiment, trajectory);
  const Spread times = spread(solve_times);
  return {{"accumulated_cost", number(trial.accumulated_cost)},
          {"mean_cost_to_go", number(trial.mean_cost_to_go)},
          {"succeeded", trial.succeeded},
          {"controller_failures", trial.controller_failures},
          {"plant_failed", trial.plant_failed},
          {"overshoot", overshoot(experiment.constraints, trajectory)},
          {"calls", solve_times.size()},
          {"solve_time_s",
           {{"p50", number(times.p50)}, {"p95", number(times.p95)}, {"max", number(times.max)}}}};
}

ordered_json measure_c3(const Context& context, const std::string& title,
                        const ExampleScenario& scenario) {
  example::C3Controller controller(scenario.experiment);
  TimedController timed(controller);
  const example::Trajectory trajectory = run_loop(context, title, scenario, timed);
  return loop_figures(scenario.experiment, trajectory, timed.seconds());
}

ordered_json measure_monolithic(const Context& context, const std::string& title,
                                const ExampleScenario& scenario, const ExampleScenario& starter) {
  MonolithicController controller(scenario.experiment, starter.experiment,
                                  context.settings().miqp_limit,
                                  [&context] { return context.stopped(); });
  TimedController timed(controller);
  const example::Trajectory trajectory = run_loop(context, title, scenario, timed);
  ordered_json figures = loop_figures(scenario.experiment, trajectory, timed.seconds());
  const std::vector<double>& gaps = controller.gaps();
  figures["proven"] = controller.proven();
  figures["gap_mean"] = number(std::accumulate(gaps.begin(), gaps.end(), 0.0) /
                               static_cast<double>(std::max<std::size_t>(1, gaps.size())));
  figures["gap_max"] = number(gaps.empty() ? kNone : *std::max_element(gaps.begin(), gaps.end()));
  return figures;
}

}  // namespace c3rt::cli::reproduce
