#pragma once
#include <string>

#include "config/tree.hpp"

namespace c3rt::config {

/// "planner.admm.iterations=2" or "plant.objects.0.mass_kg=0.2": replaces one value that is there,
/// or gives a mapping a key that it leaves out; whether there is such a key the reader finds.
/// @param file whose tree it is, for messages
/// @throws ConfigError for what is no key=value, a path that leads nowhere, a value that is not
/// YAML
void apply_override(Tree& root, const std::string& file, const std::string& text);

/// The value that such a path means, or none.
const Tree* value_at(const Tree& root, const std::string& path);

}  // namespace c3rt::config
