#pragma once

#include "controller/horizon/problem.hpp"
#include "controller/miqp/solver.hpp"

namespace c3rt::miqp {

struct MonolithicSettings {
  double big_m = 1000.0;  // λ ≤ M b, y ≤ M (1 − b)
  Settings solver = {};
};

struct MonolithicResult {
  // optimal: the modes' exact plan is within the gap of the solver's bound. Bound and infeasibility
  // are the solver's word, to the tolerance of its QPs and below big_m: a baseline, no proof
  Status status = Status::kFailed;
  horizon::Plan plan;  // where status is optimal or feasible
  double gap = 0.0;    // |plan.objective − the solver's bound| / max(|plan.objective|, 1)
  long nodes = 0;
  double largest = 0.0;  // of all λ and y of the plan: near M, a larger M may have a better plan
  bool is_polished = false;  // the modes were solved once more without M
};

/// The monolithic MIQP [C3, eq. (15)] with big-M, as the paper's tables compare with. A leak of
/// complementarity of the size (integer tolerance) × M is taken out afterwards: the modes that the
/// solver found are solved once more, exactly.
/// @throws std::invalid_argument unless the problem's costs are finite and big_m is positive
MonolithicResult solve_monolithic(const horizon::Problem& problem,
                                  const MonolithicSettings& settings);

}  // namespace c3rt::miqp
