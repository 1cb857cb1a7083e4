#include "controller/model/support_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

namespace c3rt::model {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Point = SupportPoints::Point;

constexpr int kRimPoints = 8;  // of each end of a cylinder

/// All points that an object can lie on.
std::vector<Point> candidates(const scene::Object& object) {
  std::vector<Point> result;
  for (const scene::Part& part : object.parts->parts) {
    const scene::Shape& shape = part.shape;
    const auto add = [&](const Vector3d& p_P, double radius) {
      const Vector3d p_B = part.p_BP + part.R_BP * p_P;
      const bool known = std::any_of(result.begin(), result.end(), [&](const Point& point) {
        return point.radius == radius && (point.p_B - p_B).norm() < 1e-9;
      });
      if (!known) result.push_back({p_B, radius});
    };
    const Vector3d along_z = shape.half_length * Vector3d::UnitZ();
    switch (shape.kind) {
      case scene::ShapeKind::kBox:
        for (int corner = 0; corner < 8; ++corner) {
          const Vector3d signs((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                               (corner & 4) != 0 ? 1.0 : -1.0);
          add(signs.cwiseProduct(shape.half_sizes), 0.0);
        }
        break;
      case scene::ShapeKind::kCapsule:
        add(-along_z, shape.radius);
        add(along_z, shape.radius);
        break;
      case scene::ShapeKind::kCylinder:
        for (int i = 0; i < kRimPoints; ++i) {
          const double angle = 2.0 * M_PI * i / kRimPoints;
          const Vector3d rim = shape.radius * Vector3d(std::cos(angle), std::sin(angle), 0.0);
          add(rim - along_z, 0.0);
          add(rim + along_z, 0.0);
        }
        break;
      case scene::ShapeKind::kConvexMesh:
        for (const Vector3d& vertex : shape.mesh->vertices()) add(vertex, 0.0);
        break;
      default:
        add(Vector3d::Zero(), shape.radius);
    }
  }
  return result;
}

void sort_around(std::vector<Vector2d>& points) {
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& point : points) middle += point / static_cast<double>(points.size());
  std::sort(points.begin(), points.end(), [&](const Vector2d& a, const Vector2d& b) {
    return std::atan2(a.y() - middle.y(), a.x() - middle.x()) <
           std::atan2(b.y() - middle.y(), b.x() - middle.x());
  });
}

/// How wide and how safe a stand on these points is: their area times the way from the origin to
/// the nearest side, or less than nothing where the origin is not over it.
double stand(std::vector<Vector2d> around) {
  sort_around(around);
  double area = 0.0, inside = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < around.size(); ++i) {
    const Vector2d& from = around[i];
    const Vector2d side = around[(i + 1) % around.size()] - from;
    area += 0.5 * (from.x() * side.y() - from.y() * side.x());
    if (side.norm() > 0.0)
      inside = std::min(inside, (from.x() * side.y() - from.y() * side.x()) / side.norm());
  }
  return inside >= 0.0 ? area * inside : inside - 1.0;
}

/// The outermost along so many directions, each once, going round.
std::vector<Vector2d> outermost(const std::vector<Vector2d>& points) {
  constexpr int kWays = 12;
  std::vector<Vector2d> result;
  for (int way = 0; way < kWays; ++way) {
    const double angle = 2.0 * M_PI * (way + 0.1) / kWays;
    const Vector2d along(std::cos(angle), std::sin(angle));
    const Vector2d* best = &points.front();
    for (const Vector2d& point : points)
      if (along.dot(point) > along.dot(*best)) best = &point;
    if (std::find(result.begin(), result.end(), *best) == result.end()) result.push_back(*best);
  }
  return result;
}

