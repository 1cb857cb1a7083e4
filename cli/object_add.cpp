#include "cli/object_add.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "cli/decompose.hpp"
#include "cli/mesh/mesh.hpp"
#include "cli/mesh/tags.hpp"
#include "cli/millimetres.hpp"
#include "cli/object_picture.hpp"
#include "cli/paths.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/support_points.hpp"
#include "controller/scene/object.hpp"
#include "controller/scene/shape.hpp"

namespace c3rt::cli {
namespace fs = std::filesystem;
namespace {

using Eigen::Vector3d;

constexpr double kLargest = 1.0, kSmallest = 0.005;       // of what an arm pushes [m]
constexpr std::uintmax_t kMostBytes = 256 * 1024 * 1024;  // of a file
// distances take as long as there are corners; with these a sphere's hull is 3 % smaller than it
constexpr std::size_t kMostCorners = 150;
constexpr double kAlike = 0.03, kExact = 0.002;  // volumes of hull and mesh
constexpr double kOneFace = 0.9999;              // of normals that look the same way

static_assert(kLastTag == scene::Tag::kKinds - 1);

std::string name_of(const ObjectAddSettings& settings) {
  std::string name =
      settings.name.empty() ? fs::path(settings.file).stem().string() : settings.name;
  const bool plain =
      !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '_' || c == '-';
      });
  if (!plain) {
    throw UsageError("--name: expected letters, digits, _ and -, at most 64, got \"" + name + "\"");
  }
  return name;
}

mesh::Triangles read(const ObjectAddSettings& settings) {
  std::error_code error;
  if (!fs::is_regular_file(settings.file, error))
    throw UsageError(settings.file + ": expected a mesh file, got none that is there");
  if (const auto size = fs::file_size(settings.file, error); size > kMostBytes) {
    throw UsageError(
        fmt::format("{}: expected at most {} bytes, got {}", settings.file, kMostBytes, size));
  }
  mesh::Triangles mesh = mesh::parse(read_text(settings.file), settings.file);
  for (Vector3d& point : mesh.points) point *= settings.scale;
  return mesh;
}

