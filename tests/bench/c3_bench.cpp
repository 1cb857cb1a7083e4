// Times the QP step, the projections, the LCS of objects, places of the end effector and whole C3
// solves, each beside the paper's configuration in the same run (tests/bench/baseline.hpp):
// "speed-up" is the baseline's time divided by ours. All is CPU time of one thread. Run:
// c3rt bench c3, or c3rt_bench_c3 --benchmark_repetitions=9
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <benchmark/benchmark.h>

#include "controller/c3/solver.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/model/objects_model.hpp"
#include "tests/bench/baseline.hpp"
#include "tests/bench/candidates.hpp"
#include "tests/bench/problems.hpp"

namespace {

using namespace c3rt;
using bench::Problem;
using benchmark::Counter;
using c3::ProjectionKind;
using c3::QpBackend;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const char* name(ProjectionKind kind) {
  switch (kind) {
    case ProjectionKind::kMiqp:
      return "miqp";
    case ProjectionKind::kLcp:
      return "lcp";
    case ProjectionKind::kAdmm:
      return "admm";
    case ProjectionKind::kConvex:
      return "convex";
    case ProjectionKind::kPlus:
      return "c3+";
  }
  return "";
}

const char* name(QpBackend backend) {
  switch (backend) {
    case QpBackend::kDirect:
      return "direct";
    case QpBackend::kInteriorPoint:
      return "interior_point";
    case QpBackend::kOsqp:
      return "osqp";
  }
  return "";
}

/// The exact projection's problem has the weights and the model that the baseline needs.
Problem baseline_problem(const std::string& name, int N) {
  return bench::problem(name, ProjectionKind::kMiqp, N);
}

/// seconds of the baseline over seconds of ours
void count_speed_up(benchmark::State& state, double baseline_seconds) {
  state.counters["baseline_s"] = baseline_seconds;
  state.counters["speed-up"] = Counter(baseline_seconds, Counter::kIsIterationInvariantRate);
}

bool nothing_to_time = false;

/// A benchmark without QPs or projections to repeat would never end.
bool skip_if_nothing(benchmark::State& state, bool nothing) {
  if (!nothing) return false;
  nothing_to_time = true;
  state.SkipWithError("the solve whose QPs and projections are to be timed failed at once");
  return true;
}

/// How fast this machine is just now.
void cholesky(benchmark::State& state) {
  MatrixXd A = MatrixXd::Constant(100, 100, 0.5);
  A.diagonal().setConstant(100.0);
  Eigen::LLT<MatrixXd> llt(100);
  for (auto _ : state) {
    llt.compute(A);
    benchmark::DoNotOptimize(llt.matrixLLT().data());
  }
}

/// The QPs of one solve, with the consensus terms that they met there.
struct RecordedQps {
  explicit RecordedQps(const Problem& problem, const bench::State& state)
      : x_desired(problem.x_desired(state)) {
    c3::Settings settings = problem.settings;
    settings.trace = true;
    c3::Solver solver(problem.sizes, settings);
    solver.set_costs(problem.costs, problem.constraints);
    const c3::Solution& solution = solver.solve(state.lcs, state.x0, x_desired);
    MatrixXd r = MatrixXd::Zero(problem.sizes.n_z(), problem.sizes.N);
    if (settings.delta_starts_at_x0) r.topRows(problem.sizes.n_x).colwise() = state.x0;
    for (int i = 0; i < solution.iterations; ++i) {
      const c3::Iterate& iterate = solution.trace[static_cast<std::size_t>(i)];
      rho.push_back(iterate.rho);
      g.push_back(problem.costs.G[0] * r);
      r = iterate.delta - iterate.w;
    }
  }

