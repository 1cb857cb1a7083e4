#include "controller/planner/strategy/registry.hpp"

#include <stdexcept>

#include "controller/planner/strategy/hold.hpp"
#include "controller/planner/strategy/sampling.hpp"
#include "controller/planner/strategy/time_heuristic.hpp"

namespace c3rt::planner {

const std::vector<StrategyKind>& strategy_kinds() {
  static const std::vector<StrategyKind> kinds{{"time_heuristic", make_time_heuristic},
                                               {"sampling", make_sampling, true},
                                               {"hold", make_hold}};
  return kinds;
}

const StrategyKind& strategy_kind(const std::string& name) {
  std::string known;
  for (const StrategyKind& kind : strategy_kinds()) {
    if (kind.name == name) return kind;
    known += (known.empty() ? "" : ", ") + kind.name;
  }
  throw std::invalid_argument("strategy: expected one of " + known + ", got \"" + name + "\"");
}

}  // namespace c3rt::planner
