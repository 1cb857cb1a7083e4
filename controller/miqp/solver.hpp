#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace c3rt::miqp {

/// A convex quadratic programme with some variables restricted to 0 or 1:
///
///   minimise xᵀ P x + 2 qᵀ x + constant   with   l ≤ A x ≤ u,   x_min ≤ x ≤ x_max,   x_b ∈ {0, 1}
///
/// There is no ½. ±infinity where there is no bound.
struct Problem {
  Eigen::SparseMatrix<double> P;  // (n × n) symmetric positive semidefinite
  Eigen::VectorXd q;              // (n)
  double constant = 0.0;          // counts in the relative gap
  Eigen::SparseMatrix<double> A;  // (m × n)
  Eigen::VectorXd l, u;           // (m)
  Eigen::VectorXd x_min, x_max;   // (n)
  std::vector<int> binaries;      // indices b
};

struct Settings {
  double relative_gap = 1e-4;  // of |objective|: this close to the proven bound is optimal
  double absolute_gap = 1e-6;  // the same, absolute, for objectives near zero
  double tolerance = 1e-9;     // of the QP of one node
  double integer_tolerance = 1e-6;
  int max_nodes = 1'000'000;
  double max_seconds = 1e6;  // CPU time, looked at between nodes
};

enum class Status {
  kOptimal,     // within the gap of the proven bound
  kFeasible,    // a limit ended the search with this point
  kInfeasible,  // proven
  kFailed,      // a limit ended the search without a point, or the solver gave up
};

struct Result {
  Status status = Status::kFailed;
  Eigen::VectorXd x;       // (n), empty unless optimal or feasible
  double objective = 0.0;  // at x
  double gap = 0.0;        // (objective − proven bound) / max(|objective|, 1)
  long nodes = 0;
};

/// Branch and bound by Bonmin (its QPs by Ipopt, its tree by Cbc), in the calling thread. Writes
/// nothing to the standard streams and reads no file of options. Not RT. Not for two threads at a
/// time: Ipopt's linear solver keeps global state.
/// @throws std::invalid_argument naming the field whose size is wrong, that is not finite, or the
///         binary that is not a variable
Result solve(const Problem& problem, const Settings& settings);

}  // namespace c3rt::miqp
