#include "cli/scenario.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/example/scenario.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "config/extends.hpp"
#include "config/scenario.hpp"
#include "config/show.hpp"

namespace c3rt::cli {

int print_scenario(const std::string& scenario, const std::vector<std::string>& overrides) {
  const std::filesystem::path file = scenario_path(scenario);
  if (is_example(file)) {
    (void)load_example(file, overrides);
  } else {
    (void)config::load_scenario(file.string(), overrides);
  }
  fmt::print("{}", config::show(config::load_composed(file.string(), overrides),
                                config::Comments::kPlaces));
  return kDone;
}

int list_scenarios() {
  const std::vector<std::string> names = scenario_names();
  std::size_t width = 0;
  for (const std::string& name : names) width = std::max(width, name.size());
  for (const std::string& name : names) {
    config::Section root = config::Document::load(scenario_path(name).string());
    fmt::print("{:<{}}  {}\n", name, width, root.text("description"));
  }
  return kDone;
}

}  // namespace c3rt::cli
