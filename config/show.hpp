#pragma once
#include <string>

#include "config/tree.hpp"

namespace c3rt::config {

enum class Comments { kNone, kPlaces };

/// A tree as YAML that gives the same tree when it is read. With kPlaces a comment on each line
/// says where the value was written: "# circle_slow.yaml:12", "# --set".
std::string show(const Tree& tree, Comments comments);

/// The scenario of a file with what it extends, as one text that needs no other file.
/// @throws ConfigError
std::string whole_scenario(const std::string& path);

}  // namespace c3rt::config
