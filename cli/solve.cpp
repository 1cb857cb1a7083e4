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

}  // namespace

int solve(const std::string& path, const std::string& out) {
  const config::ProblemFile problem = config::load_problem(path);
  if (problem.method == config::Method::kMiqp15) {
    throw UsageError(path + ": method: expected C3, got \"MIQP15\"");
  }
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
  write(config::to_json(problem, result, solution.trace), out);
  print_summary(result);
  return solution.status == c3::SolveStatus::kFailed ? kCriterionFailed : kDone;
}

}  // namespace c3rt::cli
