#pragma once
// The shapes of bodies, and how far a point is from their surfaces.
#include <vector>

#include <Eigen/Geometry>

namespace c3rt::scene {

/// The corners of a convex body, in its frame [m].
struct ConvexMesh {
  std::vector<Eigen::Vector3d> vertices;
};

enum class ShapeKind { kSphere, kBox, kCapsule, kCylinder, kConvexMesh };

/// A shape about the origin of its body's frame. Capsule and cylinder lie along z.
struct Shape {
  ShapeKind kind = ShapeKind::kSphere;
  double radius = 0.0;       // of sphere, capsule and cylinder [m]
  double half_length = 0.0;  // of capsule (its straight part) and cylinder [m]
  Eigen::Vector3d half_sizes = Eigen::Vector3d::Zero();  // of a box [m]
  const ConvexMesh* mesh = nullptr;                      // that outlives the shape

  static Shape sphere(double radius);
  static Shape box(const Eigen::Vector3d& half_sizes);
  static Shape capsule(double radius, double half_length);
  static Shape cylinder(double radius, double half_length);
  static Shape convex_mesh(const ConvexMesh& mesh);
};

/// Where a point is, seen from a surface.
struct Nearest {
  double distance;         // to the surface, negative inside [m]
  Eigen::Vector3d normal;  // of the surface there, outwards
};

/// Exact for every shape; of a point inside a convex mesh the distance is 0 and the normal away
/// from its middle.
/// @param p_B the point in the body's frame [m]
Nearest nearest(const Shape& shape, const Eigen::Vector3d& p_B) noexcept;

}  // namespace c3rt::scene
