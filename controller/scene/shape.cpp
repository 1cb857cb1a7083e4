#include "controller/scene/shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace c3rt::scene {
namespace {

using Eigen::Vector3d;

Vector3d direction(const Vector3d& v, const Vector3d& where_zero) noexcept {
  const double length = v.norm();
  return length > 0.0 ? Vector3d(v / length) : where_zero;
}

Nearest nearest_of_sphere(double radius, const Vector3d& p) noexcept {
  return {p.norm() - radius, direction(p, Vector3d::UnitZ())};
}

Nearest nearest_of_box(const Vector3d& half, const Vector3d& p) noexcept {
  const Vector3d beyond = p.cwiseAbs() - half;
  if (beyond.maxCoeff() > 0.0) {
    const Vector3d on_surface = p.cwiseMax(-half).cwiseMin(half);
    return {(p - on_surface).norm(), (p - on_surface).normalized()};
  }
  Eigen::Index axis = 0;
  const double depth = beyond.maxCoeff(&axis);
  return {depth, (p[axis] < 0.0 ? -1.0 : 1.0) * Vector3d::Unit(axis)};
}

Nearest nearest_of_cylinder(double radius, double half_length, const Vector3d& p) noexcept {
  const double from_axis = p.head<2>().norm();
  const Vector3d outwards =
      from_axis > 0.0 ? Vector3d(p.x() / from_axis, p.y() / from_axis, 0.0) : Vector3d::UnitX();
  const Vector3d along = (p.z() < 0.0 ? -1.0 : 1.0) * Vector3d::UnitZ();
  const double side = from_axis - radius, end = std::abs(p.z()) - half_length;
  if (side > 0.0 && end > 0.0) {
    const Vector3d from_edge = side * outwards + end * along;
    return {from_edge.norm(), from_edge.normalized()};
  }
  return side > end ? Nearest{side, outwards} : Nearest{end, along};
}

/// The corners of a point, edge, triangle or tetrahedron.
struct Simplex {
  std::array<Vector3d, 4> corners;
  int size = 0;
  Simplex() { corners.fill(Vector3d::Zero()); }
};

/// The point of a simplex that is nearest to the origin, by trying every subset of its corners.
/// Those that are not needed for it are left out.
Vector3d reduce(Simplex& simplex) noexcept {
  double best = std::numeric_limits<double>::infinity();
  Vector3d point = simplex.corners[0];
  Simplex needed;
  for (unsigned subset = 1; subset < (1u << simplex.size); ++subset) {
    Simplex of;
    for (int i = 0; i < simplex.size; ++i) {
      if ((subset >> i & 1u) != 0)
        of.corners[static_cast<std::size_t>(of.size++)] =
            simplex.corners[static_cast<std::size_t>(i)];
    }
    Vector3d candidate = of.corners[0];
    if (of.size > 1) {
      // of its plane: 0 = Aᵀ (a_0 + A t), in the simplex where every weight is positive
      Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> A(3, of.size - 1);
      for (int i = 1; i < of.size; ++i)
        A.col(i - 1) = of.corners[static_cast<std::size_t>(i)] - of.corners[0];
      const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> t =
          A.colPivHouseholderQr().solve(-of.corners[0]);
      if (t.minCoeff() < 0.0 || t.sum() > 1.0) continue;
      candidate += A * t;
    }
    if (candidate.squaredNorm() < best) {
      best = candidate.squaredNorm();
      point = candidate;
      needed = of;
    }
  }
  simplex = needed;
  return point;
}

/// The distance of a point to the hull of the mesh's corners, by Gilbert, Johnson and Keerthi.
Nearest nearest_of_mesh(const ConvexMesh& mesh, const Vector3d& p) noexcept {
  constexpr int kMostSteps = 60;  // degenerate meshes would go round for ever
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& vertex : mesh.vertices)
    middle += vertex / static_cast<double>(mesh.vertices.size());
  Simplex simplex;
  simplex.corners[0] = mesh.vertices.front() - p;
  simplex.size = 1;
  Vector3d v = simplex.corners[0];
  bool inside = false;
  for (int step = 0; step < kMostSteps && !inside; ++step) {
    const Vector3d* support = &mesh.vertices.front();
    for (const Vector3d& vertex : mesh.vertices) {
      if (v.dot(vertex) < v.dot(*support)) support = &vertex;
    }
    const Vector3d towards = *support - p;
    // no corner is nearer along v: v is the nearest point
    if (v.squaredNorm() - v.dot(towards) <= 1e-14 * v.squaredNorm()) break;
    simplex.corners[static_cast<std::size_t>(simplex.size++)] = towards;
    const Vector3d next = reduce(simplex);
    inside = simplex.size == 4;
    const bool progress = next.squaredNorm() < v.squaredNorm();
    v = next;
    if (!progress) break;
  }
  const double distance = v.norm();
  if (inside || distance < 1e-12) return {0.0, direction(p - middle, Vector3d::UnitZ())};
  return {distance, -v / distance};
}

}  // namespace

Shape Shape::sphere(double radius) {
  Shape shape;
  shape.radius = radius;
  return shape;
}

Shape Shape::box(const Vector3d& half_sizes) {
  Shape shape;
  shape.kind = ShapeKind::kBox;
  shape.half_sizes = half_sizes;
  return shape;
}

Shape Shape::capsule(double radius, double half_length) {
  Shape shape;
  shape.kind = ShapeKind::kCapsule;
  shape.radius = radius;
  shape.half_length = half_length;
  return shape;
}

Shape Shape::cylinder(double radius, double half_length) {
  Shape shape = capsule(radius, half_length);
  shape.kind = ShapeKind::kCylinder;
  return shape;
}

Shape Shape::convex_mesh(const ConvexMesh& mesh) {
  Shape shape;
  shape.kind = ShapeKind::kConvexMesh;
  shape.mesh = &mesh;
  return shape;
}

Nearest nearest(const Shape& shape, const Vector3d& p_B) noexcept {
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return nearest_of_sphere(shape.radius, p_B);
    case ShapeKind::kBox:
      return nearest_of_box(shape.half_sizes, p_B);
    case ShapeKind::kCapsule: {
      const double on_axis = std::min(std::max(p_B.z(), -shape.half_length), shape.half_length);
      return nearest_of_sphere(shape.radius, p_B - on_axis * Vector3d::UnitZ());
    }
    case ShapeKind::kCylinder:
      return nearest_of_cylinder(shape.radius, shape.half_length, p_B);
    case ShapeKind::kConvexMesh:
      break;
  }
  return nearest_of_mesh(*shape.mesh, p_B);
}

}  // namespace c3rt::scene
