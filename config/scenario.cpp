#include "config/scenario.hpp"

#include "controller/impedance/load_parameters.hpp"
#include "controller/planner/load_parameters.hpp"
#include "plant_emulator/load_parameters.hpp"
#include "vision/load_parameters.hpp"

namespace c3rt::config {
namespace {

planner::CircleTask load_circle(Section& section) {
  planner::CircleTask circle{};
  circle.center = section.numbers("center_m", 2, {-1, 1});
  circle.radius = section.number("radius_m", {0.01, 0.5});
  circle.lead = section.number("lead_rad", {-3.14, 3.14});
  return circle;
}

planner::PathTask load_path(Section& section) {
  planner::PathTask path{};
  const Eigen::MatrixXd points = section.rows("points_m", 2, 1000, 2, {-1, 1});
  for (Eigen::Index i = 0; i < points.rows(); ++i) path.points.push_back(points.row(i).transpose());
  path.interval = section.number("interval_s", {0.01, 100});
  path.between = section.choice<planner::Between>(
      "between",
      {{"hold", planner::Between::kHold}, {"interpolate", planner::Between::kInterpolate}});
  path.lead = section.number("lead_s", {0, 10});
  path.preview = section.boolean("preview");
  return path;
}

planner::LineTask load_line(Section& section) {
  planner::LineTask line{};
  line.x = section.number("x_m", {-1, 1});
  line.step = section.number("step_m", {-0.2, 0.2});
  if (line.step == 0.0) section.fail("step_m", "a step that is not 0", "0");
  line.y_end = section.number("y_end_m", {-1, 1});
  line.spacing = section.number("spacing_m", {0, 0.5});
  return line;
}

/// Keys of another kind are left unread, which finish() refuses.
Task load_task(Section section) {
  Task task{};
  enum class Kind { kCircle, kPath, kLine };
  const Kind kind = section.choice<Kind>(
      "kind", {{"circle", Kind::kCircle}, {"path", Kind::kPath}, {"line", Kind::kLine}});
  switch (kind) {
    case Kind::kCircle:
      task.motion = load_circle(section);
      break;
    case Kind::kPath:
      task.motion = load_path(section);
      break;
    case Kind::kLine:
      task.motion = load_line(section);
      break;
  }
  task.loops = kind == Kind::kLine ? 1 : section.integer("loops", {1, 100000});
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
        {"longest_excursion_s", "longest_excursion_s"},
        {"largest_excursion_m", "largest_excursion_m"},
        {"ended_in_band", "ended_in_band"},
        {"path_error_rms_m", "path_error_rms_m"},
        {"path_error_p95_m", "path_error_p95_m"},
        {"path_error_max_m", "path_error_max_m"},
        {"balls_arrived", "balls_arrived"},
        {"arrival_error_max_m", "arrival_error_max_m"},
        {"end_error_max_m", "end_error_max_m"},
        {"tracking_error_p95_m", "tracking_error_p95_m"},
        {"tracking_error_max_m", "tracking_error_max_m"},
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
  Scenario scenario{};
  scenario.service = load_service(root);
  scenario.name = root.name("name");
  scenario.description = root.text("description");
  scenario.task = load_task(root.section("task"));
  scenario.criteria = load_criteria(root.list("criteria", 0, 16));
  Section timing = root.section("timing");
  scenario.timing.solve_time_s = timing.number("solve_time_s", {0, 1});
  scenario.timing.vision_latency_s = timing.number("vision_latency_s", {0, 1});
  scenario.plant = plant::load_parameters(root.section("plant"));
  scenario.impedance = impedance::load_from_scenario(root);
  scenario.planner = planner::load_parameters(root.section("planner"), scenario.task.motion,
                                              static_cast<int>(scenario.plant.world.balls.size()));
  scenario.vision = vision::load_parameters(root.section("vision"));
  root.finish();
  scenario.plant.recovers_alone = scenario.service.recovery == Recovery::kAutomatic;
  return scenario;
}

}  // namespace c3rt::config
