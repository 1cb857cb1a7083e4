#pragma once
// The files beside a scenario's own text that a run depends on.
#include <string>

#include "config/tree.hpp"

namespace c3rt::cli::campaign {

/// A hash of every file that a value of the scenario names (MuJoCo models of objects) and of those
/// that these name in turn (meshes, included models). Files that are not there do not count.
std::string hash_of_files(const config::Tree& scenario);

}  // namespace c3rt::cli::campaign
