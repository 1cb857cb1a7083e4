#pragma once
// `extends: NAME`: a scenario that says only in what it differs from another one.
#include <string>
#include <vector>

#include "config/tree.hpp"

namespace c3rt::config {

/// Reads the file and those that it extends, one over the other. `extends` itself is gone then;
/// `name` and `description` are the file's own.
/// @throws ConfigError naming file and line: of what is not YAML, of a base that is not there, of a
/// circle, of more than 8 files; as apply_override
/// @param overrides "planner.admm.iterations=2": each replaces one value of the whole
Tree load_composed(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same of a text that has been read.
/// @param name for messages; paths in `extends` are seen from its folder
Tree compose(const std::string& text, const std::string& name,
             const std::vector<std::string>& overrides = {});

}  // namespace c3rt::config
