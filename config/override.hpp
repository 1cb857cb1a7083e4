#pragma once
#include <string>

#include "config/tree.hpp"

namespace c3rt::config {

/// "planner.admm.iterations=2" or "plant.objects.0.mass_kg=0.2": replaces one value that is there.
/// @param file whose tree it is, for messages
/// @throws ConfigError for what is no key=value, an unknown key, a value that is not YAML
void apply_override(Tree& root, const std::string& file, const std::string& text);

/// The value that such a path means, or none.
const Tree* value_at(const Tree& root, const std::string& path);

}  // namespace c3rt::config
