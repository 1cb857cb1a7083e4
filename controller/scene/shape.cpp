#include "controller/scene/shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "controller/scene/simplex.hpp"

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

/// The face of a hull that a point inside it is nearest to.
Nearest nearest_face(const ConvexMesh& mesh, const Vector3d& p) noexcept {
  Nearest deepest{-std::numeric_limits<double>::infinity(), Vector3d::UnitZ()};
  for (const Plane& face : mesh.faces()) {
    const double beyond = face.normal.dot(p) - face.offset;
    if (beyond > deepest.distance) deepest = {beyond, face.normal};
  }
  return deepest;
}

/// The distance of a point to a hull, outside by Gilbert, Johnson and Keerthi.
Nearest nearest_of_mesh(const ConvexMesh& mesh, const Vector3d& p) noexcept {
  constexpr int kMostSteps = 60;  // degenerate meshes would go round for ever
  Nearest face = nearest_face(mesh, p);
  if (face.distance <= 0.0) return face;
  Simplex simplex;
  simplex.corners[0] = mesh.vertices().front() - p;
  simplex.size = 1;
  Vector3d v = simplex.corners[0];
  for (int step = 0; step < kMostSteps; ++step) {
    const Vector3d* support = &mesh.vertices().front();
    for (const Vector3d& vertex : mesh.vertices()) {
      if (v.dot(vertex) < v.dot(*support)) support = &vertex;
    }
    const Vector3d towards = *support - p;
    // no corner is nearer along v: v is the nearest point
    if (v.squaredNorm() - v.dot(towards) <= 1e-14 * v.squaredNorm()) break;
    simplex.corners[static_cast<std::size_t>(simplex.size++)] = towards;
    const Vector3d next = reduce(simplex);
    if (simplex.size == 4) return face;  // inside by rounding
    const bool progress = next.squaredNorm() < v.squaredNorm();
    v = next;
    if (!progress) break;
  }
  const double distance = v.norm();
  // so near that rounding decides
  if (distance < 1e-9) return face;
  return {distance, -v / distance};
}

Nearest nearest_of_part(const Part& part, const Vector3d& p) noexcept {
  const Nearest found = nearest(part.shape, part.R_BP.transpose() * (p - part.p_BP));
  return {found.distance, part.R_BP * found.normal};
}

/// Looks for the nearest point outside every part of a union, by branch and bound: where a point is
/// inside a part, it leaves that part through one of the part's faces.
class WayOut {
 public:
  // parts that are no farther apart are one: where two touch, their common face is inside [m]
  static constexpr double kApart = 1e-9;

  WayOut(const Union& whole, const Vector3d& p) noexcept : whole_(whole), p_(p) {}

  Nearest find() noexcept {
    branch(p_);
    const Vector3d way = best_ - p_;
    return {kApart - way.norm(), direction(way, last_normal_)};
  }

 private:
  void branch(const Vector3d& at) noexcept {
    const double length = (at - p_).squaredNorm();
    if (length >= shortest_) return;
    const Part* deepest = nullptr;
    Nearest found{kApart - kOnSurface, Vector3d::UnitZ()};
    for (const Part& part : whole_.parts) {
      const Nearest of_part = nearest_of_part(part, at);
      if (of_part.distance < found.distance) {
        found = of_part;
        deepest = &part;
      }
    }
    if (deepest == nullptr) {
      shortest_ = length;
      best_ = at;
      if (count_ > 0) last_normal_ = planes_[static_cast<std::size_t>(count_ - 1)].normal;
      return;
    }
    if (count_ == Union::kMostParts) return;
    switch (deepest->shape.kind) {
      case ShapeKind::kBox:
        for (int axis = 0; axis < 3; ++axis) {
          const double half = deepest->shape.half_sizes[axis];
          leave(*deepest, {Vector3d::Unit(axis), half});
          leave(*deepest, {-Vector3d::Unit(axis), half});
        }
        return;
      case ShapeKind::kConvexMesh:
        for (const Plane& face : deepest->shape.mesh->faces()) leave(*deepest, face);
        return;
      case ShapeKind::kCylinder:
        leave(*deepest, {Vector3d::UnitZ(), deepest->shape.half_length});
        leave(*deepest, {-Vector3d::UnitZ(), deepest->shape.half_length});
        leave_side(*deepest, at);
        return;
      default:
        through({found.normal, found.normal.dot(at) - found.distance});
    }
  }

  /// Through a plane of the part's frame.
  void leave(const Part& part, const Plane& plane) noexcept {
    const Vector3d normal = part.R_BP * plane.normal;
    through({normal, plane.offset + normal.dot(part.p_BP)});
  }

  /// Through the round side of a cylinder, where its tangent plane is.
  void leave_side(const Part& cylinder, const Vector3d& at) noexcept {
    const Vector3d p_P = cylinder.R_BP.transpose() * (at - cylinder.p_BP);
    leave(cylinder, {direction({p_P.x(), p_P.y(), 0.0}, Vector3d::UnitX()), cylinder.shape.radius});
  }

