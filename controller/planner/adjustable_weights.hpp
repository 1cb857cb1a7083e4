#pragma once
// Which weights of Algorithm 1 a client may change while the planner runs, and how far.
#include <map>
#include <string>
#include <vector>

#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// A weight of the scenario as the planner uses it (for another ball than `tuned_for` it is the
/// one carried over), and the range in which a client may choose.
struct AdjustableWeight {
  /// Below planner.weights: "roll.Q.ball_xy", "roll.Q.ball_xy.1" of the second of a list.
  std::string name;
  double value, min, max;
};

/// Weights by AdjustableWeight::name.
using NamedWeights = std::map<std::string, double>;

/// Q, R, G and U of every phase that the strategy has, each within the scenario's adjustable_by
/// times and a part of its own value. Empty where the scenario allows none; a weight of 0, which
/// nothing can be times of, is not among them.
std::vector<AdjustableWeight> adjustable_weights(const Parameters& scenario);

/// Why these cannot be taken: what was expected and what came; empty where they can.
std::string refusal(const NamedWeights& wanted, const std::vector<AdjustableWeight>& allowed);

/// The parameters with these weights; names that they do not have are passed over.
Parameters with_weights(const Parameters& parameters, const NamedWeights& wanted);

/// "roll.Q.ball_xy 1e+06, roll.R 0.02"
std::string describe(const NamedWeights& weights);

}  // namespace c3rt::planner
