#include "cli/object_picture.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "cli/millimetres.hpp"
#include "cli/report/gnuplot.hpp"
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
  std::string at(const Vector3d& point) const {
    return fmt::format("{:.4f} {:.4f}\n", right_.dot(point) / kMillimetre,
                       up_.dot(point) / kMillimetre);
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

int colour_of(const Face& face, const Vector3d& eye) {
  const double light = 0.55 + 0.45 * std::abs(face.normal.dot(eye));
  const Vector3d colour =
      can_be_pushed(face.normal) ? Vector3d(253, 174, 97) : Vector3d(200, 205, 210);
  const auto channel = [&](int i) { return static_cast<int>(light * colour[i]); };
  return channel(0) << 16 | channel(1) << 8 | channel(2);
}

/// Blocks of outlines "x y", far ones first.
std::string panel(const ObjectPicture& picture, bool above) {
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
  std::string plots, data;
  const auto add = [&](const std::string& rows, const std::string& how) {
    plots += (plots.empty() ? "plot '-' " : ", '-' ") + how;
    data += rows + "e\n";
  };
  const auto outline = [&](const std::vector<Vector3d>& corners, const std::string& how) {
    std::string rows;
    for (const Vector3d& corner : corners) rows += view.at(corner);
    rows += view.at(corners.front());
    return add(rows, how);
  };
  for (const Face& face : faces) {
    const int colour = colour_of(face, view.eye());
    outline(face.corners, fmt::format("with filledcurves closed lc rgb 0x{:06x} notitle", colour));
    outline(face.corners, "with lines lw 0.8 lc rgb '#404040' notitle");
  }
  if (above) {
    const double half = 0.5 * picture.tag_size;
    for (const Vector3d& tag : picture.tags) {
      outline({tag + Vector3d(-half, -half, 0), tag + Vector3d(half, -half, 0),
               tag + Vector3d(half, half, 0), tag + Vector3d(-half, half, 0)},
              "with filledcurves closed lc rgb '#303030' notitle");
    }
    add(view.at(picture.com),
        "with points pt 2 ps 1.6 lw 2 lc rgb '#2166ac' title 'centre of mass'");
  } else {
    std::string rows;
    for (const Vector3d& point : picture.support) rows += view.at(point);
    add(rows, "with points pt 7 ps 1.4 lc rgb '#b2182b' title 'stands on'");
  }
  return fmt::format("set title {} noenhanced\n{}\n{}",
                     gnuplot::quoted(above ? "from above" : "from below"), plots, data);
}

}  // namespace

bool can_be_pushed(const Vector3d& normal) {
  return normal.head<2>().norm() >= planner::kLeastAlongTable;
}

std::string draw_object(const std::filesystem::path& file, const ObjectPicture& picture) {
  const std::string title = picture.name + ": orange can be pushed on, dark squares are tags";
  return gnuplot::draw(
      file,
      gnuplot::terminal(kWidth, kHeight) +
          fmt::format("set multiplot layout 1,2 title {} noenhanced\n", gnuplot::quoted(title)) +
          "unset tics\nunset border\nunset grid\nset size ratio -1\nset offsets graph 0.05, graph "
          "0.05, graph 0.05, graph 0.05\n"
          "set key bottom right\n" +
          panel(picture, true) + panel(picture, false) + "unset multiplot\n");
}

}  // namespace c3rt::cli