  void through(const Plane& plane) noexcept {
    planes_[static_cast<std::size_t>(count_++)] = {plane.normal, plane.offset + kApart};
    Vector3d at;
    if (project(at)) branch(at);
    --count_;
  }

  bool is_beyond_all(const Vector3d& at) const noexcept {
    for (int i = 0; i < count_; ++i) {
      const Plane& plane = planes_[static_cast<std::size_t>(i)];
      if (plane.normal.dot(at) < plane.offset - kOnSurface) return false;
    }
    return true;
  }

  /// The point beyond all planes that is nearest to p: on the newest plane, and one or two others.
  bool project(Vector3d& nearest_point) const noexcept {
    const Plane& newest = planes_[static_cast<std::size_t>(count_ - 1)];
    double best = std::numeric_limits<double>::infinity();
    const auto take = [&](const Vector3d& at) {
      if (!at.allFinite() || (at - p_).squaredNorm() >= best || !is_beyond_all(at)) return;
      best = (at - p_).squaredNorm();
      nearest_point = at;
    };
    const double short_of = newest.offset - newest.normal.dot(p_);
    take(p_ + short_of * newest.normal);
    if (best < std::numeric_limits<double>::infinity()) return true;
    for (int i = 0; i + 1 < count_; ++i) {
      Eigen::Matrix<double, 3, 2> N;
      const Plane& other = planes_[static_cast<std::size_t>(i)];
      N << newest.normal, other.normal;
      const Eigen::Vector2d beyond(short_of, other.offset - other.normal.dot(p_));
      const Eigen::Matrix2d NN = N.transpose() * N;
      if (NN.determinant() > 1e-12) take(p_ + N * NN.inverse() * beyond);
      for (int j = 0; j < i; ++j) {
        const Plane& third = planes_[static_cast<std::size_t>(j)];
        Eigen::Matrix3d A;
        A << newest.normal.transpose(), other.normal.transpose(), third.normal.transpose();
        if (std::abs(A.determinant()) > 1e-6)
          take(A.inverse() * Vector3d(newest.offset, other.offset, third.offset));
      }
    }
    return best < std::numeric_limits<double>::infinity();
  }

  static constexpr double kOnSurface = 1e-10;  // [m]

  const Union& whole_;
  Vector3d p_;
  std::array<Plane, Union::kMostParts> planes_;
  int count_ = 0;
  double shortest_ = std::numeric_limits<double>::infinity();
  Vector3d best_ = Vector3d::Zero(), last_normal_ = Vector3d::UnitZ();
};

Nearest nearest_of_union(const Union& whole, const Vector3d& p) noexcept {
  Nearest best{std::numeric_limits<double>::infinity(), Vector3d::UnitZ()};
  int at = 0;  // so many parts
  for (const Part& part : whole.parts) {
    const Nearest found = nearest_of_part(part, p);
    if (found.distance < best.distance) best = found;
    if (found.distance < WayOut::kApart) ++at;
  }
  if (at == 0 || (at == 1 && best.distance > -1e-12)) return best;
  return WayOut(whole, p).find();
}

}  // namespace

ConvexMesh::ConvexMesh(std::vector<Vector3d> points) : vertices_(std::move(points)) {
  const auto count = vertices_.size();
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vector3d& vertex : vertices_) {
    if (!vertex.allFinite())
      throw std::invalid_argument("convex mesh: expected finite points, got one that is not");
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  const double extent = count > 0 ? (high - low).norm() : 0.0;
  const double in_plane = 1e-9 * extent;
  const auto known = [&](const Plane& plane) {
    return std::any_of(faces_.begin(), faces_.end(), [&](const Plane& face) {
      return (face.normal - plane.normal).norm() < 1e-9 &&
             std::abs(face.offset - plane.offset) < in_plane;
    });
  };
  const auto holds_all = [&](const Plane& plane) {
    return std::all_of(vertices_.begin(), vertices_.end(), [&](const Vector3d& vertex) {
      return plane.normal.dot(vertex) <= plane.offset + in_plane;
    });
  };
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      for (std::size_t k = j + 1; k < count; ++k) {
        const Vector3d across = (vertices_[j] - vertices_[i]).cross(vertices_[k] - vertices_[i]);
        const double area = across.norm();
        if (!(area > 1e-9 * extent * extent)) continue;
        const Vector3d normal = across / area;
        const double offset = normal.dot(vertices_[i]);
        for (const Plane& plane : {Plane{normal, offset}, Plane{-normal, -offset}})
          if (holds_all(plane) && !known(plane)) faces_.push_back(plane);
      }
    }
  }
  // a flat one has but the two sides of its plane
  if (faces_.size() < 4)
    throw std::invalid_argument("convex mesh: expected points that enclose a volume, got " +
                                std::to_string(count) + " in one plane");
}

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

Shape Shape::all_of(const Union& parts) {
  Shape shape;
  shape.kind = ShapeKind::kUnion;
  shape.parts = &parts;
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
      return nearest_of_mesh(*shape.mesh, p_B);
    case ShapeKind::kUnion:
      break;
  }
  return nearest_of_union(*shape.parts, p_B);
}

}  // namespace c3rt::scene
