#include "cli/scenario.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/example/scenario.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "config/directory.hpp"
#include "config/extends.hpp"
#include "config/keys.hpp"
#include "config/scenario.hpp"
#include "config/show.hpp"

namespace c3rt::cli {
namespace fs = std::filesystem;
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kLongestName = 1000;

ordered_json json_of(const config::Tree& tree) {
  if (tree.is_scalar()) return tree.scalar;
  ordered_json json = tree.is_map()    ? ordered_json::object()
                      : tree.is_list() ? ordered_json::array()
                                       : ordered_json();
  for (const config::Tree& item : tree.list) json.push_back(json_of(item));
  for (const config::Entry& entry : tree.map) json[entry.key] = json_of(entry.value);
  return json;
}

/// Those that values name: looked for as a scenario's section does.
void add_files(const config::Tree& tree, std::vector<std::string>& files) {
  for (const config::Tree& item : tree.list) add_files(item, files);
  for (const config::Entry& entry : tree.map) add_files(entry.value, files);
  if (!tree.is_scalar() || tree.scalar.empty() || tree.scalar.size() > kLongestName) return;
  const fs::path own = tree.place.file ? fs::path(*tree.place.file).parent_path() : fs::path();
  for (const fs::path& folder : {own, config::directory() / "scenarios"}) {
    std::error_code error;
    if (!fs::is_regular_file(folder / tree.scalar, error)) continue;
    files.push_back(fs::absolute(folder / tree.scalar).string());
    return;
  }
}

void check(const fs::path& file, const std::vector<std::string>& overrides) {
  if (is_example(file)) {
    (void)load_example(file, overrides);
  } else {
    (void)config::load_scenario(file.string(), overrides);
  }
}

using Keys = std::map<std::string, config::Key>;

/// The phases of a strategy have weights of the same kinds.
std::string without_phase(const std::string& path) {
  static constexpr const char* kWeights = "planner.weights.";
  if (path.rfind(kWeights, 0) != 0) return path;
  const std::size_t begin = std::char_traits<char>::length(kWeights);
  const std::size_t end = path.find('.', begin);
  return path.substr(0, begin) + "PHASE" + (end == std::string::npos ? "" : path.substr(end));
}

void add(const Keys& heard, Keys& all) {
  for (const auto& [path, key] : heard) {
    config::Key& known = all[without_phase(path)];
    known.optional = known.optional || key.optional;
    if (known.missing.empty()) known.missing = key.missing;
    for (const std::string& expected : key.expected) {
      if (std::find(known.expected.begin(), known.expected.end(), expected) == known.expected.end())
        known.expected.push_back(expected);
    }
  }
}

void print(const Keys& keys, const std::string& heading) {
  std::map<std::string, Keys> sections;
  for (const auto& [path, key] : keys) {
    if (key.expected.empty()) continue;  // a section: its keys say more
    const std::size_t dot = path.find('.');
    sections[dot == std::string::npos ? "" : path.substr(0, dot)].emplace(path, key);
  }
  for (const auto& [section, rows] : sections) {
    fmt::print("\n## {}{}\n\n| key | expected | left out |\n| --- | --- | --- |\n", heading,
               section.empty() ? "" : ": " + section);
    for (const auto& [path, key] : rows) {
      const std::string left_out = !key.missing.empty() ? key.missing
                                   : key.optional       ? "may be"
                                                        : "";
      fmt::print("| `{}` | {} | {} |\n", path, fmt::join(key.expected, "; or "), left_out);
    }
  }
}

}  // namespace

int print_keys(const std::string& scenario, const std::vector<std::string>& overrides) {
  Keys of_runs, of_examples;
  const std::vector<std::string> names =
      scenario.empty() ? scenario_names() : std::vector<std::string>{scenario};
  for (const std::string& name : names) {
    const fs::path file = scenario_path(name);
    const config::KeyListener listener;
    check(file, overrides);
    add(listener.keys(), is_example(file) ? of_examples : of_runs);
  }
  print(of_runs, "Runs");
  print(of_examples, "Examples");
  return kDone;
}

int print_scenario(const std::string& scenario, const std::vector<std::string>& overrides) {
  const fs::path file = scenario_path(scenario);
  check(file, overrides);
  fmt::print("{}", config::show(config::load_composed(file.string(), overrides),
                                config::Comments::kPlaces));
  return kDone;
}

int print_scenario_json(const std::string& scenario, const std::vector<std::string>& overrides) {
  const fs::path file = scenario_path(scenario);
  check(file, overrides);
  const config::Tree tree = config::load_composed(file.string(), overrides);
  std::vector<std::string> files;
  add_files(tree, files);
  const ordered_json json{{"file", file.string()},
                          {"is_example", is_example(file)},
                          {"own_text", config::whole_scenario(file.string())},
                          {"text", config::show(tree, config::Comments::kNone)},
                          {"values", json_of(tree)},
                          {"files", files}};
  fmt::print("{}\n", json.dump());
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