  MatrixXd x_desired;
  std::vector<double> rho;
  std::vector<MatrixXd> g;
};

/// Time of one of the QPs of Algorithm 1: what is set up once in a solve counts with its share.
void qp_step(benchmark::State& state, const std::string& problem_name, QpBackend backend, int N) {
  const Problem p = baseline_problem(problem_name, N);
  const bench::State& at = p.states[5];
  const RecordedQps qps(p, at);
  const int s = static_cast<int>(qps.g.size());
  if (skip_if_nothing(state, s == 0)) return;
  MatrixXd z = MatrixXd::Zero(p.sizes.n_z(), N);
  VectorXd x_N = VectorXd::Zero(p.sizes.n_x);

  const double start = bench::thread_seconds();
  constexpr int kRounds = 5;
  for (int i = 0; i < kRounds * s; ++i) {
    const auto j = static_cast<std::size_t>(i % s);
    const auto paper = bench::make_paper_qp(p.sizes);
    paper->set_costs(p.costs, p.constraints);
    paper->start({&at.lcs, 0}, {p.costs.G.data(), 0}, nullptr);
    (void)paper->solve(qps.rho[j], at.x0, qps.x_desired, qps.g[j], z, x_N);
  }
  const double baseline = (bench::thread_seconds() - start) / (kRounds * s);

  const auto qp = backend == QpBackend::kDirect ? qp::make_direct_qp(p.sizes)
                  : backend == QpBackend::kInteriorPoint
                      ? qp::make_interior_point_qp(p.sizes)
                      : qp::make_osqp_qp(p.sizes, p.settings.osqp);
  qp->set_costs(p.costs, p.constraints);
  long failed = 0;
  while (state.KeepRunningBatch(s)) {
    qp->start({&at.lcs, 0}, {p.costs.G.data(), 0}, nullptr);
    for (std::size_t i = 0; i < qps.g.size(); ++i) {
      const qp::QpReport report = qp->solve(qps.rho[i], at.x0, qps.x_desired, qps.g[i], z, x_N);
      failed += report.status != qp::QpStatus::kSolved;
      benchmark::DoNotOptimize(z.data());
    }
  }
  state.counters["not_ok"] = static_cast<double>(failed);
  count_speed_up(state, baseline);
}

/// What is projected in one solve, of all rounds and stages: v = z_k + w_k.
MatrixXd projected(const Problem& p, const bench::State& at) {
  c3::Settings settings = p.settings;
  settings.trace = true;
  c3::Solver solver(p.sizes, settings);
  solver.set_costs(p.costs, p.constraints);
  const c3::Solution& solution = solver.solve(at.lcs, at.x0, p.x_desired(at));
  const int rounds = solution.projections;
  MatrixXd v(solution.z.rows(), rounds * p.sizes.N);
  MatrixXd w = MatrixXd::Zero(solution.z.rows(), p.sizes.N);
  for (int i = 0; i < rounds; ++i) {
    const c3::Iterate& iterate = solution.trace[static_cast<std::size_t>(i)];
    v.middleCols(i * p.sizes.N, p.sizes.N) = iterate.z + w;
    w = iterate.w;
  }
  return v;
}

/// Time of one projection, the mean over those of one solve; what is computed once in a solve
/// counts with its share.
void project(benchmark::State& state, const std::string& problem_name, ProjectionKind kind, int N) {
  const Problem p = bench::problem(problem_name, kind, N);
  const bench::State& at = p.states[5];
  const MatrixXd v = projected(p, at);
  if (skip_if_nothing(state, v.cols() == 0)) return;

  const Problem exact = baseline_problem(problem_name, N);
  // Google Benchmark comes here several times until it has found how often to repeat
  static std::map<std::string, double> baselines;
  if (bench::has_miqp_solver() && baselines.count(problem_name) == 0) {
    const bench::State& of_exact = exact.states[5];
    const MatrixXd v_exact = projected(exact, of_exact);
    if (skip_if_nothing(state, v_exact.cols() == 0)) return;
    baselines[problem_name] = bench::paper_projection_time(exact, of_exact, v_exact);
  }

  const auto projection = c3::make_projection(p.sizes, p.settings);
  projection->set_weights(p.costs);
  VectorXd delta(v.rows());
  long nodes = 0, failed = 0;
  while (state.KeepRunningBatch(v.cols())) {
    projection->start(at.lcs);
    for (Eigen::Index k = 0; k < v.cols(); ++k) {
      const c3::ProjectionReport report = projection->project(v.col(k), delta, {});
      nodes += report.nodes;
      failed += report.status != c3::ProjectionStatus::kSolved;
      benchmark::DoNotOptimize(delta.data());
    }
  }
  state.counters["nodes"] = Counter(static_cast<double>(nodes), Counter::kAvgIterations);
  state.counters["not_ok"] = static_cast<double>(failed);
  if (bench::has_miqp_solver()) count_speed_up(state, baselines.at(problem_name));
}

/// A whole solve, the states in turn.
void solve(benchmark::State& state, const std::string& problem_name, ProjectionKind kind, int N) {
  const Problem p = bench::problem(problem_name, kind, N);
  std::vector<MatrixXd> x_desired;
  for (const bench::State& at : p.states) x_desired.push_back(p.x_desired(at));
  c3::Solver solver(p.sizes, p.settings);
  solver.set_costs(p.costs, p.constraints);
  long nodes = 0, failed = 0, qp_iterations = 0;
  while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(p.states.size()))) {
    for (std::size_t i = 0; i < p.states.size(); ++i) {
      const c3::Solution& solution = solver.solve(p.states[i].lcs, p.states[i].x0, x_desired[i]);
      benchmark::DoNotOptimize(solution.z.data());
      nodes += solution.branch_nodes;
      qp_iterations += solution.qp.iterations;
      failed += solution.status != c3::SolveStatus::kOk;
    }
  }
  const double projections = (p.settings.admm_iterations - 1.0) * N;
  state.counters["nodes"] =
      Counter(static_cast<double>(nodes) / projections, Counter::kAvgIterations);
  state.counters["qp_iterations"] =
      Counter(static_cast<double>(qp_iterations), Counter::kAvgIterations);  // of the last QP
  state.counters["not_ok"] = static_cast<double>(failed);
  state.counters["per_stage"] =
      Counter(N, Counter::kIsIterationInvariantRate | Counter::kInvert);  // [s]
  if (const auto paper = bench::paper_solve_time(baseline_problem(problem_name, N))) {
    state.counters["baseline_qp_s"] = paper->qp;
    state.counters["timed"] = paper->timed_projections;
    count_speed_up(state, paper->seconds());
  }
}

