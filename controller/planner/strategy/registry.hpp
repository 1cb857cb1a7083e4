#pragma once
// The strategies by name: a new one is a file of its own and one line in registry.cpp.
#include <memory>
#include <string>
#include <vector>

#include "controller/planner/strategy/strategy.hpp"

namespace c3rt::planner {

struct StrategyKind {
  std::string name;
  std::unique_ptr<Strategy> (*make)(const Parameters& parameters, C3Controller& c3);
  bool goals_of_several = false;  // works at a task with goals where there are several bodies
};

const std::vector<StrategyKind>& strategy_kinds();

/// @throws std::invalid_argument naming the kinds that there are
const StrategyKind& strategy_kind(const std::string& name);

}  // namespace c3rt::planner
