#include "controller/scene/object.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace c3rt::scene {
namespace {

Eigen::Vector3d inertia_of(const Shape& shape, double mass) {
  const double r = shape.radius, length = 2.0 * shape.half_length;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return Eigen::Vector3d::Constant(0.4 * mass * r * r);
    case ShapeKind::kBox: {
      const Eigen::Vector3d squares = (2.0 * shape.half_sizes).cwiseAbs2();
      return mass / 12.0 *
             Eigen::Vector3d(squares.y() + squares.z(), squares.x() + squares.z(),
                             squares.x() + squares.y());
    }
    case ShapeKind::kCapsule: {
      // the two half spheres share the mass with the straight part by volume
      const double ends = mass / (1.0 + 0.75 * length / r), straight = mass - ends;
      const double across = straight * (0.25 * r * r + length * length / 12.0) +
                            ends * (0.4 * r * r + 0.25 * length * length + 0.375 * length * r);
      return {across, across, 0.5 * straight * r * r + 0.4 * ends * r * r};
    }
    case ShapeKind::kCylinder: {
      const double across = mass * (0.25 * r * r + length * length / 12.0);
      return {across, across, 0.5 * mass * r * r};
    }
    default:
      throw std::invalid_argument(
          "solid: expected a sphere, box, capsule or cylinder, got a mesh or a union");
  }
}

}  // namespace

Shape Object::shape() const noexcept {
  const Part& first = parts->parts.front();
  const bool alone = parts->parts.size() == 1 && first.p_BP.isZero(0.0) &&
                     first.R_BP == Eigen::Matrix3d::Identity();
  return alone ? first.shape : Shape::all_of(*parts);
}

Object make_object(std::string name, double mass, const Eigen::Matrix3d& inertia, double friction,
                   Union parts) {
  return {std::move(name),
          mass,
          inertia,
          friction,
          std::make_shared<const Union>(std::move(parts)),
          {}};
}

Object scaled(const Object& object, double mass, double size) {
  Object result = object;
  result.mass *= mass;
  result.inertia *= mass * size * size;
  if (size == 1.0) return result;
  Union parts;
  for (Part part : object.parts->parts) {
    part.p_BP *= size;
    part.shape.radius *= size;
    part.shape.half_length *= size;
    part.shape.half_sizes *= size;
    if (part.shape.kind == ShapeKind::kConvexMesh) {
      std::vector<Eigen::Vector3d> corners = part.shape.mesh->vertices();
      for (Eigen::Vector3d& corner : corners) corner *= size;
      parts.meshes.push_back(std::make_shared<const ConvexMesh>(std::move(corners)));
      part.shape.mesh = parts.meshes.back().get();
    }
    parts.parts.push_back(part);
  }
  result.parts = std::make_shared<const Union>(std::move(parts));
  for (Tag& tag : result.tags) {
    tag.p_BT *= size;
    tag.size *= size;
  }
  return result;
}

Object solid(std::string name, const Shape& shape, double mass, double friction) {
  Union parts;
  parts.parts.push_back({shape});
  return make_object(std::move(name), mass, inertia_of(shape, mass).asDiagonal(), friction,
                     std::move(parts));
}

double reach(const Shape& shape, const Eigen::Vector3d& direction) noexcept {
  double most = -std::numeric_limits<double>::infinity();
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return shape.radius;
    case ShapeKind::kBox:
      return direction.cwiseAbs().dot(shape.half_sizes);
    case ShapeKind::kCapsule:
      return shape.radius + shape.half_length * std::abs(direction.z());
    case ShapeKind::kCylinder:
      return shape.radius * direction.head<2>().norm() +
             shape.half_length * std::abs(direction.z());
    case ShapeKind::kConvexMesh:
      for (const Eigen::Vector3d& vertex : shape.mesh->vertices())
        most = std::max(most, direction.dot(vertex));
      return most;
    case ShapeKind::kUnion:
      break;
  }
  for (const Part& part : shape.parts->parts) {
    const Eigen::Vector3d in_part = part.R_BP.transpose() * direction;
    most = std::max(most, direction.dot(part.p_BP) + reach(part.shape, in_part));
  }
  return most;
}

}  // namespace c3rt::scene
