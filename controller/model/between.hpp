#pragma once
// Which contacts a model has, by name.
#include <optional>
#include <string>

namespace c3rt::model {

/// The contacts of two bodies or geoms.
struct Between {
  // a geom, a body with all that is fixed to it, or "world"
  std::string first, second;
  // so many of their contacts, those that are nearest at the time; 0: all of them, always
  int closest = 0;
  // μ; none: that of the rougher surface, as MuJoCo has it
  std::optional<double> friction = {};
};

}  // namespace c3rt::model
