#pragma once
// What a client may want instead of the scenario's task, and what of it can be reached.
#include <string>
#include <variant>

#include "controller/planner/parameters.hpp"
#include "controller/task/request.hpp"

namespace c3rt::planner {

/// The scenario's own task.
struct ScenarioTarget {
  static constexpr const char* kKind = "scenario";
};
/// The object that is worked on is brought to rest, then the end effector leaves it.
struct HoldTarget {
  static constexpr const char* kKind = "hold";
};

using Target = std::variant<ScenarioTarget, HoldTarget, task::Task>;

/// A client's target is drawn no farther from the object than this, or one that is far from a new
/// circle would be thrown at it [m].
constexpr double kTargetPace = 0.04;

/// Everything that may be asked for: "scenario", "hold" and every kind of task.
std::vector<std::string> target_kinds();

/// A client's target, by the loader of the scenario's tasks.
/// @throws task::RequestError naming what was expected and what came
Target load_target(const task::Request& request);

/// What the targets of a scenario have to keep.
task::Limits target_limits(const Parameters& parameters);

/// Why a target cannot be reached or done: what was expected and what came; empty where it can.
std::string refusal(const Target& target, const task::Limits& limits);

/// "circle about (0.55, 0) m, radius 0.1 m, lead 20 deg"
std::string describe(const Target& target);

}  // namespace c3rt::planner
