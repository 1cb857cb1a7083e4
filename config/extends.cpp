#include "config/extends.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "config/config_error.hpp"
#include "config/directory.hpp"
#include "config/override.hpp"
#include "config/read_file.hpp"

namespace c3rt::config {
namespace fs = std::filesystem;
namespace {

// the largest of the shipped scenarios has 7 kB, one with a path of 1000 points 25 kB
constexpr std::size_t kMaxBytes = 256 * 1024;
constexpr std::size_t kMaxFiles = 8;
constexpr const char* kExtension = ".yaml";

void take_out(Tree& tree, const std::string& key) {
  tree.map.erase(std::remove_if(tree.map.begin(), tree.map.end(),
                                [&](const Entry& entry) { return entry.key == key; }),
                 tree.map.end());
}

Tree read(const std::string& text, const std::string& name) {
  Tree tree = parse_yaml(text, name);
  if (!tree.is_map())
    throw ConfigError(name + ": expected a mapping of sections at the top, got " + content(tree));
  return tree;
}

/// The file that a name (of what is shipped in `folder`) or a path means.
fs::path file_of(const Tree& named, const std::string& key, const std::string& what,
                 const std::string& folder) {
  const auto refuse = [&](const std::string& expected, const std::string& got) {
    throw ConfigError(named.place.text() + ": " + key + ": expected " + expected + ", got " + got);
  };
  if (!named.is_scalar() || named.scalar.empty())
    refuse("the name of a " + what + " or a path to a .yaml file", content(named));
  const std::string& given = named.scalar;
  if (is_path(given, kExtension)) {
    fs::path file = (fs::path(*named.place.file).parent_path() / given).lexically_normal();
    std::error_code error;
    if (!fs::is_regular_file(file, error))
      refuse("a file", content(named) + ": no file " + file.string());
    return file;
  }
  const fs::path shipped = directory() / folder;
  fs::path file = shipped / (given + kExtension);
  if (!is_name(given) || !fs::is_regular_file(file))
    refuse("the name of a " + what + " in " + shipped.string() + ", or a path to a .yaml file",
           content(named));
  return file;
}

/// Adds what is not there.
void fill(Tree& tree, const Tree& defaults) {
  for (const Entry& entry : defaults.map) {
    Tree* there = tree.find(entry.key);
    if (there == nullptr) {
      tree.map.push_back(entry);
    } else if (there->is_map() && entry.value.is_map()) {
      fill(*there, entry.value);
    }
  }
}

/// Puts the description of the robot in the place of its name, and what it says of a scenario below
/// what the scenario says itself.
void add_robot(Tree& tree) {
  Tree* robot = tree.find("robot");
  if (robot == nullptr || robot->is_map()) return;
  const std::string file = file_of(*robot, "robot", "robot", "robots").string();
  Tree described = read(read_file(file, "a robot", kMaxBytes), file);
  Tree scenario;
  if (const Tree* defaults = described.find("scenario")) scenario = *defaults;
  take_out(described, "scenario");
  *robot = std::move(described);
  fill(tree, scenario);
}

/// @param chain the files from the one that was asked for to this one
Tree compose_chain(const std::string& text, const std::string& name, std::vector<fs::path> chain) {
  Tree own = read(text, name);
  const Tree* extends = own.find("extends");
  if (extends == nullptr) return own;
  const fs::path base = file_of(*extends, "extends", "scenario", "scenarios");
  const Place place = extends->place;
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(base, error);
  chain.push_back(fs::weakly_canonical(name, error));
  if (std::find(chain.begin(), chain.end(), canonical) != chain.end()) {
    std::string circle;
    for (const fs::path& file : chain) circle += file.filename().string() + " -> ";
    throw ConfigError(place.text() + ": extends: expected no circle, got " + circle +
                      canonical.filename().string());
  }
  if (chain.size() == kMaxFiles)
    throw ConfigError(place.text() + ": extends: expected at most " + std::to_string(kMaxFiles) +
                      " files that extend one another, got more");
  Tree below =
      compose_chain(read_file(base.string(), "a scenario", kMaxBytes), base.string(), chain);
  for (const char* key : {"name", "description"}) take_out(below, key);
  take_out(own, "extends");
  Tree whole = merge(std::move(below), std::move(own));
  std::stable_partition(whole.map.begin(), whole.map.end(), [](const Entry& entry) {
    return entry.key == "name" || entry.key == "description";
  });
  return whole;
}

}  // namespace

Tree compose(const std::string& text, const std::string& name,
             const std::vector<std::string>& overrides) {
  Tree tree = compose_chain(text, name, std::vector<fs::path>());
  const auto names_robot = [](const std::string& one) { return one.rfind("robot=", 0) == 0; };
  for (const std::string& override_text : overrides)
    if (names_robot(override_text)) apply_override(tree, name, override_text);
  add_robot(tree);
  for (const std::string& override_text : overrides)
    if (!names_robot(override_text)) apply_override(tree, name, override_text);
  return tree;
}

Tree load_composed(const std::string& path, const std::vector<std::string>& overrides) {
  return compose(read_file(path, "a scenario", kMaxBytes), path, overrides);
}

}  // namespace c3rt::config
