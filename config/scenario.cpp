#include "config/scenario.hpp"

#include "config/robot.hpp"
#include "controller/impedance/load_parameters.hpp"
#include "controller/planner/load_parameters.hpp"
#include "controller/task/registry.hpp"
#include "plant_emulator/load_parameters.hpp"
#include "vision/load_parameters.hpp"

namespace c3rt::config {
namespace {

/// A task's parameters from its section. Keys of another kind are left unread, which finish()
/// refuses.
class TaskSection final : public task::Source {
 public:
  explicit TaskSection(Section& section) : section_(section) {}
  double number(const std::string& key, double min, double max) override {
    return section_.number(key, {min, max});
  }
  bool boolean(const std::string& key) override { return section_.boolean(key); }
  Eigen::VectorXd numbers(const std::string& key, int size, double min, double max) override {
    return section_.numbers(key, size, {min, max});
  }
  Eigen::MatrixXd rows(const std::string& key, int min_rows, int max_rows, int columns, double min,
                       double max) override {
    return section_.rows(key, min_rows, max_rows, columns, {min, max});
  }
  int choice(const std::string& key, const std::vector<std::string>& names) override {
    return section_.choice(key, names);
  }
  [[noreturn]] void fail(const std::string& key, const std::string& expected,
                         const std::string& got) override {
    section_.fail(key, expected, got);
  }

 private:
  Section& section_;
};

Task load_task(Section section) {
  TaskSection source(section);
  Task task{task::load(source), 1, 0.0};
  if (task.motion.repeats()) task.loops = section.integer("loops", {1, 100000});
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
  scenario.plant = plant::load_parameters(root.section("plant"), load_robot(root));
  scenario.impedance = impedance::load_from_scenario(root);
  scenario.planner = planner::load_parameters(root.section("planner"), scenario.task.motion,
                                              static_cast<int>(scenario.plant.world.balls.size()));
  scenario.vision = vision::load_parameters(root.section("vision"));
  root.finish();
  scenario.plant.recovers_alone = scenario.service.recovery == Recovery::kAutomatic;
  return scenario;
}

}  // namespace c3rt::config
