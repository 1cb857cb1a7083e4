#pragma once
// Where there is room for AprilTags on an object.
#include <vector>

#include "cli/mesh/mesh.hpp"

namespace c3rt::cli::mesh {

/// The white border around a tag's black square, as a part of its edge.
constexpr double kTagBorder = 0.125;

/// Middles of tags that lie flat on what looks up, with their borders, beside one another and under
/// no other piece. Of a row that does not fill its face what is left is the same on both sides.
/// @param pieces convex  @param size edge of the black square [m]
std::vector<Eigen::Vector3d> tag_places(const std::vector<Triangles>& pieces, double size);

}  // namespace c3rt::cli::mesh
