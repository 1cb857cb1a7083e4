#pragma once
// A rigid object from its MuJoCo model (MJCF), compiled by MuJoCo itself.
#include <string>
#include <vector>

#include "controller/mjcf/error.hpp"
#include "controller/scene/object.hpp"

namespace c3rt::mjcf {

struct ObjectFile {
  scene::Object object;
  Eigen::Vector3d p_body_com;      // the centre of mass in the frame of the file's body [m]
  std::vector<std::string> notes;  // what a person should know: what is left out, what was assumed
};

/// The one free body of a file with all that is fixed to it. Spheres, boxes, capsules, cylinders
/// and the convex hulls of meshes make its surface; geoms that collide with nothing (contype and
/// conaffinity 0) do not, and what else is in the file's world is left out with a note. Its sites
/// tag36h11_ID are tags: boxes whose first two sizes are half of the black square's edge.
/// @throws Error where MuJoCo refuses the file, where there is not one free body, and for what
/// would move it in ways that nobody here knows of: other joints, tendons, equalities, actuators,
/// friction, damping or springs of the joint, height fields, planes and ellipsoids; for a tag that
/// is of no known kind, or no square
ObjectFile read_object(const std::string& file);

}  // namespace c3rt::mjcf
