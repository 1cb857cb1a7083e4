// Times the C3 solve of the single-ball task (n_x 19, n_lambda 12, n_u 3, N 5, s 3) and its parts
// beside a baseline that says how fast the machine is just now: one Cholesky factorisation of a
// dense 100 × 100 matrix. Run: c3rt_bench_c3 --benchmark_repetitions=20
#include <algorithm>
#include <vector>

#include <Eigen/Cholesky>
#include <benchmark/benchmark.h>

#include "controller/c3/solver.hpp"
#include "tests/support/rolling_ball.hpp"

namespace {

using namespace c3rt;

c3::Settings settings(c3::QpBackend qp) {
  return {3, 1.0, 2.2, qp, {1000, 1e-5, 0.1, 50, false}, c3::ProjectionKind::kMiqp, 10000, true};
}

/// Problems along a push: the gap and the ball's speed vary, so the contact modes do.
struct Problem {
  Eigen::VectorXd x0;
  lcs::Lcs lcs;
  Eigen::MatrixXd x_desired;
};
std::vector<Problem> problems() {
  std::vector<Problem> all;
  for (int i = 0; i < 16; ++i) {
    const Eigen::VectorXd x = rolling_ball::state(-0.0005 + 0.001 * i, 0.01 * i);
    all.push_back({x, rolling_ball::lcs(x), rolling_ball::x_desired(x)});
  }
  return all;
}

void baseline_cholesky_100(benchmark::State& state) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Constant(100, 100, 0.5);
  A.diagonal().setConstant(100.0);
  Eigen::LLT<Eigen::MatrixXd> llt(100);
  for (auto _ : state) {
    llt.compute(A);
    benchmark::DoNotOptimize(llt.matrixLLT().data());
  }
}
BENCHMARK(baseline_cholesky_100)->Unit(benchmark::kMicrosecond);

void solve(benchmark::State& state, c3::QpBackend qp, rolling_ball::Phase phase) {
  const std::vector<Problem> all = problems();
  c3::Solver solver(rolling_ball::sizes(), settings(qp));
  solver.set_costs(rolling_ball::costs(phase));
  std::size_t i = 0;
  long nodes = 0, failed = 0;
  for (auto _ : state) {
    const Problem& problem = all[i++ % all.size()];
    const c3::Solution& solution = solver.solve(problem.lcs, problem.x0, problem.x_desired);
    benchmark::DoNotOptimize(solution.z.data());
    nodes += solution.branch_nodes;
    failed += solution.status != c3::SolveStatus::kOk;
  }
  // 2 rounds of 5 projections per solve
  state.counters["nodes/projection"] =
      benchmark::Counter(static_cast<double>(nodes) / 10.0, benchmark::Counter::kAvgIterations);
  state.counters["not ok"] = static_cast<double>(failed);
}
BENCHMARK_CAPTURE(solve, direct_roll, c3::QpBackend::kDirect, rolling_ball::Phase::kRoll)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve, direct_return, c3::QpBackend::kDirect, rolling_ball::Phase::kReturn)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve, osqp_roll, c3::QpBackend::kOsqp, rolling_ball::Phase::kRoll)
    ->Unit(benchmark::kMicrosecond);

void project(benchmark::State& state) {
  const std::vector<Problem> all = problems();
  const c3::Sizes sizes = rolling_ball::sizes();
  const c3::Costs costs = rolling_ball::costs(rolling_ball::Phase::kRoll);
  c3::Solver solver(sizes, settings(c3::QpBackend::kDirect));
  solver.set_costs(costs);
  const auto projection = c3::make_miqp_projection(sizes, 10000);
  projection->set_weights(costs);
  const Problem& problem = all[static_cast<std::size_t>(state.range(0))];
  const Eigen::MatrixXd v = solver.solve(problem.lcs, problem.x0, problem.x_desired).z;
  projection->start(problem.lcs);
  Eigen::VectorXd delta(sizes.n_z());
  int k = 0;
  long nodes = 0;
  for (auto _ : state) {
    nodes += projection->project(v.col(k++ % sizes.N), delta, {}).nodes;
    benchmark::DoNotOptimize(delta.data());
  }
  state.counters["nodes"] =
      benchmark::Counter(static_cast<double>(nodes), benchmark::Counter::kAvgIterations);
}
BENCHMARK(project)->Arg(0)->Arg(5)->Arg(15)->Unit(benchmark::kMicrosecond);

void qp_step(benchmark::State& state) {
  const std::vector<Problem> all = problems();
  const c3::Sizes sizes = rolling_ball::sizes();
  const auto qp = c3::make_direct_qp(sizes);
  const c3::Costs costs = rolling_ball::costs(rolling_ball::Phase::kRoll);
  qp->set_costs(costs, {});
  qp->start({&all[0].lcs, 0}, {costs.G.data(), 0}, nullptr);
  const Eigen::MatrixXd r = Eigen::MatrixXd::Zero(sizes.n_z(), sizes.N);
  Eigen::MatrixXd z(sizes.n_z(), sizes.N);
  Eigen::VectorXd x_N(sizes.n_x);
  double rho = 1.0;
  for (auto _ : state) {
    rho = 3.0 - rho;  // another penalty every time: nothing of the factorisation is reused
    (void)qp->solve(rho, all[0].x0, all[0].x_desired, r, z, x_N);
    benchmark::DoNotOptimize(z.data());
  }
}
BENCHMARK(qp_step)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
