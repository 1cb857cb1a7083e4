#include "cli/object_picture.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "cli/millimetres.hpp"
#include "cli/report/figure.hpp"
#include "controller/planner/strategy/surface_samples.hpp"
#include "controller/scene/shape.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Vector3d;

constexpr int kWidth = 900, kHeight = 450;
constexpr double kAzimuth = 0.45, kElevation = 0.9;  // of the eye, from −y and from the table [rad]

struct Face {
  std::vector<Vector3d> corners;
  Vector3d normal;
};

/// An eye far away, above or below the table.
class View {
 public:
  explicit View(bool above) {
    const double elevation = above ? kElevation : -kElevation;
    eye_ = Vector3d(std::sin(kAzimuth) * std::cos(elevation),
                    -std::cos(kAzimuth) * std::cos(elevation), std::sin(elevation));
    right_ = Vector3d::UnitZ().cross(eye_).normalized();
    up_ = eye_.cross(right_);
  }
  const Vector3d& eye() const { return eye_; }
  /// In the picture [mm], a point a column.
  Eigen::Matrix2Xd at(const std::vector<Vector3d>& points) const {
    Eigen::Matrix2Xd all(2, points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      all.col(static_cast<Eigen::Index>(i)) =
          Eigen::Vector2d(right_.dot(points[i]), up_.dot(points[i])) / kMillimetre;
    }
    return all;
  }

 private:
  Vector3d eye_, right_, up_;
};

std::vector<Face> faces_of(const mesh::Triangles& piece) {
  const scene::ConvexMesh hull(piece.points);
  double extent = 0.0;
  for (const Vector3d& corner : hull.vertices())
    extent = std::max(extent, (corner - hull.vertices().front()).norm());
  std::vector<Face> faces;
  for (const scene::Plane& plane : hull.faces()) {
    Face face{{}, plane.normal};
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& corner : hull.vertices()) {
      if (plane.normal.dot(corner) < plane.offset - 1e-6 * extent) continue;
      face.corners.push_back(corner);
      middle += corner;
    }
    middle /= static_cast<double>(face.corners.size());
    const Vector3d t = plane.normal.unitOrthogonal(), s = plane.normal.cross(t);
    const auto turn = [&](const Vector3d& corner) {
      return std::atan2(s.dot(corner - middle), t.dot(corner - middle));
    };
    std::sort(face.corners.begin(), face.corners.end(),
              [&](const Vector3d& a, const Vector3d& b) { return turn(a) < turn(b); });
    faces.push_back(std::move(face));
  }
  return faces;
}

std::string colour_of(const Face& face, const Vector3d& eye) {
  const double light = 0.55 + 0.45 * std::abs(face.normal.dot(eye));
  const Vector3d colour =
      can_be_pushed(face.normal) ? Vector3d(253, 174, 97) : Vector3d(200, 205, 210);
  const auto channel = [&](int i) { return static_cast<int>(light * colour[i]); };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(0), channel(1), channel(2));
}

/// Far faces first.
Panel panel(const ObjectPicture& picture, bool above) {
  const View view(above);
  std::vector<Face> faces;
  for (const mesh::Triangles& piece : picture.pieces) {
    for (Face& face : faces_of(piece))
      if (face.normal.dot(view.eye()) > 1e-6) faces.push_back(std::move(face));
  }
  const auto nearness = [&](const Face& face) {
    double sum = 0.0;
    for (const Vector3d& corner : face.corners) sum += view.eye().dot(corner);
    return sum / static_cast<double>(face.corners.size());
  };
  std::stable_sort(faces.begin(), faces.end(),
                   [&](const Face& a, const Face& b) { return nearness(a) < nearness(b); });
  Panel panel{above ? "from above" : "from below", "", "", {}};
  panel.equal = true;
  panel.axes = false;
  panel.legend_below = true;
  const auto add = [&](const std::vector<Vector3d>& corners, const std::string& colour,
                       const char* edge) {
    const Eigen::Matrix2Xd outline = view.at(corners);
    panel.polygons.push_back({"", colour, edge, outline.row(0), outline.row(1)});
  };
  const auto mark = [&](const char* name, const char* colour, const std::vector<Vector3d>& points) {
    const Eigen::Matrix2Xd places = view.at(points);
    Curve curve{name, colour, places.row(0), places.row(1), false, true, false};
    curve.cross = above;
    curve.mark_size = 8.0;
    panel.curves.push_back(curve);
  };
  for (const Face& face : faces) add(face.corners, colour_of(face, view.eye()), "#404040");
  if (above) {
    const double half = 0.5 * picture.tag_size;
    for (const Vector3d& tag : picture.tags) {
      add({tag + Vector3d(-half, -half, 0), tag + Vector3d(half, -half, 0),
           tag + Vector3d(half, half, 0), tag + Vector3d(-half, half, 0)},
          "#303030", "");
    }
    mark("centre of mass", kBlue, {picture.com});
  } else {
    mark("stands on", "#7b3294", picture.support);
  }
  return panel;
}

}  // namespace

bool can_be_pushed(const Vector3d& normal) {
  return normal.head<2>().norm() >= planner::kLeastAlongTable;
}

std::string draw_object(const std::filesystem::path& file, const ObjectPicture& picture) {
  return draw({{file,
                {picture.name + ": orange can be pushed on, dark squares are tags",
                 {panel(picture, true), panel(picture, false)},
                 2,
                 kWidth,
                 kHeight}}});
}

}  // namespace c3rt::cli
