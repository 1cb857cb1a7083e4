#include "cli/monolithic.hpp"

#include <chrono>
#include <limits>

namespace c3rt::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kGap = 1e-7;

}  // namespace

MonolithicAnswer solve_monolithic(const config::ProblemFile& problem,
                                  const c3::Deadline& deadline) {
  const Clock::time_point start = Clock::now();
  const horizon::SearchResult found =
      horizon::search({problem.sizes,
                       {problem.lcs.data(), problem.lcs.size() == 1 ? 0 : 1},
                       &problem.costs,
                       &problem.constraints,
                       problem.x_desired,
                       problem.x0},
                      {std::numeric_limits<long>::max(), kGap}, {}, deadline);
  const double solve_time_s = std::chrono::duration<double>(Clock::now() - start).count();
  const c3::Sizes& s = problem.sizes;
  config::ProblemResult result{"",
                               Eigen::MatrixXd::Zero(s.n_x, s.N + 1),
                               Eigen::MatrixXd::Zero(s.n_lambda, s.N),
                               Eigen::MatrixXd::Zero(s.n_u, s.N),
                               0.0,
                               0.0,
                               static_cast<int>(found.nodes),
                               solve_time_s,
                               "",
                               {},
                               {},
                               {}};
  if (found.plan) {
    result.status = found.is_proven() ? "ok" : "truncated";
    result.x = found.plan->x;
    result.lambda = found.plan->lambda;
    result.u = found.plan->u;
    result.objective = found.plan->objective;
    result.complementarity_violation = found.plan->complementarity_violation;
    result.note = horizon::describe(found);
    result.gap = found.gap;
    result.lower_bound = found.lower_bound;
  } else {
    result.status = "fail: " + horizon::describe(found);
  }
  return {result, found.plan.has_value(),
          found.plan.has_value() || found.status == horizon::SearchStatus::kInfeasible};
}

}  // namespace c3rt::cli
