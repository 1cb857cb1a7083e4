#include "config/override.hpp"

#include <sstream>

#include "config/config_error.hpp"

namespace c3rt::config {
namespace {

/// The value below `tree` that a part of an override's path means, or none.
Tree* below(Tree& tree, const std::string& part) {
  if (tree.is_map()) return tree.find(part);
  const bool index = tree.is_list() && !part.empty() && part.size() < 6 &&
                     part.find_first_not_of("0123456789") == std::string::npos;
  return index && std::stoul(part) < tree.list.size() ? &tree.list[std::stoul(part)] : nullptr;
}

}  // namespace

void apply_override(Tree& root, const std::string& file, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError("--set " + text +
                      ": expected key=value, for example --set planner.rate_hz=75");
  const std::string path = text.substr(0, equals);
  Tree* at = &root;
  std::istringstream parts(path);
  for (std::string part; at != nullptr && std::getline(parts, part, '.');) at = below(*at, part);
  if (at == nullptr || at == &root || at->is_nothing() || path.back() == '.')
    throw ConfigError("--set " + path + ": no such key in " + file);
  *at = parse_override(text, text.substr(equals + 1), file);
}

}  // namespace c3rt::config