/// T-shaped objects lying side by side, moving and turning, the end effector behind the first.
scene::Scene lying(const model::PlanningModel& model) {
  scene::Scene scene = model.layout().world;
  for (int i = 0; i < scene.body_count; ++i) {
    scene.body(i).p_WB << 0.5, 0.2 * i, 0.02;
    scene.body(i).v_WB << 0.05, 0.02, 0.0;
    scene.body(i).omega_WB << 0.0, 0.0, 0.5;
  }
  scene.effector.p_WE << 0.36, 0.03, 0.02;
  return scene;
}

/// The LCS of objects at a scene: contact system and contact model. The baseline knows no
/// derivatives: it takes A and E from central differences, of which the contact systems are timed.
void make_lcs(benchmark::State& state, model::ContactModel contact_model, int objects) {
  const scene::Object t = mjcf::read_object(C3RT_SOURCE_DIRECTORY "/config/objects/t.xml").object;
  const auto model =
      model::make_objects_model({1.0, 0.0195, 0.0, 0.5, 0.4, 0.3, 4, false,
                                 std::vector<scene::Object>(static_cast<std::size_t>(objects), t)});
  const scene::Scene scene = lying(*model);
  const std::vector<int> contacts = model::all_contacts(model->layout());

  const double start = bench::thread_seconds();
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < model->layout().n_v; ++i) {
      const VectorXd v = VectorXd::Unit(model->layout().n_v, i);
      for (const double by : {1e-6, -1e-6}) {
        // a step of the position, and one of the velocity
        const model::ContactSystem of_q =
            model->contact_system(model::moved(scene, v, by), contacts);
        const model::ContactSystem of_v = model->contact_system(scene, contacts);
        benchmark::DoNotOptimize(of_q.phi.data());
        benchmark::DoNotOptimize(of_v.phi.data());
      }
    }
    benchmark::DoNotOptimize(
        model::to_lcs(contact_model, model->contact_system(scene, contacts), 0.05).A.data());
  }
  const double baseline = (bench::thread_seconds() - start) / kRounds;

  model::ContactSystem system;
  model::LcsStorage storage;
  lcs::Lcs lcs;
  for (auto _ : state) {
    model->evaluate(scene, contacts, system);
    model::to_lcs(contact_model, system, 0.05, storage, lcs);
    benchmark::DoNotOptimize(lcs.A.data());
  }
  state.counters["n_x"] = model->layout().n_x;
  state.counters["n_lambda"] = static_cast<double>(lcs.F.rows());
  count_speed_up(state, baseline);
}

