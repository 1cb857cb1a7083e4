#pragma once
// The problem file of `c3rt solve` (schema c3-problem-1) and its result (c3-result-1).
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "config/section.hpp"
#include "controller/c3/solver.hpp"

namespace c3rt::config {

enum class Method { kC3, kMiqp15 };

/// One problem, checked: whatever is in here can be given to c3::Solver.
struct ProblemFile {
  c3::Sizes sizes;
  std::vector<lcs::Lcs> lcs;  // one for all stages, or N
  c3::Costs costs;
  c3::Constraints constraints;
  c3::Settings settings;
  double big_M;  // of MIQP15
  Eigen::VectorXd x0;
  Eigen::MatrixXd x_desired;  // (n_x × N+1)
  Method method;
  std::optional<double> deadline_s;
  int threads;
};

/// @param name of the file, for messages
/// @throws ConfigError naming the key, what was expected and what came:
/// "problem.json: params.G: expected 7 x 7, got 6 x 7"
ProblemFile parse_problem(const std::string& text, const std::string& name);

/// Reads the file. @throws ConfigError also where it cannot be read
ProblemFile load_problem(const std::string& path);

/// What the result file says beside the iterates.
struct ProblemResult {
  std::string status;  // "ok", "truncated", "fail: why"
  Eigen::MatrixXd x;   // (n_x × N+1)
  Eigen::MatrixXd lambda, u;
  double objective;  // cost (14) of x and u, x_0's term included
  double complementarity_violation;
  int iterations;
  double solve_time_s;
  std::string note;                     // why an answer is truncated, for a person
  std::optional<c3::QpReport> qp = {};  // of the last QP of Algorithm 1, of a failed one too
  // of MIQP15 with an answer: no plan costs less than the bound, and what that is of the objective
  std::optional<double> lower_bound = {}, gap = {};
};

/// Of a solution of Algorithm 1; `iterates` of the solver's trace are written if it kept one.
ProblemResult to_result(const ProblemFile& problem, const c3::Solution& solution,
                        double solve_time_s);
std::string to_json(const ProblemFile& problem, const ProblemResult& result,
                    const std::vector<c3::Iterate>& iterates);

}  // namespace c3rt::config
