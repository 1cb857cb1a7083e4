#include "config/scenario.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "config/robot.hpp"
#include "config/text.hpp"
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
  bool has(const std::string& key) override { return section_.has(key); }
  double number(const std::string& key, double min, double max) override {
    return section_.number(key, {min, max});
  }
  bool boolean(const std::string& key) override { return section_.boolean(key); }
  Eigen::VectorXd numbers(const std::string& key, int size, double min, double max) override {
    return section_.numbers(key, size, {min, max});
  }
  Eigen::VectorXd one_or_each(const std::string& key, int size, double min, double max) override {
    return section_.one_or_each(key, size, {min, max});
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

Task load_task(Section& section) {
  TaskSection source(section);
  Task task{task::load(source), 1, 0.0};
  if (task.motion.repeats()) task.loops = section.integer("loops", {1, 100000});
  task.duration_s = section.number("duration_s", {0.1, 1e6});
  return task;
}

// A planner that believes the table elsewhere presses on it, or works above it [m].
constexpr double kTablesApart = 0.005;

/// What any run can be judged by, whatever its task.
const char* const kCriteria[] = {
    "in_band_2cm",          "in_band_1cm",          "longest_excursion_s", "largest_excursion_m",
    "ended_in_band",        "path_error_rms_m",     "path_error_p95_m",    "path_error_max_m",
    "tracking_error_p95_m", "tracking_error_max_m", "vision_error_p95_m"};

std::vector<Criterion> load_criteria(std::vector<Section> sections, const task::Task& task) {
  std::vector<std::string> names = task.criteria();
  names.insert(names.end(), std::begin(kCriteria), std::end(kCriteria));
  std::vector<Criterion> criteria;
  for (Section& section : sections) {
    Criterion criterion;
    criterion.name = names[static_cast<std::size_t>(section.choice("name", names))];
    if (section.has("min")) criterion.min = section.number("min", {-1e9, 1e9});
    if (section.has("max")) criterion.max = section.number("max", {-1e9, 1e9});
    if (!criterion.min && !criterion.max)
      section.fail("name", "min, max or both beside it", "neither");
    criteria.push_back(criterion);
  }
  return criteria;
}

/// Cameras know spheres by their outline and other objects by their tags.
void check_tags(const Scenario& scenario, const Section& vision) {
  std::map<int, std::string> owners;
  for (const plant::ObjectParameters& object : scenario.plant.world.objects) {
    if (plant::is_sphere(object)) continue;
    const std::string name = "\"" + object.object.name + "\"";
    if (object.object.tags.empty()) {
      vision.fail("source",
                  "emulated, or sites tag36h11_ID in the MuJoCo model of " + name +
                      ", as cameras know what is no sphere by its tags",
                  "cameras");
    }
    if (!scenario.vision.tags)
      vision.fail("tags", "the section, as cameras know " + name + " by its tags", "none");
    for (const scene::Tag& tag : object.object.tags) {
      const auto [other, fresh] = owners.insert({tag.id, name});
      if (!fresh) {
        vision.fail("source", "emulated, or objects whose tags differ",
                    "tag " + std::to_string(tag.id) + " on " + other->second + " and on " + name);
      }
    }
  }
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
  Section task = root.section("task");
  scenario.task = load_task(task);
  scenario.criteria = load_criteria(root.list("criteria", 0, 16), scenario.task.motion);
  Section timing = root.section("timing");
  scenario.timing.solve_time_s = timing.number("solve_time_s", {0, 1});
  scenario.timing.vision_latency_s = timing.number("vision_latency_s", {0, 1});
  scenario.plant = plant::load_parameters(root.section("plant"), load_robot(root));
  scenario.impedance = impedance::load_from_scenario(root);
  Section planner = root.section("planner");
  scenario.planner = planner::load_parameters(
      planner, scenario.task.motion, static_cast<int>(scenario.plant.world.objects.size()));
  const double table = scenario.plant.world.table_height;
  if (std::abs(scenario.planner.geometry.table_height - table) > kTablesApart) {
    planner.fail(
        "model",
        "a table_height_m within 0.005 of plant.table_height_m, which is " + text_of(table),
        text_of(scenario.planner.geometry.table_height));
  }
  Section vision = root.section("vision");
  scenario.vision = vision::load_parameters(vision);
  if (scenario.task.motion.bodies() > scenario.planner.model.bodies) {
    task.fail("object", "one of the scenario's " + std::to_string(scenario.planner.model.bodies),
              "object " + std::to_string(scenario.task.motion.bodies() - 1));
  }
  const std::vector<plant::ObjectParameters>& objects = scenario.plant.world.objects;
  const auto other =
      std::find_if(objects.begin(), objects.end(),
                   [](const plant::ObjectParameters& object) { return !plant::is_sphere(object); });
  if (scenario.vision.source == vision::SourceKind::kCameras) check_tags(scenario, vision);
  if (scenario.vision.acceleration_filter && (other != objects.end() || objects.size() != 1)) {
    vision.fail("acceleration_filter", "one sphere, as others would touch it",
                other != objects.end() ? "\"" + other->object.name + "\", which is none"
                                       : std::to_string(objects.size()) + " objects");
  }
  root.finish();
  scenario.plant.recovers_alone = scenario.service.recovery == Recovery::kAutomatic;
  return scenario;
}

}  // namespace c3rt::config
