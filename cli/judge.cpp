#include "cli/judge.hpp"

#include <vector>

#include "plant_emulator/pushes.hpp"

namespace c3rt::cli {

Figures judge(const Series& series, const config::Scenario& scenario, const task::Task& task,
              std::uint64_t seed) {
  std::vector<Limit> limits;
  for (const config::Criterion& c : scenario.criteria) limits.push_back({c.name, c.min, c.max});
  const auto objects = static_cast<int>(scenario.plant.world.objects.size());
  return evaluate(series, task, limits, plant::drawn_pushes(scenario.plant.pushes, objects, seed));
}

}  // namespace c3rt::cli
