#pragma once
// An object as a person looks at it: what can be pushed on, what it stands on, where its tags are.
#include <filesystem>
#include <string>
#include <vector>

#include "cli/mesh/mesh.hpp"

namespace c3rt::cli {

struct ObjectPicture {
  std::string name;
  std::vector<mesh::Triangles> pieces;   // convex, in the file's frame [m]
  std::vector<Eigen::Vector3d> support;  // points on the table [m]
  std::vector<Eigen::Vector3d> tags;     // their middles [m]
  double tag_size = 0.0;                 // edge of the black square [m]
  Eigen::Vector3d com;                   // centre of mass [m]
};

/// Of this normal the end effector finds places beside a face, as the sampling strategy does: what
/// looks further up or down moves nothing.
bool can_be_pushed(const Eigen::Vector3d& normal);

/// From above and from below, a PNG. @return what is missing and why; empty if it is there
std::string draw_object(const std::filesystem::path& file, const ObjectPicture& picture);

}  // namespace c3rt::cli