Vector3d sizes_of(const mesh::Triangles& mesh) {
  Vector3d low = mesh.points.front(), high = low;
  for (const Vector3d& point : mesh.points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  return high - low;
}

void check_sizes(const ObjectAddSettings& settings, const Vector3d& sizes) {
  const double largest = sizes.maxCoeff();
  if (largest > kLargest) {
    throw UsageError(fmt::format(
        "{}: expected an object of at most {:g} m, got {:.4g} m: is the file in millimetres? "
        "(--scale 0.001)",
        settings.file, kLargest, largest));
  }
  if (largest < kSmallest) {
    throw UsageError(fmt::format(
        "{}: expected an object of at least {:g} mm, got {:.4g} mm: does the scale fit? (--scale)",
        settings.file, kSmallest / kMillimetre, largest / kMillimetre));
  }
}

struct Added {
  mesh::Solid solid;
  std::vector<mesh::Triangles> hulls;
  std::vector<std::string> notes;
};

/// The hull of a part that hangs together, or of each piece that it is divided into.
std::vector<mesh::Triangles> hulls_of(const ObjectAddSettings& settings,
                                      const mesh::Triangles& part) {
  std::vector<mesh::Triangles> hulls{mesh::hull_of(part, kMostCorners)};
  const bool closed = mesh::open_edges(part) == 0;
  if (!settings.decompose || !closed) return hulls;
  const double volume = std::abs(mesh::solid_of(part).volume);
  if (mesh::solid_of(hulls.front()).volume <= (1.0 + kAlike) * volume) return hulls;
  hulls.clear();
  for (const mesh::Triangles& piece : decompose(part, scene::Union::kMostParts))
    hulls.push_back(mesh::hull_of(piece, kMostCorners));
  return hulls;
}

/// Each part of the surface that hangs together is one convex piece, or several.
Added pieces_of(const ObjectAddSettings& settings, const mesh::Triangles& mesh) {
  Added added;
  std::vector<mesh::Triangles> parts = mesh::components(mesh);
  // groups that are patches of one surface close it together
  const auto is_open = [](const mesh::Triangles& part) { return mesh::open_edges(part) > 0; };
  if (std::any_of(parts.begin(), parts.end(), is_open))
    parts = mesh::components(mesh::welded(mesh));
  const auto check_count = [&](std::size_t count) {
    if (count <= static_cast<std::size_t>(scene::Union::kMostParts)) return;
    throw UsageError(fmt::format("{}: expected at most {} separate parts, got {}", settings.file,
                                 scene::Union::kMostParts, count));
  };
  check_count(parts.size());
  double of_hulls = 0.0;
  int turned = 0;
  Vector3d moment = Vector3d::Zero();
  std::vector<mesh::Solid> solids;
  for (mesh::Triangles& part : parts) {
    const std::vector<mesh::Triangles> hulls = hulls_of(settings, part);
    added.hulls.insert(added.hulls.end(), hulls.begin(), hulls.end());
    check_count(added.hulls.size());
    for (const mesh::Triangles& hull : hulls) of_hulls += mesh::solid_of(hull).volume;
    if (const std::size_t open = mesh::open_edges(part); open > 0) {
      added.notes.push_back(fmt::format(
          "its surface is not closed ({} edges without one triangle on either side): inertia and "
          "volume are those of the convex hull",
          open));
      solids.push_back(mesh::solid_of(hulls.front()));
    } else {
      turned += mesh::turn_outwards(part) ? 1 : 0;
      solids.push_back(mesh::solid_of(part));
    }
    added.solid.volume += solids.back().volume;
    moment += solids.back().volume * solids.back().com;
  }
  if (turned > 0) added.notes.emplace_back("its triangles looked inwards: they are turned round");
  added.solid.com = moment / added.solid.volume;
  for (const mesh::Solid& solid : solids) {
    const Vector3d from_com = solid.com - added.solid.com;
    added.solid.inertia += solid.volume / added.solid.volume *
                           (solid.inertia + from_com.squaredNorm() * Eigen::Matrix3d::Identity() -
                            from_com * from_com.transpose());
  }
  const double more = of_hulls / added.solid.volume - 1.0;
  if (more > kAlike) {
    added.notes.push_back(fmt::format(
        "its convex hull{} {:.3g} % more volume than it: hollows are filled. {}",
        added.hulls.size() == 1 ? " has" : "s have", 100.0 * more,
        settings.decompose
            ? "What CoACD made of it is still so much larger"
            : "--decompose divides it into convex pieces by CoACD (" +
                  std::string(kDecomposerInstalled) +
                  "); or save it as separate closed convex parts in one file, and each becomes a "
                  "piece"));
  } else if (std::abs(more) > kExact) {
    added.notes.push_back(
        fmt::format("its pieces have {:+.2g} % of its volume more than it", 100.0 * more));
  }
  return added;
}

std::string mesh_name(const std::string& name, std::size_t piece) {
  return fmt::format("{}_{}", name, piece + 1);
}

/// With ids from the first one on.
std::vector<Vector3d> tags_of(const ObjectAddSettings& settings, const Added& added) {
  if (settings.first_tag < 0) return {};
  std::vector<Vector3d> tags = mesh::tag_places(added.hulls, settings.tag_size);
  const double width = (1.0 + 2.0 * mesh::kTagBorder) * settings.tag_size;
  if (tags.empty()) {
    throw UsageError(fmt::format(
        "--tags: expected a flat place of {0:g} x {0:g} mm that looks up, a tag with its white "
        "border, got none (--tag-size)",
        width / kMillimetre));
  }
  const int most = kLastTag + 1 - settings.first_tag;
  if (static_cast<int>(tags.size()) > most) tags.resize(static_cast<std::size_t>(most));
  return tags;
}

std::string to_mjcf(const std::string& name, const ObjectAddSettings& settings, const Added& added,
                    const std::vector<Vector3d>& tags) {
  const Eigen::Matrix3d I = settings.mass * added.solid.inertia;
  std::string assets, geoms;
  for (std::size_t i = 0; i < added.hulls.size(); ++i) {
    const std::string piece = mesh_name(name, i);
    assets += fmt::format("    <mesh name=\"{0}\" file=\"{0}.obj\"/>\n", piece);
    geoms += fmt::format(
        "      <geom name=\"{0}\" type=\"mesh\" mesh=\"{0}\" friction=\"{1:g} 0.005 0.0001\"/>\n",
        piece, settings.friction);
  }
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const double half = 0.5 * settings.tag_size;
    geoms += fmt::format(
        "      <site name=\"tag36h11_{}\" type=\"box\" size=\"{:.9g} {:.9g} 0.0001\" "
        "pos=\"{:.9g} {:.9g} {:.9g}\"/>\n",
        settings.first_tag + static_cast<int>(i), half, half, tags[i].x(), tags[i].y(),
        tags[i].z());
  }
  return fmt::format(
      "<mujoco model=\"{}\">\n  <asset>\n{}  </asset>\n  <worldbody>\n    <body name=\"{}\">\n"
      "      <freejoint/>\n"
      "      <inertial pos=\"{:.9g} {:.9g} {:.9g}\" mass=\"{:.9g}\"\n"
      "        fullinertia=\"{:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\"/>\n{}"
      "    </body>\n  </worldbody>\n</mujoco>\n",
      name, assets, name, added.solid.com.x(), added.solid.com.y(), added.solid.com.z(),
      settings.mass, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2), geoms);
}

