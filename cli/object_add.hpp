#pragma once
// `c3rt object add`: from a mesh to an object that runs.
#include <string>

#include "cli/exit_status.hpp"

namespace c3rt::cli {

constexpr int kLastTag = 586;  // id of tag36h11

struct ObjectAddSettings {
  std::string file;         // .obj or .stl
  double mass = 0.0;        // [kg]
  std::string name;         // none: the file's
  double friction = 0.4;    // μ
  double scale = 1.0;       // from the file's unit to metres
  std::string out = ".";    // folder
  bool decompose = false;   // parts that are hollow become convex pieces by CoACD
  int first_tag = -1;       // id of the first AprilTag on its top; negative: none
  double tag_size = 0.032;  // edge of a tag's black square [m]
  bool picture = true;      // NAME.png
  bool force = false;       // overwrites
};

/// Writes NAME.xml, one mesh file for each convex piece and a picture, and prints what a person
/// should know.
/// @return an exit status @throws UsageError for a mesh that cannot be one, and for files that
/// are there already
int add_object(const ObjectAddSettings& settings);

}  // namespace c3rt::cli
