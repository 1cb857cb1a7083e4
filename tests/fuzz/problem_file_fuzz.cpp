// The problem reader and the solver behind it: any text gives a ConfigError or a problem; a problem
// that is small is solved within a bounded number of steps, and numbers that are not finite come
// only with a status that says so.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "config/problem_file.hpp"
#include "controller/c3/solver.hpp"
#include "tests/fuzz/promise.hpp"

namespace {

using namespace c3rt;

/// Strikes when it has been asked often enough: a deadline without a clock.
bool is_struck(void* context) noexcept { return --*static_cast<long*>(context) < 0; }

void solve(config::ProblemFile& p) {
  c3::Settings& settings = p.settings;
  settings.admm_iterations = std::min(settings.admm_iterations, 3);
  settings.max_nodes = std::min(settings.max_nodes, 200);
  settings.osqp.max_iterations = std::min(settings.osqp.max_iterations, 200);
  c3::Solver solver(p.sizes, settings);
  solver.set_costs(p.costs, p.constraints);
  long questions = 1000;
  const c3::Deadline deadline{&is_struck, &questions};
  const c3::Solution& s = p.lcs.size() == 1
                              ? solver.solve(p.lcs.front(), p.x0, p.x_desired, deadline)
                              : solver.solve(p.lcs, p.x0, p.x_desired, deadline);
  require((s.status == c3::SolveStatus::kFailed) == (s.failure != c3::Failure::kNone),
          "a failure has a reason, an answer has none");
  const bool finite = s.z.allFinite() && s.x_N.allFinite() && s.delta.allFinite() &&
                      s.w.allFinite() && std::isfinite(s.complementarity_violation);
  require(finite || s.status == c3::SolveStatus::kFailed, "no NaN without a status");
  require(questions > -1000, "nothing goes on for long after the deadline");
  (void)config::to_json(p, config::to_result(p, s, 0.0), s.trace);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    config::ProblemFile p =
        config::parse_problem(std::string(reinterpret_cast<const char*>(data), size), "fuzz");
    const bool small = p.sizes.N <= 20 && p.sizes.n_lambda <= 10 && p.sizes.n_z() <= 30;
    if (small && p.method == config::Method::kC3) solve(p);
  } catch (const config::ConfigError&) {
  }
  return 0;
}