/// What there is to push on, as seen from above: the widest first.
void print_faces(const Added& added) {
  struct Side {
    double area;
    Vector3d normal;
  };
  std::vector<Side> sides;
  for (const mesh::Triangles& hull : added.hulls) {
    for (const Eigen::Vector3i& corners : hull.triangles) {
      const Vector3d& from = hull.points[static_cast<std::size_t>(corners[0])];
      const Vector3d across = (hull.points[static_cast<std::size_t>(corners[1])] - from)
                                  .cross(hull.points[static_cast<std::size_t>(corners[2])] - from);
      const Vector3d normal = across.normalized();
      if (!can_be_pushed(normal)) continue;
      const auto same = std::find_if(sides.begin(), sides.end(), [&](const Side& side) {
        return side.normal.dot(normal) > kOneFace;
      });
      if (same == sides.end()) {
        sides.push_back({0.5 * across.norm(), normal});
      } else {
        same->area += 0.5 * across.norm();
      }
    }
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.area > b.area; });
  fmt::print("  to push on: faces of {} directions", sides.size());
  const std::size_t shown = std::min<std::size_t>(sides.size(), 4);
  for (std::size_t i = 0; i < shown; ++i) {
    const Vector3d& normal = sides[i].normal;
    fmt::print("{} ({:.2g}, {:.2g}, {:.2g}) {:.3g} cm2", i == 0 ? ", widest" : ",",
               normal.x() + 0.0, normal.y() + 0.0, normal.z() + 0.0, 1e4 * sides[i].area);
  }
  fmt::print("\n");
}

void refuse_to_overwrite(const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(file, error)))
      throw UsageError(file.string() + ": expected no such file, got one (--force overwrites it)");
  }
}

}  // namespace

int add_object(const ObjectAddSettings& settings) {
  const std::string name = name_of(settings);
  Added added;
  Vector3d sizes;
  try {
    const mesh::Triangles mesh = read(settings);
    sizes = sizes_of(mesh);
    check_sizes(settings, sizes);
    added = pieces_of(settings, mesh);
  } catch (const mesh::Error& error) {
    throw UsageError(error.what());
  }
  const std::vector<Vector3d> tags = tags_of(settings, added);
  const fs::path folder = make_folder(settings.out), model = folder / (name + ".xml"),
                 picture = folder / (name + ".png");
  std::vector<fs::path> files{model};
  for (std::size_t i = 0; i < added.hulls.size(); ++i)
    files.push_back(folder / (mesh_name(name, i) + ".obj"));
  if (settings.picture) files.push_back(picture);
  if (!settings.force) refuse_to_overwrite(files);
  for (std::size_t i = 0; i < added.hulls.size(); ++i)
    write_text(files[i + 1], mesh::to_obj(added.hulls[i]));
  write_text(model, to_mjcf(name, settings, added, tags));

  // as planner and plant will read it
  const mjcf::ObjectFile object = [&] {
    try {
      return mjcf::read_object(model.string());
    } catch (const mjcf::Error& error) {
      throw UsageError(error.what());
    }
  }();
  const Eigen::Matrix3d& I = object.object.inertia;
  fmt::print(
      "{}: {:.4g} x {:.4g} x {:.4g} mm, volume {:.4g} cm3, mass {:.4g} kg, friction {:g}\n"
      "  centre of mass {:.4g} {:.4g} {:.4g} mm from the file's origin\n"
      "  inertia about it {:.4g} {:.4g} {:.4g} (xx yy zz), {:.4g} {:.4g} {:.4g} (xy xz yz) kg m2\n",
      name, sizes.x() / kMillimetre, sizes.y() / kMillimetre, sizes.z() / kMillimetre,
      1e6 * added.solid.volume, object.object.mass, object.object.friction,
      millimetres(added.solid.com.x()), millimetres(added.solid.com.y()),
      millimetres(added.solid.com.z()), I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  for (std::size_t i = 0; i < added.hulls.size(); ++i)
    fmt::print("  {}: convex, {} corners\n", files[i + 1].filename().string(),
               added.hulls[i].points.size());
  ObjectPicture looks{name, added.hulls, {}, tags, settings.tag_size, added.solid.com};
  fmt::print("  lies on the table with the side that is down in the file, on\n");
  const model::SupportPoints support(object.object, 4);
  for (const auto& point : support.below(Eigen::Matrix3d::Identity())) {
    looks.support.emplace_back(object.p_body_com + point.p_B - point.radius * Vector3d::UnitZ());
    fmt::print("    {:.4g} {:.4g} {:.4g} mm\n", millimetres(point.p_B.x()),
               millimetres(point.p_B.y()), millimetres(point.p_B.z()));
  }
  print_faces(added);
  if (!tags.empty()) {
    fmt::print("  {} of {:g} mm on its top: tag36h11_{}{}\n",
               tags.size() == 1 ? "a tag" : fmt::format("{} tags", tags.size()),
               settings.tag_size / kMillimetre, settings.first_tag,
               tags.size() == 1
                   ? ""
                   : fmt::format(" to {}", settings.first_tag + static_cast<int>(tags.size()) - 1));
  }
  if (settings.picture) {
    const std::string missing = draw_object(picture, looks);
    if (!missing.empty()) added.notes.push_back(missing);
  }
  if (!added.notes.empty()) fmt::print("mind\n");
  for (const std::string& note : added.notes) fmt::print("  - {}\n", note);
  fmt::print("written: {0} (c3rt lcs inspect {0})\n", model.string());
  return kDone;
}

}  // namespace c3rt::cli
