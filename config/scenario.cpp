#include "config/scenario.hpp"

#include "controller/impedance/load_parameters.hpp"
#include "controller/planner/load_parameters.hpp"
#include "plant_emulator/load_parameters.hpp"
#include "vision/load_parameters.hpp"

namespace c3rt::config {
namespace {

Task load_task(Section section) {
  Task task{};
  task.circle.center = section.numbers("center_m", 2, {-1, 1});
  task.circle.radius = section.number("radius_m", {0.01, 0.5});
  task.circle.lead = section.number("lead_rad", {-3.14, 3.14});
  task.loops = section.integer("loops", {1, 100000});
  task.duration_s = section.number("duration_s", {0.1, 1e6});
  return task;
}

std::vector<Criterion> load_criteria(std::vector<Section> sections) {
  std::vector<Criterion> criteria;
  for (Section& section : sections) {
    Criterion criterion;
    const std::initializer_list<std::pair<const char*, const char*>> names = {
        {"loops_completed", "loops_completed"},
        {"max_loop_time_s", "max_loop_time_s"},
        {"in_band_2cm", "in_band_2cm"},
        {"in_band_1cm", "in_band_1cm"},
        {"tracking_error_p95_m", "tracking_error_p95_m"},
        {"vision_error_p95_m", "vision_error_p95_m"}};
    criterion.name = section.choice<const char*>("name", names);
    if (section.has("min")) criterion.min = section.number("min", {-1e9, 1e9});
    if (section.has("max")) criterion.max = section.number("max", {-1e9, 1e9});
    if (!criterion.min && !criterion.max)
      section.fail("name", "min, max or both beside it", "neither");
    criteria.push_back(criterion);
  }
  return criteria;
}

}  // namespace

Scenario load_scenario(const std::string& path, const std::vector<std::string>& overrides) {
  return read_scenario(Document::load(path, overrides));
}

Scenario read_scenario(Section root) {
  if (root.has("example")) {
    root.fail("example", "no such key: a numerical example has none of the four processes",
              root.text("example") + " (c3rt run runs it)");
  }
  Scenario scenario{};
  scenario.name = root.text("name");
  scenario.description = root.text("description");
  scenario.task = load_task(root.section("task"));
  scenario.criteria = load_criteria(root.list("criteria", 0, 16));
  Section timing = root.section("timing");
  scenario.timing.solve_time_s = timing.number("solve_time_s", {0, 1});
  scenario.timing.vision_latency_s = timing.number("vision_latency_s", {0, 1});
  scenario.plant = plant::load_parameters(root.section("plant"));
  scenario.impedance = impedance::load_parameters(root.section("impedance"));
  scenario.planner = planner::load_parameters(root.section("planner"), scenario.task.circle);
  scenario.vision = vision::load_parameters(root.section("vision"));
  root.finish();
  return scenario;
}

}  // namespace c3rt::config
