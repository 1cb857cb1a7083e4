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

/// The file that `extends` of a file means.
fs::path base_of(const Tree& extends, const fs::path& file) {
  const auto refuse = [&](const std::string& expected, const std::string& got) {
    throw ConfigError(extends.place.text() + ": extends: expected " + expected + ", got " + got);
  };
  if (!extends.is_scalar() || extends.scalar.empty())
    refuse("the name of a scenario or a path to a .yaml file", content(extends));
  const std::string& given = extends.scalar;
  if (is_path(given, kExtension)) {
    const fs::path base = (file.parent_path() / given).lexically_normal();
    std::error_code error;
    if (!fs::is_regular_file(base, error))
      refuse("a file", content(extends) + ": no file " + base.string());
    return base;
  }
  const fs::path folder = directory() / "scenarios";
  const fs::path base = folder / (given + kExtension);
  if (!is_name(given) || !fs::is_regular_file(base))
    refuse("the name of a scenario in " + folder.string() + ", or a path to a .yaml file",
           content(extends));
  return base;
}

/// @param chain the files from the one that was asked for to this one
Tree compose_chain(const std::string& text, const std::string& name, std::vector<fs::path> chain) {
  Tree own = read(text, name);
  const Tree* extends = own.find("extends");
  if (extends == nullptr) return own;
  const fs::path base = base_of(*extends, name);
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
  for (const std::string& override_text : overrides) apply_override(tree, name, override_text);
  return tree;
}

Tree load_composed(const std::string& path, const std::vector<std::string>& overrides) {
  return compose(read_file(path, "a scenario", kMaxBytes), path, overrides);
}

}  // namespace c3rt::config
