#include "config/override.hpp"

#include <sstream>

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

}  // namespace

void apply_override(Tree& root, const std::string& file, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError("--set " + text +
                      ": expected key=value, for example --set planner.rate_hz=75");
  const std::string path = text.substr(0, equals);
  Tree* value = at_path(root, path);
  if (value == nullptr) throw ConfigError("--set " + path + ": no such key in " + file);
  *value = parse_override(text, text.substr(equals + 1), file);
}

const Tree* value_at(const Tree& root, const std::string& path) { return at_path(root, path); }

}  // namespace c3rt::config
