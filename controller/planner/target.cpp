#include "controller/planner/target.hpp"

#include <algorithm>

#include "controller/planner/strategy/registry.hpp"
#include "controller/task/registry.hpp"

namespace c3rt::planner {
namespace {

constexpr double kMargin = 0.02;  // of the way inside the reach [m]

}  // namespace

std::vector<std::string> target_kinds() {
  std::vector<std::string> kinds{ScenarioTarget::kKind, HoldTarget::kKind};
  for (const std::string& kind : task::kinds()) kinds.push_back(kind);
  return kinds;
}

Target load_target(const task::Request& request) {
  const std::vector<std::string> tasks = task::kinds();
  if (std::find(tasks.begin(), tasks.end(), request.kind) != tasks.end())
    return task::load(request);
  task::RequestSource source(request);
  const std::vector<std::string> kinds = target_kinds();
  const std::string kind = kinds[static_cast<std::size_t>(source.choice("kind", kinds))];
  source.finish();
  return kind == HoldTarget::kKind ? Target(HoldTarget{}) : Target(ScenarioTarget{});
}

task::Limits target_limits(const Parameters& parameters) {
  const ApproachParameters& reach = parameters.approach;
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kMargin);
  return {parameters.model.bodies,
          {reach.reach_min + margin, reach.reach_max - margin},
          strategy_kind(parameters.strategy).goals_of_several};
}

std::string refusal(const Target& target, const task::Limits& limits) {
  const auto* task = std::get_if<task::Task>(&target);
  return task == nullptr ? "" : task->refusal(limits);
}

std::string describe(const Target& target) {
  if (const auto* task = std::get_if<task::Task>(&target)) return task->describe();
  return std::holds_alternative<HoldTarget>(target) ? "hold" : "the scenario's own task";
}

}  // namespace c3rt::planner
