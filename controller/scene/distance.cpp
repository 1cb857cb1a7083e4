#include "controller/scene/distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "controller/scene/simplex.hpp"

namespace c3rt::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A convex shape as its middle, a point, a line or a body, with a skin around it.
class Core {
 public:
  Core(const Shape& shape, const Place& place) noexcept : shape_(shape), place_(place) {}

  double skin() const noexcept {
    const bool round = shape_.kind == ShapeKind::kSphere || shape_.kind == ShapeKind::kCapsule;
    return round ? shape_.radius : 0.0;
  }

  const Vector3d& middle() const noexcept { return place_.p; }

  /// The point of it that is farthest along a direction, in W.
  Vector3d farthest(const Vector3d& direction) const noexcept {
    const Vector3d along = place_.R.transpose() * direction;
    return place_.p + place_.R * farthest_here(along);
  }

  /// Calls `take` with the normals of its flat faces, in W.
  template <typename Take>
  void for_each_face(const Take& take) const noexcept {
    switch (shape_.kind) {
      case ShapeKind::kBox:
        for (int axis = 0; axis < 3; ++axis) {
          take(place_.R.col(axis));
          take(-place_.R.col(axis));
        }
        return;
      case ShapeKind::kCylinder:
        take(place_.R.col(2));
        take(-place_.R.col(2));
        return;
      case ShapeKind::kConvexMesh:
        for (const Plane& face : shape_.mesh->faces()) take(place_.R * face.normal);
        return;
      default:
        return;
    }
  }

 private:
  Vector3d farthest_here(const Vector3d& along) const noexcept {
    switch (shape_.kind) {
      case ShapeKind::kBox:
        return (along.array() < 0.0).select(-shape_.half_sizes, shape_.half_sizes);
      case ShapeKind::kCapsule:
        return {0.0, 0.0, along.z() < 0.0 ? -shape_.half_length : shape_.half_length};
      case ShapeKind::kCylinder: {
        const double across = along.head<2>().norm();
        const double scale = across > 0.0 ? shape_.radius / across : 0.0;
        return {scale * along.x(), scale * along.y(),
                along.z() < 0.0 ? -shape_.half_length : shape_.half_length};
      }
      case ShapeKind::kConvexMesh: {
        const Vector3d* best = &shape_.mesh->vertices().front();
        for (const Vector3d& vertex : shape_.mesh->vertices())
          if (along.dot(vertex) > along.dot(*best)) best = &vertex;
        return *best;
      }
      default:
        return Vector3d::Zero();
    }
  }

  const Shape& shape_;
  const Place& place_;
};

/// Of two cores that overlap: the least way apart along a normal of either, or from middle to
/// middle.
Separation least_overlap(const Core& first, const Core& second) noexcept {
  Separation best{-std::numeric_limits<double>::infinity(), Vector3d::UnitZ(), first.middle()};
  const auto take = [&](const Vector3d& normal, bool of_second) {
    const Vector3d near_first = first.farthest(-normal), near_second = second.farthest(normal);
    const double distance = normal.dot(near_first - near_second);
    if (distance <= best.distance) return;
    // the corner that is in the other's face
    best = {distance, normal, of_second ? near_first : near_second + distance * normal};
  };
  second.for_each_face([&](const Vector3d& normal) { take(normal, true); });
  first.for_each_face([&](const Vector3d& normal) { take(-normal, false); });
  const Vector3d between = first.middle() - second.middle();
  take(between.norm() > 0.0 ? Vector3d(between.normalized()) : Vector3d::UnitZ(), true);
  return best;
}

Separation of_cores(const Core& first, const Core& second) noexcept {
  constexpr int kMostSteps = 100;
  std::array<Vector3d, 4> on_first;
  on_first.fill(Vector3d::Zero());
  Simplex simplex;
  const auto add = [&](const Vector3d& towards) {
    // a slot that no corner uses
    int slot = 0;
    for (bool used = true; used; slot += used) {
      used = false;
      for (int i = 0; i < simplex.size; ++i)
        used |= simplex.tags[static_cast<std::size_t>(i)] == slot;
    }
    on_first[static_cast<std::size_t>(slot)] = first.farthest(towards);
    Vector3d corner = on_first[static_cast<std::size_t>(slot)] - second.farthest(-towards);
    simplex.add(corner, slot);
    return corner;
  };
  Vector3d v = first.middle() - second.middle();
  v = add(v.norm() > 0.0 ? Vector3d(-v) : Vector3d::UnitX());
  for (int step = 0; step < kMostSteps; ++step) {
    if (v.squaredNorm() < 1e-18) return least_overlap(first, second);
    Simplex before = simplex;
    const Vector3d corner = add(-v);
    if (v.squaredNorm() - v.dot(corner) <= 1e-12 * v.squaredNorm()) {
      simplex = before;
      break;
    }
    const Vector3d next = reduce(simplex);
    if (simplex.size == 4) return least_overlap(first, second);
    if (!(next.squaredNorm() < v.squaredNorm())) {
      simplex = before;
      break;
    }
    v = next;
  }
  if (v.squaredNorm() < 1e-18) return least_overlap(first, second);
  Vector3d p_first = Vector3d::Zero();
  for (int i = 0; i < simplex.size; ++i) {
    const auto at = static_cast<std::size_t>(i);
    p_first += simplex.weights[at] * on_first[static_cast<std::size_t>(simplex.tags[at])];
  }
  const double distance = v.norm();
  return {distance, v / distance, p_first};
}

Separation of_convex(const Shape& first, const Place& of_first, const Shape& second,
                     const Place& of_second) noexcept {
  const Core a(first, of_first), b(second, of_second);
  Separation found = of_cores(a, b);
  found.distance -= a.skin() + b.skin();
  found.p_first -= a.skin() * found.normal;
  return found;
}

Place place_of(const Part& part, const Place& body) noexcept {
  return {body.p + body.R * part.p_BP, body.R * part.R_BP};
}

template <typename Do>
void for_each_part(const Shape& shape, const Place& place, const Do& act) noexcept {
  if (shape.kind != ShapeKind::kUnion) return act(shape, place);
  for (const Part& part : shape.parts->parts) act(part.shape, place_of(part, place));
}

}  // namespace

Separation separation(const Shape& first, const Place& of_first, const Shape& second,
                      const Place& of_second) noexcept {
  Separation best{std::numeric_limits<double>::infinity(), Vector3d::UnitZ(), of_first.p};
  for_each_part(first, of_first, [&](const Shape& a, const Place& of_a) {
    for_each_part(second, of_second, [&](const Shape& b, const Place& of_b) {
      const Separation found = of_convex(a, of_a, b, of_b);
      if (found.distance < best.distance) best = found;
    });
  });
  return best;
}

}  // namespace c3rt::scene