template <typename F, typename... Arguments>
void add(const std::string& name, F* function, Arguments... arguments) {
  benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    function(state, arguments...);
  })->Unit(benchmark::kMicrosecond);
}

void add_all() {
  const std::string cart_pole = "cart_pole", gaiting = "gaiting", pivoting = "pivoting",
                    one = "1_ball", two = "2_balls", three = "3_balls";
  const auto both = {QpBackend::kInteriorPoint, QpBackend::kOsqp};
  const auto all = {QpBackend::kDirect, QpBackend::kInteriorPoint, QpBackend::kOsqp};
  const auto add_qp = [](const std::string& problem, QpBackend backend, int N) {
    add("qp_step/" + problem + "/" + name(backend), qp_step, problem, backend, N);
  };
  for (const std::string& problem : {cart_pole, pivoting}) {
    for (const QpBackend backend : all) add_qp(problem, backend, 10);
  }
  for (const QpBackend backend : both) add_qp(gaiting, backend, 10);
  for (const std::string& problem : {one, two, three}) {
    for (const QpBackend backend : all) add_qp(problem, backend, 5);
  }

  for (const int objects : {1, 2, 3, 4}) {
    add("lcs/" + std::to_string(objects) + "_t/anitescu", make_lcs, model::ContactModel::kAnitescu,
        objects);
    add("lcs/" + std::to_string(objects) + "_t/stewart_trinkle", make_lcs,
        model::ContactModel::kStewartTrinkle, objects);
  }

  bench::add_candidates();

  constexpr auto kMiqp = ProjectionKind::kMiqp, kLcp = ProjectionKind::kLcp,
                 kAdmm = ProjectionKind::kAdmm, kConvex = ProjectionKind::kConvex,
                 kPlus = ProjectionKind::kPlus;
  const auto add_project = [](const std::string& problem, int N,
                              std::vector<ProjectionKind> kinds) {
    for (const ProjectionKind kind : kinds) {
      add("project/" + problem + "/" + name(kind), project, problem, kind, N);
    }
  };
  add_project(cart_pole, 10, {kMiqp, kLcp, kAdmm, kConvex, kPlus});
  add_project(gaiting, 10, {kMiqp, kAdmm, kPlus});
  add_project(pivoting, 10, {kMiqp, kAdmm, kPlus});
  add_project(one, 5, {kMiqp, kAdmm, kConvex, kPlus});
  add_project(two, 5, {kMiqp, kPlus});
  add_project(three, 5, {kMiqp, kConvex, kPlus});

  const auto add_solve = [](const std::string& problem, std::vector<ProjectionKind> kinds) {
    for (const ProjectionKind kind : kinds) {
      for (const int N : {5, 10, 20, 30, 50}) {
        add("solve/" + problem + "/" + name(kind) + "/" + std::to_string(N), solve, problem, kind,
            N);
      }
    }
  };
  add_solve(cart_pole, {kMiqp, kLcp, kAdmm, kConvex, kPlus});
  add_solve(gaiting, {kMiqp});
  add_solve(pivoting, {kMiqp});
  add_solve(one, {kMiqp, kConvex, kPlus});
  add_solve(two, {kMiqp, kPlus});
  add_solve(three, {kMiqp, kConvex, kPlus});
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::AddCustomContext(
      "baseline", bench::has_miqp_solver()
                      ? "OSQP set up for every QP, MIQP by big-M (M = 1000) and Bonmin, one thread"
                      : "none for projections and solves: no general MIQP solver (Debian: "
                        "coinor-libbonmin-dev) when this was built");
  benchmark::RegisterBenchmark("machine/cholesky_100", cholesky)->Unit(benchmark::kMicrosecond);
  add_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return nothing_to_time ? 1 : 0;
}
