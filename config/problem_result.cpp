#include <nlohmann/json.hpp>

#include "config/problem_file.hpp"

namespace c3rt::config {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::json;

Json to_json(const Eigen::Ref<const VectorXd>& v) {
  Json out = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) out.push_back(v[i]);
  return out;
}

/// Column by column: one list a stage.
Json columns(const MatrixXd& m) {
  Json out = Json::array();
  for (Eigen::Index k = 0; k < m.cols(); ++k) out.push_back(to_json(VectorXd(m.col(k))));
  return out;
}

const char* text(c3::ProjectionStatus status) {
  switch (status) {
    case c3::ProjectionStatus::kSolved:
      return "ok";
    case c3::ProjectionStatus::kNodeLimit:
      return "node limit";
    case c3::ProjectionStatus::kDeadline:
      return "deadline";
    case c3::ProjectionStatus::kNone:
      return "no point found";
    case c3::ProjectionStatus::kNotFinite:
      return "not finite";
  }
  return "";
}

std::string status_of(const c3::Solution& solution) {
  if (solution.status == c3::SolveStatus::kOk) return "ok";
  if (solution.status == c3::SolveStatus::kTruncated) return "truncated";
  switch (solution.failure) {
    case c3::Failure::kLambda0:
      return "fail: the LCP at x0 has no solution that Lemke's method finds";
    case c3::Failure::kQp:
      return solution.qp.status == c3::QpStatus::kInfeasible
                 ? "fail: the bounds cannot be met"
                 : "fail: the QP is beyond double precision";
    case c3::Failure::kProjection:
      return "fail: the projection found no point of the LCP's set";
    case c3::Failure::kNotFinite:
      return "fail: numbers beyond double precision";
    default:
      return "fail: not a problem that can be solved";
  }
}

/// 1 where λ is free and its gap zero, 0 where λ is zero.
Json modes(const ProblemFile& p, int k, const VectorXd& delta) {
  const lcs::Lcs& lcs = p.lcs[p.lcs.size() == 1 ? 0 : static_cast<std::size_t>(k)];
  const VectorXd lambda = p.sizes.lambda(delta);
  const VectorXd y = lcs.E * p.sizes.x(delta) + lcs.F * lambda + lcs.H * p.sizes.u(delta) + lcs.c;
  Json out = Json::array();
  for (Eigen::Index j = 0; j < y.size(); ++j) out.push_back(lambda[j] > y[j] ? 1 : 0);
  return out;
}

}  // namespace

ProblemResult to_result(const ProblemFile& problem, const c3::Solution& solution,
                        double solve_time_s) {
  const c3::Sizes& s = problem.sizes;
  MatrixXd x(s.n_x, s.N + 1);
  x << solution.z.topRows(s.n_x), solution.x_N;
  return {status_of(solution),
          x,
          solution.z.middleRows(s.n_x, s.n_lambda),
          solution.z.middleRows(s.n_x + s.n_lambda, s.n_u),
          c3::cost(problem.costs, s, problem.x_desired, solution.z, solution.x_N),
          solution.complementarity_violation,
          solution.iterations,
          solve_time_s};
}

std::string to_json(const ProblemFile& problem, const ProblemResult& result,
                    const std::vector<c3::Iterate>& iterates) {
  Json json{{"schema", "c3-result-1"},
            {"status", result.status},
            {"u0", to_json(VectorXd(result.u.col(0)))},
            {"x", columns(result.x)},
            {"lam", columns(result.lambda)},
            {"u", columns(result.u)},
            {"objective", result.objective},
            {"complementarity_violation", result.complementarity_violation},
            {"iterations", result.iterations},
            {"solve_time_s", result.solve_time_s}};
  if (!problem.settings.trace) return json.dump(1) + "\n";
  Json iters = Json::array();
  for (int i = 0; i < result.iterations && i < static_cast<int>(iterates.size()); ++i) {
    const c3::Iterate& iterate = iterates[static_cast<std::size_t>(i)];
    // of a failed solve the complete turns, as in the golden files
    if (iterate.projections == 0 && result.status.rfind("fail", 0) == 0) break;
    Json projections = Json::array();
    for (int k = 0; k < iterate.projections; ++k) {
      const c3::ProjectionReport& report = iterate.projection[static_cast<std::size_t>(k)];
      projections.push_back({{"status", text(report.status)},
                             {"obj", report.objective},
                             {"nodes", report.nodes},
                             {"mode", modes(problem, k, iterate.delta.col(k))}});
    }
    iters.push_back({{"rho", iterate.rho},
                     {"z", columns(iterate.z)},
                     {"xN", to_json(iterate.x_N)},
                     {"delta", columns(iterate.delta)},
                     {"w", columns(iterate.w)},
                     {"proj", projections}});
  }
  json["iters"] = iters;
  return json.dump(1) + "\n";
}

}  // namespace c3rt::config
