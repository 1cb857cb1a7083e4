#include "config/override.hpp"

#include <memory>
#include <sstream>
#include <utility>

#include "config/config_error.hpp"

namespace c3rt::config {
namespace {

/// The value below `tree` that a part of an override's path means, or none.
template <typename AnyTree>
AnyTree* below(AnyTree& tree, const std::string& part) {
  if (tree.is_map()) return tree.find(part);
  const bool index = tree.is_list() && !part.empty() && part.size() < 6 &&
                     part.find_first_not_of("0123456789") == std::string::npos;
  return index && std::stoul(part) < tree.list.size() ? &tree.list[std::stoul(part)] : nullptr;
}

template <typename AnyTree>
AnyTree* at_path(AnyTree& root, const std::string& path) {
  AnyTree* at = &root;
  std::istringstream parts(path);
  for (std::string part; at != nullptr && std::getline(parts, part, '.');) at = below(*at, part);
  const bool is_value = at != nullptr && at != &root && !at->is_nothing() && path.back() != '.';
  return is_value ? at : nullptr;
}

/// Where a key that the mapping above it does not have yet gets its value, or none.
Tree* add_key(Tree& root, const std::string& path, const std::string& file) {
  const std::size_t dot = path.rfind('.');
  const std::string key = path.substr(dot + 1);
  Tree* mapping = dot == std::string::npos ? &root : at_path(root, path.substr(0, dot));
  // what a file extends is read before
  if (mapping == nullptr || !mapping->is_map() || key.empty() || path == "extends") return nullptr;
  if (mapping->find(key) != nullptr) return nullptr;
  Entry entry;
  entry.key = key;
  entry.place.file = std::make_shared<const std::string>(file);
  mapping->map.push_back(std::move(entry));
  return &mapping->map.back().value;
}

}  // namespace

void apply_override(Tree& root, const std::string& file, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError("--set " + text +
                      ": expected key=value, for example --set planner.rate_hz=75");
  const std::string path = text.substr(0, equals);
  Tree* value = at_path(root, path);
  if (value == nullptr) value = add_key(root, path, file);
  if (value == nullptr) throw ConfigError("--set " + path + ": no such key in " + file);
  *value = parse_override(text, text.substr(equals + 1), file);
}

const Tree* value_at(const Tree& root, const std::string& path) { return at_path(root, path); }

}  // namespace c3rt::config
