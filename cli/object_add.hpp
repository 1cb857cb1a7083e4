#pragma once
// `c3rt object add`: from a mesh to an object that runs.
#include <string>

#include "cli/exit_status.hpp"

namespace c3rt::cli {

struct ObjectAddSettings {
  std::string file;       // .obj or .stl
  double mass = 0.0;      // [kg]
  std::string name;       // none: the file's
  double friction = 0.4;  // μ
  double scale = 1.0;     // from the file's unit to metres
  std::string out = ".";  // folder
  bool force = false;     // overwrites
};

/// Writes NAME.xml and one mesh file for each convex piece, and prints what a person should know.
/// @return an exit status @throws UsageError for a mesh that cannot be one, and for files that
/// are there already
int add_object(const ObjectAddSettings& settings);

}  // namespace c3rt::cli
