#pragma once
// Triangle meshes from files: their mass properties and convex hulls.
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace c3rt::cli::mesh {

/// The message names file and line (of STL: or triangle), what was expected and what came.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Triangles {
  std::vector<Eigen::Vector3d> points;     // [m]
  std::vector<Eigen::Vector3i> triangles;  // counter-clockwise seen from outside
};

constexpr std::size_t kMostTriangles = 1'000'000;

/// A text of Wavefront's OBJ (v, and f of three or more corners with or without slashes; the rest
/// is left out) or of STL (binary, ASCII), as the ending of `file` says. Points at one place are
/// one, but for those of another object or group (o, g; solid). @throws Error
Triangles parse(const std::string& text, const std::string& file);

struct Solid {
  double volume = 0.0;                                // [m³]
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      // centre of mass [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about it, of mass 1 [m²]
};

/// Of even density, by the tetrahedra from one point to each triangle.
/// @throws Error where the triangles enclose no volume
Solid solid_of(const Triangles& mesh);

/// Edges that do not have exactly one triangle on either side: none, if the surface is closed.
std::size_t open_edges(const Triangles& mesh);

/// Points at one place are one, whatever they belong to.
Triangles welded(const Triangles& mesh);

/// Turns a closed surface inside out where its volume is negative. @return whether it did
bool turn_outwards(Triangles& mesh);

/// What hangs together, in the order of the first triangles.
std::vector<Triangles> components(const Triangles& mesh);

/// The convex hull of the points, or where these are many one that lies inside it: of at most
/// `most` corners, the outermost along directions that are spread evenly. @throws Error
Triangles hull_of(const Triangles& mesh, std::size_t most);

/// As text of Wavefront's OBJ.
std::string to_obj(const Triangles& mesh);

}  // namespace c3rt::cli::mesh
