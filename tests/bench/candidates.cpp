#include "tests/bench/candidates.hpp"

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "config/scenario.hpp"
#include "controller/c3/consensus.hpp"
#include "controller/planner/strategy/candidate.hpp"
#include "controller/planner/strategy/surface_samples.hpp"
#include "tests/bench/baseline.hpp"

namespace bench {
namespace {

using namespace c3rt;
using benchmark::Counter;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Question {
  std::string scenario;
  std::vector<std::string> overrides;
};

/// The scenario's objects where they begin, one of them wanted 0.1 m on, and places beside it.
struct Places {
  explicit Places(const Question& question)
      : scenario(config::load_scenario(
            C3RT_SOURCE_DIRECTORY "/config/scenarios/" + question.scenario + ".yaml",
            question.overrides)),
        candidate(scenario.planner, scenario.planner.sampling.servo) {
    const planner::Parameters& p = scenario.planner;
    stages = static_cast<std::size_t>(p.N) + 1;
    candidate.c3().start_from_free_gaps(0.03);
    costs = costs_of(candidate.c3().problem(), p.sampling.weights);
    from = candidate.c3().model().layout().world;
    for (int i = 0; i < from.body_count; ++i) {
      const auto& at = scenario.plant.world.objects.at(static_cast<std::size_t>(i)).position;
      from.body(i).p_WB << at, p.geometry.table_height;
      from.body(i).p_WB.z() += planner::extent(from.body(i), -Vector3d::UnitZ());
    }
    wanted = from;
    wanted.body(0).p_WB.x() += 0.1;
    planner::SampleRules rules{};
    rules.height = p.geometry.table_height + p.sampling.height;
    rules.clearance = p.sampling.clearance;
    rules.reach = {p.sampling.reach_min, p.sampling.reach_max};
    rules.reach_radius = p.sampling.reach_radius;
    rules.top = planner::top_of(from) + from.effector.radius;
    base::Random random(1);
    while (places.size() < 12) {
      const auto place = planner::surface_sample(from, 0, rules, random);
      if (place) places.push_back(*place);
    }
  }
  planner::Worth worth(std::size_t place) {
    from.effector.p_WE = places[place % places.size()];
    wanted.effector.p_WE = from.effector.p_WE;
    return candidate.worth(costs, from, std::vector<scene::Scene>(stages, wanted));
  }

  config::Scenario scenario;
  planner::Candidate candidate;
  c3::Costs costs;
  std::size_t stages;
  scene::Scene from, wanted;
  std::vector<Vector3d> places;
};

/// CPU time of the QPs of one place, the mean of all: OSQP with its default tolerances, set up anew
/// for every QP, as whoever has no solver of his own does it. Nothing else is counted.
double osqp_time(Places& at) {
  const c3::Settings of_plan = at.scenario.planner.c3;
  const planner::C3Controller& c3 = at.candidate.c3();
  const c3::Sizes sizes{c3.n_x(), c3.n_lambda(), c3.n_u(), at.scenario.planner.N};
  c3::Settings settings = of_plan;
  settings.trace = true;
  c3::Solver solver(sizes, settings);
  solver.set_costs(at.costs);
  const auto consensus = c3::projection_type(settings.projection).make_consensus(sizes);
  consensus->set_weights(at.costs);
  qp::Costs of_qp = at.costs;
  of_qp.G = consensus->pattern(at.costs);
  MatrixXd g(sizes.n_z(), sizes.N), z = MatrixXd::Zero(sizes.n_z(), sizes.N);
  VectorXd x_N = VectorXd::Zero(sizes.n_x);
  double seconds = 0.0;
  for (std::size_t place = 0; place < at.places.size(); ++place) {
    (void)at.worth(place);
    const lcs::Lcs& system = c3.planning_system();
    const c3::Solution& solution = solver.solve(system, c3.x_hat(), c3.x_desired());
    MatrixXd delta = MatrixXd::Zero(solver.n_copy(), sizes.N), w = delta;
    delta.topRows(sizes.n_x).colwise() = c3.x_hat();
    for (int i = 0; i < solution.iterations; ++i) {
      const c3::Iterate& iterate = solution.trace[static_cast<std::size_t>(i)];
      const auto W = consensus->start({&system, 0});
      consensus->set_linear_term(delta, w, g);
      const double start = thread_seconds();
      const auto qp = make_paper_qp(sizes);
      qp->set_costs(of_qp, {});
      qp->start({&system, 0}, W, nullptr);
      (void)qp->solve(iterate.rho, c3.x_hat(), c3.x_desired(), g, z, x_N);
      seconds += thread_seconds() - start;
      delta = iterate.delta;
      w = iterate.w;
    }
  }
  return seconds / static_cast<double>(at.places.size());
}

void candidates(benchmark::State& state, const Question& question, int count) {
  Places at(question);
  // Google Benchmark comes here several times until it has found how often to repeat
  static std::map<std::string, double> baselines;
  if (baselines.count(question.scenario) == 0) baselines[question.scenario] = osqp_time(at);
  std::size_t place = 0;
  long unknown = 0;
  for (auto _ : state) {
    for (int i = 0; i < count; ++i) {
      const planner::Worth worth = at.worth(place++);
      unknown += worth.known ? 0 : 1;
      benchmark::DoNotOptimize(worth.cost);
    }
  }
  const double baseline = count * baselines.at(question.scenario);
  state.counters["n_x"] = at.candidate.c3().n_x();
  state.counters["n_lambda"] = at.candidate.c3().n_lambda();
  state.counters["unknown"] = static_cast<double>(unknown);
  state.counters["baseline_s"] = baseline;
  state.counters["speed-up"] = Counter(baseline, Counter::kIsIterationInvariantRate);
}

void add(const std::string& name, const Question& question, int count) {
  benchmark::RegisterBenchmark(("candidate/" + name).c_str(), [=](benchmark::State& state) {
    candidates(state, question, count);
  })->Unit(benchmark::kMicrosecond);
}

}  // namespace

void add_candidates() {
  const Question t{"push_t", {}};
  // all of them at once, and every two, where the scenario plans with two
  const Question four{"four_objects", {"planner.model.closest_objects=0"}};
  add("t", t, 1);
  add("t/6", t, 6);
  add("two_objects", {"two_objects", {}}, 1);
  add("four_objects", four, 1);
}

}  // namespace bench