/// So many points of a face that make the best stand: of its corners, and of the middles of its
/// sides where three are wanted, as no three corners of a rectangle have its middle well inside.
std::vector<Vector2d> spread(const std::vector<Vector2d>& on_face, std::size_t count) {
  std::vector<Vector2d> among = outermost(on_face);
  if (among.size() <= count) return among;
  if (count == 3) {
    const std::size_t corners = among.size();
    for (std::size_t i = 0; i < corners; ++i)
      among.emplace_back(0.5 * (among[i] + among[(i + 1) % corners]));
  }
  std::vector<Vector2d> best;
  double best_stand = -std::numeric_limits<double>::infinity();
  std::vector<bool> chosen(among.size(), false);
  std::fill_n(chosen.begin(), count, true);
  do {
    std::vector<Vector2d> choice;
    for (std::size_t i = 0; i < among.size(); ++i)
      if (chosen[i]) choice.push_back(among[i]);
    const double of_choice = stand(choice);
    if (of_choice > best_stand + 1e-12) {
      best_stand = of_choice;
      best = choice;
    }
  } while (std::prev_permutation(chosen.begin(), chosen.end()));
  return best;
}

}  // namespace

SupportPoints::SupportPoints(const scene::Object& object, int count) {
  if (count < 3 || count > 4) {
    throw std::invalid_argument("support points: expected 3 or 4 of each face, got " +
                                std::to_string(count));
  }
  const std::vector<Point> all = candidates(object);
  size_ = std::min(count, static_cast<int>(all.size()));
  std::vector<Vector3d> middles;
  for (const Point& point : all) middles.push_back(point.p_B);
  std::vector<Vector3d> normals;
  try {
    const scene::ConvexMesh hull(middles);
    for (const scene::Plane& face : hull.faces()) normals.push_back(face.normal);
  } catch (const std::invalid_argument&) {
    // a sphere, a capsule, or spheres in one plane: they lie on whatever is below
    for (int axis = 0; axis < 3; ++axis) {
      normals.emplace_back(Vector3d::Unit(axis));
      normals.emplace_back(-Vector3d::Unit(axis));
    }
  }
  double extent = 0.0;
  for (const Vector3d& middle : middles) extent = std::max(extent, middle.norm());
  for (const Vector3d& normal : normals) {
    const auto depth = [&](const Point& point) { return normal.dot(point.p_B) + point.radius; };
    double deepest = -std::numeric_limits<double>::infinity();
    for (const Point& point : all) deepest = std::max(deepest, depth(point));
    const Vector3d t = normal.unitOrthogonal(), s = normal.cross(t);
    std::vector<Point> above;
    std::vector<Vector2d> on_face;
    double radius = 0.0;  // the same of all points of a face, but for faces that lie on edges
    for (const Point& point : all) {
      if (depth(point) < deepest - 1e-5 * extent - 1e-9) {
        above.push_back(point);
      } else {
        on_face.emplace_back(t.dot(point.p_B), s.dot(point.p_B));
        radius = std::max(radius, point.radius);
      }
    }
    Face face{normal, {}};
    for (const Vector2d& at : spread(on_face, static_cast<std::size_t>(size_)))
      face.points.push_back({at.x() * t + at.y() * s + (deepest - radius) * normal, radius});
    // a face with fewer: the next ones that it would tip over to
    std::stable_sort(above.begin(), above.end(),
                     [&](const Point& a, const Point& b) { return depth(a) > depth(b); });
    for (const Point& point : above) {
      if (face.points.size() == static_cast<std::size_t>(size_)) break;
      face.points.push_back(point);
    }
    while (face.points.size() < static_cast<std::size_t>(size_))
      face.points.push_back(face.points.back());
    faces_.push_back(std::move(face));
  }
}

const std::vector<Point>& SupportPoints::below(const Eigen::Matrix3d& R_WB) const noexcept {
  const Vector3d down = -R_WB.row(2).transpose();
  const Face* best = &faces_.front();
  for (const Face& face : faces_)
    if (face.normal.dot(down) > best->normal.dot(down) + 1e-9) best = &face;
  return best->points;
}

}  // namespace c3rt::model
