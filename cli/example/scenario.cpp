#include "cli/example/scenario.hpp"

#include "controller/example/load_experiment.hpp"

namespace c3rt::cli {

bool is_example(const std::filesystem::path& file) {
  return config::Document::load(file.string()).has("example");
}

ExampleScenario load_example(const std::filesystem::path& file,
                             const std::vector<std::string>& overrides) {
  config::Section root = config::Document::load(file.string(), overrides);
  ExampleScenario scenario{};
  scenario.name = root.name("name");
  scenario.description = root.text("description");
  for (config::Section& section : root.list("criteria", 0, 16)) {
    Limit limit;
    limit.name = section.choice<const char*>("name", {{"success_rate", "success_rate"},
                                                      {"mean_cost_to_go", "mean_cost_to_go"},
                                                      {"accumulated_cost", "accumulated_cost"}});
    if (section.has("min")) limit.min = section.number("min", {-1e12, 1e12});
    if (section.has("max")) limit.max = section.number("max", {-1e12, 1e12});
    if (!limit.min && !limit.max) section.fail("name", "min, max or both beside it", "neither");
    scenario.criteria.push_back(limit);
  }
  scenario.experiment = example::load_experiment(root);
  root.finish();
  return scenario;
}

}  // namespace c3rt::cli
