#include "controller/planner/adjustable_weights.hpp"

#include <algorithm>
#include <utility>

#include "controller/base/words.hpp"

namespace c3rt::planner {
namespace {

/// Calls `action(name, weight)` with every weight of Q, R, G and U of a phase.
template <typename Weights, typename Action>
void each(const std::string& phase, Weights& weights, Action&& action) {
  for (auto& [block, values] : weights.Q) {
    for (std::size_t i = 0; i < values.size(); ++i)
      action(phase + ".Q." + block + (values.size() > 1 ? "." + std::to_string(i) : ""), values[i]);
  }
  action(phase + ".R", weights.R);
  action(phase + ".G.x", weights.G_x);
  action(phase + ".G.u", weights.G_u);
  for (auto& [of, value] : weights.G_lambda) action(phase + ".G." + of, value);
  action(phase + ".U.x", weights.U_x);
  action(phase + ".U.lambda", weights.U_lambda);
  action(phase + ".U.u", weights.U_u);
}

/// Of all phases, by their keys in a scenario.
template <typename OfPlanner, typename Action>
void each(OfPlanner& parameters, Action&& action) {
  each("roll", parameters.roll, action);
  each("return", parameters.back, action);
  each("push", parameters.sampling.weights, action);
}

/// How many letters two names begin with in common.
std::size_t common(const std::string& a, const std::string& b) {
  const std::size_t shorter = std::min(a.size(), b.size());
  return static_cast<std::size_t>(
      std::mismatch(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(shorter), b.begin()).first -
      a.begin());
}

/// The names most like one that is none, as many as a reply has room for.
std::string like(const std::string& name, std::vector<AdjustableWeight> allowed) {
  constexpr std::size_t kMost = 8;
  std::stable_sort(allowed.begin(), allowed.end(), [&](const auto& a, const auto& b) {
    return common(a.name, name) > common(b.name, name);
  });
  std::string names;
  for (std::size_t i = 0; i < std::min(kMost, allowed.size()); ++i)
    names += (i > 0 ? ", " : "") + allowed[i].name;
  return names + (allowed.size() > kMost ? ", ..." : "");
}

}  // namespace

std::vector<AdjustableWeight> adjustable_weights(const Parameters& scenario) {
  std::vector<AdjustableWeight> all;
  const double by = scenario.weights_adjustable_by;
  if (by <= 1.0) return all;
  each(scenario, [&](const std::string& name, double value) {
    if (value > 0.0) all.push_back({name, value, value / by, std::min(value * by, kLargestWeight)});
  });
  return all;
}

std::string refusal(const NamedWeights& wanted, const std::vector<AdjustableWeight>& allowed) {
  if (allowed.empty())
    return "expected a scenario with planner.weights.adjustable_by, got one that allows no other "
           "weights than its own";
  for (const auto& [name, value] : wanted) {
    const auto found = std::find_if(allowed.begin(), allowed.end(),
                                    [&, &of = name](const auto& one) { return one.name == of; });
    if (found == allowed.end())
      return "expected a weight such as " + like(name, allowed) + ", got \"" + name + "\"";
    if (!(value >= found->min && value <= found->max))
      return base::words("%s: expected a number in [%g, %g], got %g", name.c_str(), found->min,
                         found->max, value);
  }
  return "";
}

Parameters with_weights(const Parameters& parameters, const NamedWeights& wanted) {
  Parameters result = parameters;
  each(result, [&](const std::string& name, double& value) {
    const auto found = wanted.find(name);
    if (found != wanted.end()) value = found->second;
  });
  return result;
}

std::string describe(const NamedWeights& weights) {
  std::string text;
  for (const auto& [name, value] : weights)
    text += base::words("%s%s %g", text.empty() ? "" : ", ", name.c_str(), value);
  return text;
}

}  // namespace c3rt::planner
