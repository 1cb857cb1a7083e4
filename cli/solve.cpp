#include "cli/solve.hpp"

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "cli/monolithic.hpp"
#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "config/problem_file.hpp"
#include "controller/rt/worker_pool.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kFirstNote(2), kNoteEvery(10);

/// Ends a solve at its deadline or at Ctrl-C, and says that it still works where it takes long.
struct Watch {
  Clock::time_point start = Clock::now(), end = Clock::time_point::max(), note = start + kFirstNote;

  static bool reached(void* context) noexcept {
    Watch& watch = *static_cast<Watch*>(context);
    const Clock::time_point now = Clock::now();
    if (now >= watch.note) {
      std::fprintf(stderr, "c3rt: solving since %.0f s; Ctrl-C ends with the best so far\n",
                   std::chrono::duration<double>(now - watch.start).count());
      watch.note = now + kNoteEvery;
    }
    return now >= watch.end || wire::StopFlag::requested();
  }
};

/// One line for a person. Where there is no answer it has no number that could be taken for one.
void print_summary(const config::ProblemResult& result, bool found) {
  std::string line =
      fmt::format("c3rt: {}{}{}", result.status, result.note.empty() ? "" : ": ", result.note);
  if (found) {
    std::string u_0 = result.u.rows() == 0 ? " none" : "";
    for (Eigen::Index i = 0; i < result.u.rows(); ++i)
      u_0 += fmt::format(" {:.6g}", result.u(i, 0));
    line += fmt::format(": u_0 ={}, objective {:.6g}, complementarity violation {:.2g}", u_0,
                        result.objective, result.complementarity_violation);
  }
  line += fmt::format(", {} iterations, {:.3g} ms\n", result.iterations, 1e3 * result.solve_time_s);
  std::fputs(line.c_str(), stderr);
}

bool is_standard_output(const std::string& out) { return out.empty() || out == "-"; }

/// Before the work, which would be lost.
void require_place(const std::string& out, const std::string& problem) {
  namespace fs = std::filesystem;
  if (is_standard_output(out)) return;
  const auto refuse = [&](const std::string& expected) {
    throw UsageError(fmt::format("--out: expected {}, got {}", expected, out));
  };
  std::error_code error;
  if (fs::equivalent(problem, out, error)) refuse("another file than the problem's");
  if (fs::is_directory(out, error)) refuse("a file that can be written, not a folder");
  const fs::path folder = fs::path(out).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error)) refuse("a file in a folder that exists");
  if (fs::exists(out, error) && access(out.c_str(), W_OK) != 0) {
    refuse("a file that can be written");
  }
}

/// @throws std::runtime_error where it does not get there
void write(const std::string& text, const std::string& out) {
  if (!is_standard_output(out)) return write_text(out, text);
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    throw std::runtime_error(
        fmt::format("cannot write the result to standard output: {}", std::strerror(errno)));
  }
}

/// What a call came to: the text of the result file, and whether there is an answer.
struct Answer {
  config::ProblemResult result;
  std::string json;
  bool found;
  int exit_status;
};

Answer solve_15(const config::ProblemFile& problem, const c3::Deadline& deadline) {
  const MonolithicAnswer answer = solve_monolithic(problem, deadline);
  const int none = answer.decided ? kCriterionFailed : kUndecided;
  return {answer.result, config::to_json(problem, answer.result, {}), answer.found,
          answer.found ? kDone : none};
}

Answer solve_c3(const config::ProblemFile& problem, const c3::Deadline& deadline) {
  rt::WorkerPool pool(problem.threads);
  c3::Parallel parallel;
  if (problem.threads > 1) parallel = {&rt::WorkerPool::run_on, &pool, problem.threads};
  c3::Solver solver(problem.sizes, problem.settings, parallel);
  solver.set_costs(problem.costs, problem.constraints);

  const Clock::time_point start = Clock::now();
  const c3::Solution& solution =
      problem.lcs.size() == 1
          ? solver.solve(problem.lcs.front(), problem.x0, problem.x_desired, deadline)
          : solver.solve(problem.lcs, problem.x0, problem.x_desired, deadline);
  const double solve_time_s = std::chrono::duration<double>(Clock::now() - start).count();

  const config::ProblemResult result = config::to_result(problem, solution, solve_time_s);
  const bool found = solution.status != c3::SolveStatus::kFailed;
  return {result, config::to_json(problem, result, solution.trace), found,
          found ? kDone : kCriterionFailed};
}

}  // namespace

int solve(const std::string& path, const std::string& out) {
  require_place(out, path);
  const config::ProblemFile problem = config::load_problem(path);
  Watch watch;
  if (problem.deadline_s) {
    watch.end =
        watch.start + std::chrono::duration_cast<Clock::duration>(
                          std::chrono::duration<double>(std::min(*problem.deadline_s, 1e6)));
  }
  const c3::Deadline deadline{&Watch::reached, &watch};
  const Answer answer = problem.method == config::Method::kMiqp15 ? solve_15(problem, deadline)
                                                                  : solve_c3(problem, deadline);
  write(answer.json, out);
  print_summary(answer.result, answer.found);
  return answer.exit_status;
}

}  // namespace c3rt::cli
