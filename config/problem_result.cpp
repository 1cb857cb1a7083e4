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
    case c3::ProjectionStatus::kEmpty:
      return "no point";
    case c3::ProjectionStatus::kNotFound:
      return "no point found";
    case c3::ProjectionStatus::kNotConvex:
      return "not convex";
    case c3::ProjectionStatus::kInaccurate:
      return "inaccurate";
    case c3::ProjectionStatus::kNotFinite:
      return "not finite";
  }
  return "";
}

const lcs::Lcs& system(const ProblemFile& problem, int k) {
  return problem.lcs[problem.lcs.size() == 1 ? 0 : static_cast<std::size_t>(k)];
}

const char* why(c3::QpStatus status) {
  switch (status) {
    case c3::QpStatus::kInfeasible:
      return "the bounds cannot be met";
    case c3::QpStatus::kNotConverged:
      return "the QP did not converge";
    case c3::QpStatus::kNotFactorable:
      return "the QP is beyond double precision";
    case c3::QpStatus::kSolved:
      break;
  }
  return "the QP was not solved";
}

/// Why the projection of a stage has no point.
std::string why_no_point(const ProblemFile& problem, const c3::ProjectionReport& report, int k) {
  const c3::ProjectionType& type = c3::projection_type(problem.settings.projection);
  if (type.why_no_point != nullptr) {
    std::string own =
        type.why_no_point(report, problem.settings, problem.costs, system(problem, k));
    if (!own.empty()) return own;
  }
  switch (report.status) {
    case c3::ProjectionStatus::kEmpty:
      return "the set that the projection is onto is empty: no x, u and lambda >= 0 have "
             "E x + F lambda + H u + c >= 0";
    case c3::ProjectionStatus::kNotFound:
      return "the projection's search ended in rounding before it found a point";
    case c3::ProjectionStatus::kNotConvex:
      return "the projection is not convex";
    case c3::ProjectionStatus::kInaccurate:
      return "of the projection's point no digits are left: weights or units lie too far apart";
    case c3::ProjectionStatus::kNotFinite:
      return "numbers beyond double precision";
    case c3::ProjectionStatus::kSolved:
    case c3::ProjectionStatus::kNodeLimit:
    case c3::ProjectionStatus::kDeadline:
      break;
  }
  return "the projection has no point";
}

std::string status_of(const ProblemFile& problem, const c3::Solution& solution) {
  if (solution.status == c3::SolveStatus::kOk) return "ok";
  if (solution.status == c3::SolveStatus::kTruncated) return "truncated";
  switch (solution.failure) {
    case c3::Failure::kLambda0:
      return "fail: the LCP at x0 has no solution that Lemke's method finds";
    case c3::Failure::kQp:
      return std::string("fail: ") + why(solution.qp.status);
    case c3::Failure::kProjection:
      return "fail: stage " + std::to_string(solution.failed_stage) + ": " +
             why_no_point(problem, solution.projection, solution.failed_stage);
    case c3::Failure::kNotFinite:
      return "fail: numbers beyond double precision";
    case c3::Failure::kNoCosts:
    case c3::Failure::kWrongSize:
    case c3::Failure::kNone:
      break;
  }
  return "fail: not a problem that can be solved";
}

/// "" or why a truncated answer is less than Algorithm 1.
std::string note_of(const ProblemFile& problem, const c3::Solution& solution) {
  if (solution.status != c3::SolveStatus::kTruncated) return "";
  if (solution.inexact_projections == 0) return "the deadline struck";
  return std::to_string(solution.inexact_projections) + " of " +
         std::to_string(solution.projections * problem.sizes.N) +
         " projections are not proven the nearest: their search ended early (max_nodes = " +
         std::to_string(problem.settings.max_nodes) + ")";
}

/// 1 where λ is free and its gap zero, 0 where λ is zero.
Json modes(const ProblemFile& p, int k, const VectorXd& delta) {
  const lcs::Lcs& lcs = system(p, k);
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
  return {status_of(problem, solution),
          x,
          solution.z.middleRows(s.n_x, s.n_lambda),
          solution.z.middleRows(s.n_x + s.n_lambda, s.n_u),
          c3::cost(problem.costs, s, problem.x_desired, solution.z, solution.x_N),
          solution.complementarity_violation,
          solution.iterations,
          solve_time_s,
          note_of(problem, solution),
          solution.qp,
          {},
          {}};
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
  if (result.qp) {  // a number that is not finite becomes null
    json["qp_primal_residual"] = result.qp->primal_residual;
    json["qp_dual_residual"] = result.qp->dual_residual;
  }
  if (result.lower_bound) json["lower_bound"] = *result.lower_bound;
  if (result.gap) json["gap"] = *result.gap;
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
                     {"qp_primal_residual", iterate.qp.primal_residual},
                     {"qp_dual_residual", iterate.qp.dual_residual},
                     {"delta", columns(iterate.delta)},
                     {"w", columns(iterate.w)},
                     {"proj", projections}});
  }
  json["iters"] = iters;
  return json.dump(1) + "\n";
}

}  // namespace c3rt::config
