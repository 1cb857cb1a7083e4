#include "cli/solve.hpp"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "config/problem_file.hpp"
#include "controller/rt/worker_pool.hpp"
#ifdef C3RT_HAS_MIQP
#include "controller/miqp/monolithic.hpp"
#endif

namespace c3rt::cli {
namespace {

using Clock = std::chrono::steady_clock;

bool is_past(void* context) noexcept {
  return Clock::now() >= *static_cast<const Clock::time_point*>(context);
}

/// A column is one number: the whole answer in a few lines.
void print_summary(const config::ProblemResult& result) {
  std::string u_0;
  for (Eigen::Index i = 0; i < result.u.rows(); ++i) u_0 += fmt::format(" {:.6g}", result.u(i, 0));
  fmt::print(
      stderr,
      "c3rt: {}: u_0 ={}, objective {:.6g}, complementarity violation {:.2g}, {} iterations, "
      "{:.3g} ms\n",
      result.status, u_0, result.objective, result.complementarity_violation, result.iterations,
      1e3 * result.solve_time_s);
}

void write(const std::string& text, const std::string& out) {
  if (out.empty() || out == "-") {
    fmt::print("{}", text);
    return;
  }
  std::ofstream file(out);
  file << text;
  file.close();
  if (!file) throw UsageError(fmt::format("{}: expected a file that can be written", out));
}

/// What a call came to: the text of the result file, and whether there is an answer.
struct Answer {
  config::ProblemResult result;
  std::string json;
  bool found;
};

#ifdef C3RT_HAS_MIQP
Answer solve_monolithic(const config::ProblemFile& problem, const std::string&) {
  const Clock::time_point start = Clock::now();
  miqp::MonolithicSettings settings;
  settings.big_m = problem.big_M;
  if (problem.deadline_s) settings.solver.max_seconds = *problem.deadline_s;
  const miqp::MonolithicResult found =
      miqp::solve_monolithic({problem.sizes,
                              {problem.lcs.data(), problem.lcs.size() == 1 ? 0 : 1},
                              &problem.costs,
                              &problem.constraints,
                              problem.x_desired,
                              problem.x0},
                             settings);
  const double solve_time_s = std::chrono::duration<double>(Clock::now() - start).count();
  const c3::Sizes& s = problem.sizes;
  config::ProblemResult result{"",
                               Eigen::MatrixXd::Zero(s.n_x, s.N + 1),
                               Eigen::MatrixXd::Zero(s.n_lambda, s.N),
                               Eigen::MatrixXd::Zero(s.n_u, s.N),
                               0.0,
                               0.0,
                               static_cast<int>(found.nodes),
                               solve_time_s};
  const bool has_plan =
      found.status == miqp::Status::kOptimal || found.status == miqp::Status::kFeasible;
  if (has_plan) {
    result.status = found.status == miqp::Status::kOptimal ? "ok" : "truncated";
    result.x = found.plan.x;
    result.lambda = found.plan.lambda;
    result.u = found.plan.u;
    result.objective = found.plan.objective;
    result.complementarity_violation = found.plan.complementarity_violation;
  } else {
    result.status = found.status == miqp::Status::kInfeasible
                        ? "fail: there is no point with lambda and gaps up to params.M"
                        : "fail: the MIQP solver ended without a point";
  }
  return {result, config::to_json(problem, result, {}), has_plan};
}
#else
Answer solve_monolithic(const config::ProblemFile&, const std::string& path) {
  throw UsageError(path +
                   ": method: expected C3, got \"MIQP15\": this build has no MIQP solver (Debian: "
                   "coinor-libbonmin-dev, then configure again)");
}
#endif

Answer solve_c3(const config::ProblemFile& problem) {
  rt::WorkerPool pool(problem.threads);
  c3::Parallel parallel;
  if (problem.threads > 1) parallel = {&rt::WorkerPool::run_on, &pool, problem.threads};
  c3::Solver solver(problem.sizes, problem.settings, parallel);
  solver.set_costs(problem.costs, problem.constraints);

  const Clock::time_point start = Clock::now();
  Clock::time_point end = start;
  c3::Deadline deadline;
  if (problem.deadline_s) {
    end += std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(std::min(*problem.deadline_s, 1e6)));
    deadline = {&is_past, &end};
  }
  const c3::Solution& solution =
      problem.lcs.size() == 1
          ? solver.solve(problem.lcs.front(), problem.x0, problem.x_desired, deadline)
          : solver.solve(problem.lcs, problem.x0, problem.x_desired, deadline);
  const double solve_time_s = std::chrono::duration<double>(Clock::now() - start).count();

  const config::ProblemResult result = config::to_result(problem, solution, solve_time_s);
  return {result, config::to_json(problem, result, solution.trace),
          solution.status != c3::SolveStatus::kFailed};
}

}  // namespace

int solve(const std::string& path, const std::string& out) {
  const config::ProblemFile problem = config::load_problem(path);
  const Answer answer = problem.method == config::Method::kMiqp15 ? solve_monolithic(problem, path)
                                                                  : solve_c3(problem);
  write(answer.json, out);
  print_summary(answer.result);
  return answer.found ? kDone : kCriterionFailed;
}

}  // namespace c3rt::cli
