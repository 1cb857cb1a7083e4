// How far plans are above the proven optimum of (15), with and without polish: the cost of the
// planning LCS, simulated with the plan's inputs, at closed-loop states of an example, and what is
// left where the first input alone is taken and the rest is optimal. Run:
// c3rt_bench_polish gaiting|gaiting_own|ball|pivoting|pivoting_own|all [QPs] [1: first inputs] [1:
// each state] [states]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/section.hpp"
#include "controller/c3/polish.hpp"
#include "controller/c3/solver.hpp"
#include "controller/example/closed_loop.hpp"
#include "controller/example/load_experiment.hpp"
#include "controller/horizon/modes.hpp"
#include "controller/horizon/search.hpp"
#include "controller/lcs/simulate.hpp"
#include "controller/lcs/step.hpp"
#include "tests/support/rolling_ball.hpp"

namespace {

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNone = std::numeric_limits<double>::infinity();

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Case {
  std::string name;
  c3::Sizes sizes;
  c3::Settings settings;
  c3::Costs costs;
  c3::Constraints constraints;
  std::vector<VectorXd> x0;
  std::vector<lcs::Lcs> lcs;
  std::vector<MatrixXd> x_desired;
  bool shifted = false;
  int stages_per_period = 1;
  const example::Experiment* experiment = nullptr;
};

Case example_case(const std::string& name, const std::string& scenario,
                  const std::vector<std::string>& overrides, int count) {
  static std::vector<std::unique_ptr<example::Experiment>> kept;
  kept.push_back(
      std::make_unique<example::Experiment>(example::load_experiment(config::Document::load(
          C3RT_SOURCE_DIRECTORY "/config/scenarios/" + scenario + ".yaml", overrides))));
  const example::Experiment& experiment = *kept.back();
  Case c{name,
         example::sizes(experiment),
         experiment.c3,
         experiment.costs,
         experiment.constraints,
         {},
         {},
         {},
         experiment.start == example::StartPolicy::kShifted};
  if (c.shifted) c.settings.project_last = true;
  c.experiment = &experiment;
  c.stages_per_period =
      static_cast<int>(std::lround(experiment.control_period / experiment.planning_step));
  example::C3Controller controller(experiment);
  example::LcsPlant plant(experiment);
  const example::Trajectory run = example::run(experiment, 1, 0, controller, plant);
  const auto held = static_cast<Eigen::Index>(
      std::llround(experiment.control_period / experiment.simulation_step));
  for (int i = 0; i < count && i * held < run.x.cols(); ++i) {
    c.x0.push_back(run.x.col(i * held));
    c.lcs.push_back(example::planning_system(experiment, c.x0.back()));
    c.x_desired.push_back(experiment.x_desired.replicate(1, c.sizes.N + 1));
  }
  return c;
}

Case ball_case(int count) {
  // the weights of circle_slow
  c3::Costs costs;
  VectorXd Q = VectorXd::Constant(19, 0.1), U = VectorXd::Ones(34);
  Q.head(3).setConstant(1000.0);
  Q.segment(3, 4).setZero();
  Q.segment(7, 3) << 5e5, 5e5, 0.0;
  Q.segment(10, 3).setConstant(10.0);
  U.head(19).setConstant(100.0);
  costs.Q = Q.asDiagonal();
  costs.Q_N = Q.asDiagonal();
  costs.R = Eigen::Matrix3d(0.01 * Eigen::Matrix3d::Identity());
  costs.G = VectorXd(VectorXd::Constant(34, 0.01)).asDiagonal();
  costs.U = U.asDiagonal();
  Case c{"ball",
         rolling_ball::sizes(),
         {2,
          1.0,
          3.0,
          c3::QpBackend::kDirect,
          {4000, 1e-7, 0.1, 50, false},
          c3::ProjectionKind::kMiqp,
          2000,
          true},
         costs,
         {},
         {},
         {},
         {}};
  c.stages_per_period = 0;
  c3::Solver solver(c.sizes, c.settings);
  solver.set_costs(c.costs);
  VectorXd x = rolling_ball::state();
  lcs::Lemke lemke(c.sizes.n_lambda);
  VectorXd lambda(c.sizes.n_lambda), next(c.sizes.n_x);
  for (int i = 0; i < count; ++i) {
    c.x0.push_back(x);
    c.lcs.push_back(rolling_ball::lcs(x));
    VectorXd target = VectorXd::Zero(19);
    const double angle = std::atan2(x[7] - 0.55, x[8]) + 0.35;
    target.head<3>() << x[7], x[8],
        2.0 * rolling_ball::kBallRadius + rolling_ball::kPointRadius + 0.004;
    target[3] = 1.0;
    target.segment<3>(7) << 0.55 + 0.1 * std::sin(angle), 0.1 * std::cos(angle),
        rolling_ball::kBallRadius;
    c.x_desired.push_back(target.replicate(1, rolling_ball::kN + 1));
    const VectorXd u = solver.solve(c.lcs.back(), x, c.x_desired.back()).u_0();
    for (int j = 0; j < 4; ++j) {
      const lcs::Lcs plant = rolling_ball::lcs(x, 0.005);
      if (!lcs::step(plant, x, u, lemke, next, lambda).ok()) std::abort();
      x = next;
      x.segment<4>(3).normalize();
    }
  }
  return c;
}

double simulated_cost(const Case& c, int i, MatrixXd u) {
  if (c.experiment != nullptr) {
    for (int k = 0; k < c.sizes.N; ++k) example::clip(*c.experiment, u.col(k));
  }
  const lcs::Simulation simulation = lcs::simulate(c.lcs[i], c.x0[i], u);
  if (!simulation.report.ok()) return kNone;
  double cost = 0.0;
  for (int k = 0; k <= c.sizes.N; ++k) {
    const VectorXd e = simulation.x.col(k) - c.x_desired[i].col(k);
    cost += e.dot((k == c.sizes.N ? c.costs.Q_N : c.costs.Q[k]) * e);
    if (k < c.sizes.N) cost += u.col(k).dot(c.costs.R[k] * u.col(k));
  }
  return cost;
}

double quantile(std::vector<double> v, double q) {
  std::sort(v.begin(), v.end());
  return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}

horizon::Problem problem_of(const Case& c, int i, const c3::Constraints& constraints) {
  return {c.sizes, {&c.lcs[i], 0}, &c.costs, &constraints, c.x_desired[i], c.x0[i]};
}

struct Optimum {
  double cost, bound;
};

Optimum optimum(const Case& c, int i, const c3::Constraints& constraints, const MatrixXd& u,
                double gap) {
  const horizon::Problem problem = problem_of(c, i, constraints);
  std::optional<horizon::Plan> known;
  const lcs::Simulation simulation = lcs::simulate(c.lcs[i], c.x0[i], u);
  if (simulation.report.ok()) {
    const horizon::Plan plan = horizon::roll_out(problem, simulation.lambda, u);
    known = horizon::solve_modes(problem, horizon::modes(problem, plan));
  }
  const horizon::SearchResult result = horizon::search(problem, {200000, gap}, known);
  return {result.plan ? result.plan->objective : kNone, result.lower_bound};
}

void run(Case c, int qps, bool first_input, bool verbose) {
  c3::Solver solver(c.sizes, c.settings);
  solver.set_costs(c.costs, c.constraints);
  c.settings.polish = qps;
  c3::Solver polished_solver(c.sizes, c.settings);
  polished_solver.set_costs(c.costs, c.constraints);
  std::vector<double> above, above_polished, first, first_polished, t_solve, t_polish, n_qps;
  c3::Start start, polished_start;
  const bool use_last = 2 * c.stages_per_period <= c.sizes.N;  // as example::C3Controller
  const int n_u_at = c.sizes.n_x + c.sizes.n_lambda;
  for (int i = 0; i < static_cast<int>(c.x0.size()); ++i) {
    double began = thread_seconds();
    const c3::Solution& solution =
        solver.solve(c.lcs[i], c.x0[i], c.x_desired[i], {}, c.shifted && i > 0 ? &start : nullptr);
    t_solve.push_back(thread_seconds() - began);
    began = thread_seconds();
    if (c.shifted && i > 0) {
      polished_start.delta = start.delta;
      polished_start.w = start.w;
    }
    const c3::Solution& better = polished_solver.solve(c.lcs[i], c.x0[i], c.x_desired[i], {},
                                                       i > 0 ? &polished_start : nullptr);
    t_polish.push_back(thread_seconds() - began - t_solve.back());
    if (solution.status == c3::SolveStatus::kFailed) {
      std::printf("state %d: C3 failed\n", i);
      continue;
    }
    if (c.shifted) shift(solution, c.settings.rho, start);
    const MatrixXd u = solution.z.middleRows(n_u_at, c.sizes.n_u);
    const MatrixXd best = better.z.middleRows(n_u_at, c.sizes.n_u);
    shift_plan(better, c.stages_per_period, polished_start);
    if (!use_last) polished_start.u.resize(0, 0);
    n_qps.push_back(better.polish.qps);
    const double cost = simulated_cost(c, i, u), polished = simulated_cost(c, i, best);
    const Optimum exact = optimum(c, i, c.constraints, best, 1e-3);
    above.push_back(100.0 * (cost / exact.cost - 1.0));
    above_polished.push_back(100.0 * (polished / exact.cost - 1.0));
    if (first_input) {
      for (const bool is_polished : {false, true}) {
        const MatrixXd& of = is_polished ? best : u;
        c3::Constraints fixed = c.constraints;
        std::vector<VectorXd> low, high;
        for (int k = 0; k < c.sizes.N; ++k) {
          const VectorXd none = VectorXd::Constant(c.sizes.n_u, kNone);
          low.push_back(k == 0                          ? VectorXd(of.col(0))
                        : c.constraints.u_min[k].size() ? c.constraints.u_min[k]
                                                        : VectorXd(-none));
          high.push_back(k == 0                          ? VectorXd(of.col(0))
                         : c.constraints.u_max[k].size() ? c.constraints.u_max[k]
                                                         : none);
        }
        fixed.u_min = low;
        fixed.u_max = high;
        const Optimum rest = optimum(c, i, fixed, of, 1e-3);
        (is_polished ? first_polished : first).push_back(100.0 * (rest.cost / exact.cost - 1.0));
      }
    }
    if (verbose) {
      std::printf(
          "%2d C3 %9.2f %% polished %8.2f %% (own %.6g from %.6g, opt %.6g bound %.6g) status %d "
          "compl %.1e qps %d  %.3f ms %.3f ms\n",
          i, above.back(), above_polished.back(), better.polish.cost, better.polish.cost_before,
          exact.cost, exact.bound, static_cast<int>(better.polish.status),
          better.complementarity_violation, better.polish.qps, 1e3 * t_solve.back(),
          1e3 * t_polish.back());
    }
  }
  std::printf(
      "%-14s C3: median %.1f %% worst %.1f %%; polished: median %.2f %% p90 %.1f worst %.1f %%; "
      "solve %.3f ms, polish %.3f ms (p90 %.3f), QPs %.0f\n",
      c.name.c_str(), quantile(above, 0.5), quantile(above, 1.0), quantile(above_polished, 0.5),
      quantile(above_polished, 0.9), quantile(above_polished, 1.0), 1e3 * quantile(t_solve, 0.5),
      1e3 * quantile(t_polish, 0.5), 1e3 * quantile(t_polish, 0.9), quantile(n_qps, 0.5));
  if (first_input)
    std::printf(
        "   first input: C3 median %.2f %% worst %.2f %%; polished median %.2f %% worst %.2f %%\n",
        quantile(first, 0.5), quantile(first, 1.0), quantile(first_polished, 0.5),
        quantile(first_polished, 1.0));
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
  const std::string which = argc > 1 ? argv[1] : "all";
  const int qps = argc > 2 ? std::atoi(argv[2]) : 60;
  const bool first = argc > 3 && std::atoi(argv[3]) != 0;
  const bool verbose = argc > 4 && std::atoi(argv[4]) != 0;
  const int count = argc > 5 ? std::atoi(argv[5]) : 40;
  // settings of our own: those of Tables I and II in docs/experiments
  const std::vector<std::string> gaiting_own{"c3.admm_iterations=20", "c3.rho_scale=1.05"};
  const std::vector<std::string> pivoting_own{"c3.rho=0.01"};
  const auto is_asked = [&](const char* name) { return which == "all" || which == name; };
  if (is_asked("gaiting"))
    run(example_case("gaiting", "finger_gaiting", {}, count), qps, first, verbose);
  if (is_asked("gaiting_own"))
    run(example_case("gaiting_own", "finger_gaiting", gaiting_own, count), qps, first, verbose);
  if (is_asked("ball")) run(ball_case(count), qps, first, verbose);
  if (is_asked("pivoting"))
    run(example_case("pivoting", "pivoting", {}, count), qps, first, verbose);
  if (is_asked("pivoting_own"))
    run(example_case("pivoting_own", "pivoting", pivoting_own, count), qps, first, verbose);
  return 0;
}
