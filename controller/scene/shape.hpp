#pragma once
// The shapes of bodies, and how far a point is from their surfaces.
#include <memory>
#include <vector>

#include <Eigen/Geometry>

namespace c3rt::scene {

/// The half-space that a face leaves: normal · p ≤ offset inside the body.
struct Plane {
  Eigen::Vector3d normal;  // outwards, of length 1
  double offset;           // [m]
};

/// The convex hull of points, in its body's frame [m].
class ConvexMesh {
 public:
  /// Faces by trying every three of the points: meant for hulls of a few hundred corners at most.
  /// @throws std::invalid_argument where the points lie in one plane, or are not finite
  explicit ConvexMesh(std::vector<Eigen::Vector3d> points);

  const std::vector<Eigen::Vector3d>& vertices() const noexcept { return vertices_; }
  const std::vector<Plane>& faces() const noexcept { return faces_; }

 private:
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Plane> faces_;
};

struct Union;

enum class ShapeKind { kSphere, kBox, kCapsule, kCylinder, kConvexMesh, kUnion };

/// A shape about the origin of its body's frame. Capsule and cylinder lie along z.
struct Shape {
  ShapeKind kind = ShapeKind::kSphere;
  double radius = 0.0;       // of sphere, capsule and cylinder [m]
  double half_length = 0.0;  // of capsule (its straight part) and cylinder [m]
  Eigen::Vector3d half_sizes = Eigen::Vector3d::Zero();  // of a box [m]
  const ConvexMesh* mesh = nullptr;                      // that outlives the shape
  const Union* parts = nullptr;                          // that outlive the shape

  static Shape sphere(double radius);
  static Shape box(const Eigen::Vector3d& half_sizes);
  static Shape capsule(double radius, double half_length);
  static Shape cylinder(double radius, double half_length);
  static Shape convex_mesh(const ConvexMesh& mesh);
  static Shape all_of(const Union& parts);
};

/// A convex shape somewhere in a body.
struct Part {
  Shape shape;
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();      // of its origin, in the body's frame [m]
  Eigen::Matrix3d R_BP = Eigen::Matrix3d::Identity();  // of its axes
};

/// Parts that make one body; they may touch and overlap.
struct Union {
  static constexpr int kMostParts = 32;
  std::vector<Part> parts;  // 1 to kMostParts, none of them a union
  std::vector<std::shared_ptr<const ConvexMesh>> meshes = {};  // of the parts
};

/// Where a point is, seen from a surface.
struct Nearest {
  double distance;         // to the surface, negative inside [m]
  Eigen::Vector3d normal;  // of the surface there, outwards
};

/// Exact for every shape, outside and inside; only of a point inside a union that it would leave
/// through a curved part the way out may be longer than the shortest.
/// @param p_B the point in the body's frame [m]
Nearest nearest(const Shape& shape, const Eigen::Vector3d& p_B) noexcept;

}  // namespace c3rt::scene
