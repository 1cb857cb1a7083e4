#include "cli/mesh/tags.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/scene/shape.hpp"

namespace c3rt::cli::mesh {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFlat = 1.0 - 1e-6;  // z of a normal that looks up
constexpr double kSmall = 1e-6;       // [m]
constexpr double kOver = 2e-4;        // a border may reach over an edge by this [m]
constexpr int kSteps = 8;             // of a tag's width, where rows do not fit

/// A convex piece's face that looks up.
struct Top {
  std::size_t piece;
  double z;
  Vector2d low, high;  // around it
};

class Room {
 public:
  Room(const std::vector<Triangles>& pieces, double size)
      : width_((1.0 + 2.0 * kTagBorder) * size) {
    for (const Triangles& piece : pieces) pieces_.emplace_back(piece.points);
  }

  std::vector<Vector3d> places() const {
    std::vector<Vector3d> all;
    for (const Top& top : tops()) {
      std::vector<Vector3d> rows = in_rows(top), packed = one_by_one(top);
      const auto& more = packed.size() > rows.size() ? packed : rows;
      for (const Vector3d& place : more)
        if (!overlaps(all, place)) all.push_back(place);
    }
    return all;
  }

 private:
  std::vector<Top> tops() const {
    std::vector<Top> tops;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      for (const scene::Plane& face : pieces_[i].faces()) {
        if (face.normal.z() < kFlat) continue;
        Top top{i, face.offset / face.normal.z(),
                Vector2d::Constant(std::numeric_limits<double>::max()),
                Vector2d::Constant(std::numeric_limits<double>::lowest())};
        for (const Vector3d& corner : pieces_[i].vertices()) {
          if (face.normal.dot(corner) < face.offset - kSmall) continue;
          top.low = top.low.cwiseMin(corner.head<2>());
          top.high = top.high.cwiseMax(corner.head<2>());
        }
        tops.push_back(top);
      }
    }
    return tops;
  }

  /// Rows about the middle of the face.
  std::vector<Vector3d> in_rows(const Top& top) const {
    std::vector<Vector3d> places;
    const Vector2d middle = 0.5 * (top.low + top.high), sizes = top.high - top.low;
    const auto fit = [&](int axis) {
      return static_cast<int>(std::floor((sizes[axis] + 2.0 * kOver) / width_));
    };
    for (int i = 0; i < fit(0); ++i) {
      for (int j = 0; j < fit(1); ++j) {
        const Vector2d at =
            middle + width_ * Vector2d(i - 0.5 * (fit(0) - 1), j - 0.5 * (fit(1) - 1));
        if (free(top, at)) places.emplace_back(at.x(), at.y(), top.z);
      }
    }
    return places;
  }

  /// Each at the first place that the others leave.
  std::vector<Vector3d> one_by_one(const Top& top) const {
    std::vector<Vector3d> places;
    const double step = width_ / kSteps, half = 0.5 * width_;
    for (double y = top.low.y() + half - kOver; y <= top.high.y() - half + kOver; y += step) {
      for (double x = top.low.x() + half - kOver; x <= top.high.x() - half + kOver; x += step) {
        const Vector3d place(x, y, top.z);
        if (!overlaps(places, place) && free(top, {x, y})) places.push_back(place);
      }
    }
    return places;
  }

  bool overlaps(const std::vector<Vector3d>& others, const Vector3d& place) const {
    return std::any_of(others.begin(), others.end(), [&](const Vector3d& other) {
      return (other - place).head<2>().lpNorm<Eigen::Infinity>() < width_ - kSmall;
    });
  }

  /// All of it lies on the face, and under nothing.
  bool free(const Top& top, const Vector2d& at) const {
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        const Vector2d edge = at + (0.5 * width_ - kOver) * Vector2d(i, j);
        const Vector3d point(edge.x(), edge.y(), top.z);
        if (above(pieces_[top.piece], point - kSmall * Vector3d::UnitZ()) <= 0.0) return false;
        for (std::size_t other = 0; other < pieces_.size(); ++other) {
          if (other != top.piece && above(pieces_[other], point) > 10 * kSmall) return false;
        }
      }
    }
    return true;
  }

  /// How far up from the point the piece reaches; negative where it is nowhere above it [m].
  static double above(const scene::ConvexMesh& piece, const Vector3d& point) {
    double from = 0.0, to = std::numeric_limits<double>::max();
    for (const scene::Plane& face : piece.faces()) {
      const double room = face.offset - face.normal.dot(point), up = face.normal.z();
      if (std::abs(up) < 1e-12) {
        if (room < -kSmall) return -1.0;
      } else if (up > 0.0) {
        to = std::min(to, room / up);
      } else {
        from = std::max(from, room / up);
      }
    }
    return to >= from ? to : -1.0;
  }

  std::vector<scene::ConvexMesh> pieces_;
  double width_;  // of a tag with its border [m]
};

}  // namespace

std::vector<Vector3d> tag_places(const std::vector<Triangles>& pieces, double size) {
  return Room(pieces, size).places();
}

}  // namespace c3rt::cli::mesh
