#include "cli/mesh/mesh.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <numeric>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "controller/scene/shape.hpp"

namespace c3rt::cli::mesh {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr std::size_t kLongestQuote = 40;

[[noreturn]] void fail(const std::string& where, const std::string& expected, std::string got) {
  if (got.size() > kLongestQuote) got = got.substr(0, kLongestQuote) + "...";
  for (char& c : got)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
  throw Error(where + ": expected " + expected + ", got " + got);
}

double coordinate(const std::string& word, const std::string& where) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (word.empty() || *end != '\0' || !std::isfinite(value) || std::abs(value) > 1e6)
    fail(where, "a coordinate between -1e6 and 1e6", "\"" + word + "\"");
  return value;
}

/// Takes triangles, with points at one place as one.
class Builder {
 public:
  int point(const Vector3d& at) {
    const std::array<double, 4> key{at.x() + 0.0, at.y() + 0.0, at.z() + 0.0, part_};  // -0 is 0
    const auto [found, is_new] = known_.try_emplace(key, static_cast<int>(mesh_.points.size()));
    if (is_new) mesh_.points.push_back(at);
    return found->second;
  }
  /// What follows shares no points with what came before.
  void next_part() { part_ += 1.0; }
  /// Without area through a point that is there twice: it is left out.
  void triangle(int a, int b, int c, const std::string& where) {
    if (a == b || b == c || c == a) return;
    if (mesh_.triangles.size() == kMostTriangles)
      fail(where, "at most " + std::to_string(kMostTriangles) + " triangles", "more");
    mesh_.triangles.emplace_back(a, b, c);
  }
  Triangles take(const std::string& file) {
    if (mesh_.triangles.size() < 4) {
      fail(file, "a mesh of at least 4 triangles", std::to_string(mesh_.triangles.size()));
    }
    return std::move(mesh_);
  }

 private:
  Triangles mesh_;
  std::map<std::array<double, 4>, int> known_;
  double part_ = 0.0;
};

std::string place(const std::string& file, std::size_t line) {
  return file + ":" + std::to_string(line);
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

Triangles parse_obj(const std::string& text, const std::string& file) {
  Builder mesh;
  std::vector<int> points;  // by their number in the file
  std::istringstream stream(text);
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::vector<std::string> words = words_of(line.substr(0, line.find('#')));
    if (words.empty()) continue;
    const std::string where = place(file, number);
    if (words[0] == "v") {
      // with a weight or a colour after it
      if (words.size() < 4) fail(where, "three coordinates after v", line);
      points.push_back(mesh.point(
          {coordinate(words[1], where), coordinate(words[2], where), coordinate(words[3], where)}));
      continue;
    }
    if (words[0] == "o" || words[0] == "g") mesh.next_part();
    if (words[0] != "f") continue;
    if (words.size() < 4) fail(where, "three corners or more after f", line);
    std::vector<int> corners;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const std::string index = words[i].substr(0, words[i].find('/'));
      char* end = nullptr;
      const long given = std::strtol(index.c_str(), &end, 10);
      const long count = static_cast<long>(points.size());
      const long at = given < 0 ? count + given : given - 1;  // from the end, or from 1
      if (index.empty() || *end != '\0' || given == 0 || at < 0 || at >= count)
        fail(where, fmt::format("the number of one of the {} points so far", count), words[i]);
      corners.push_back(points[static_cast<std::size_t>(at)]);
    }
    for (std::size_t i = 2; i < corners.size(); ++i)
      mesh.triangle(corners[0], corners[i - 1], corners[i], where);
  }
  return mesh.take(file);
}

constexpr std::size_t kStlHead = 84, kStlTriangle = 50;  // [bytes]

Triangles parse_binary_stl(const std::string& text, const std::string& file) {
  Builder mesh;
  for (std::size_t at = kStlHead, number = 1; at < text.size(); at += kStlTriangle, ++number) {
    const std::string where = fmt::format("{}: triangle {}", file, number);
    std::array<float, 12> values{};  // the normal, then three corners
    std::memcpy(values.data(), text.data() + at, sizeof values);
    std::array<int, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d p(values[3 * i + 3], values[3 * i + 4], values[3 * i + 5]);
      if (!p.allFinite() || p.cwiseAbs().maxCoeff() > 1e6)
        fail(where, "coordinates between -1e6 and 1e6", "others");
      corners[i] = mesh.point(p);
    }
    mesh.triangle(corners[0], corners[1], corners[2], where);
  }
  return mesh.take(file);
}

Triangles parse_ascii_stl(const std::string& text, const std::string& file) {
  Builder mesh;
  std::vector<int> corners;
  std::istringstream stream(text);
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) continue;
    const std::string where = place(file, number);
    if (words[0] == "vertex") {
      if (words.size() != 4) fail(where, "three coordinates after vertex", line);
      corners.push_back(mesh.point(
          {coordinate(words[1], where), coordinate(words[2], where), coordinate(words[3], where)}));
    } else if (words[0] == "endfacet") {
      if (corners.size() != 3)
        fail(where, "three vertices in a facet", std::to_string(corners.size()));
      mesh.triangle(corners[0], corners[1], corners[2], where);
      corners.clear();
    } else if (words[0] == "solid") {
      mesh.next_part();
    } else if (words[0] != "facet" && words[0] != "outer" && words[0] != "endloop" &&
               words[0] != "endsolid") {
      fail(where, "a word of ASCII STL", line);
    }
  }
  if (!corners.empty()) fail(place(file, number), "endfacet", "the end of the file");
  return mesh.take(file);
}

Triangles parse_stl(const std::string& text, const std::string& file) {
  if (text.size() >= kStlHead) {
    std::uint32_t count = 0;
    std::memcpy(&count, text.data() + kStlHead - sizeof count, sizeof count);
    if (text.size() == kStlHead + kStlTriangle * std::size_t{count})
      return parse_binary_stl(text, file);
  }
  if (text.compare(0, 5, "solid") == 0) return parse_ascii_stl(text, file);
  fail(file, "binary STL (84 bytes, and 50 for each triangle it says it has) or ASCII STL",
       fmt::format("{} bytes of neither", text.size()));
}

/// For each triangle the six volumes of its tetrahedron from `origin`, and the sums.
double signed_volume(const Triangles& mesh) {
  double six = 0.0;
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d& origin = mesh.points.front();
    const auto at = [&](int i) -> Vector3d {
      return mesh.points[static_cast<std::size_t>(t[i])] - origin;
    };
    six += at(0).dot(at(1).cross(at(2)));
  }
  return six / 6.0;
}

}  // namespace

Triangles parse(const std::string& text, const std::string& file) {
  std::string ending = file.substr(std::min(file.size(), file.rfind('.') + 1));
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == "obj") return parse_obj(text, file);
  if (ending == "stl") return parse_stl(text, file);
  fail(file, "a file that ends with .obj or .stl", "." + ending);
}

Solid solid_of(const Triangles& mesh) {
  Solid solid;
  const Vector3d origin = mesh.points.front();
  Matrix3d second = Matrix3d::Zero();  // ∫ r rᵀ from the origin
  for (const Vector3i& t : mesh.triangles) {
    const auto at = [&](int i) -> Vector3d {
      return mesh.points[static_cast<std::size_t>(t[i])] - origin;
    };
    const Vector3d a = at(0), b = at(1), c = at(2), sum = a + b + c;
    const double volume = a.dot(b.cross(c)) / 6.0;
    solid.volume += volume;
    solid.com += 0.25 * volume * sum;
    second += volume / 20.0 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  Vector3d low = mesh.points.front(), high = low;
  for (const Vector3d& point : mesh.points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  if (!(solid.volume > 1e-9 * std::pow((high - low).norm(), 3)))
    throw Error("expected a mesh that encloses a volume, got one of " +
                fmt::format("{:.3g} m3", solid.volume));
  solid.com /= solid.volume;
  second = (second / solid.volume - solid.com * solid.com.transpose()).eval();
  solid.inertia = second.trace() * Matrix3d::Identity() - second;
  solid.com += origin;
  return solid;
}

Triangles welded(const Triangles& mesh) {
  Builder builder;
  for (const Vector3i& t : mesh.triangles) {
    const auto at = [&](int i) {
      return builder.point(mesh.points[static_cast<std::size_t>(t[i])]);
    };
    const int a = at(0), b = at(1), c = at(2);
    builder.triangle(a, b, c, "mesh");
  }
  return builder.take("mesh");
}

std::size_t open_edges(const Triangles& mesh) {
  std::map<std::pair<int, int>, std::array<int, 2>> sides;  // by edge: along it, against it
  for (const Vector3i& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const int from = t[i], to = t[(i + 1) % 3];
      ++sides[std::minmax(from, to)][from < to ? 0 : 1];
    }
  }
  return static_cast<std::size_t>(std::count_if(sides.begin(), sides.end(), [](const auto& edge) {
    return edge.second[0] != 1 || edge.second[1] != 1;
  }));
}

bool turn_outwards(Triangles& mesh) {
  if (signed_volume(mesh) >= 0.0) return false;
  for (Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  return true;
}

std::vector<Triangles> components(const Triangles& mesh) {
  std::vector<int> root(mesh.points.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[static_cast<std::size_t>(i)] != i) {
      int& above = root[static_cast<std::size_t>(i)];
      above = root[static_cast<std::size_t>(above)];
      i = above;
    }
    return i;
  };
  for (const Vector3i& t : mesh.triangles) {
    root[static_cast<std::size_t>(find(t[1]))] = find(t[0]);
    root[static_cast<std::size_t>(find(t[2]))] = find(t[0]);
  }
  std::vector<Triangles> all;
  std::map<int, std::size_t> of_root;
  std::vector<int> number(mesh.points.size(), -1);
  for (const Vector3i& t : mesh.triangles) {
    const auto [found, is_new] = of_root.try_emplace(find(t[0]), all.size());
    if (is_new) all.emplace_back();
    Triangles& part = all[found->second];
    Vector3i corners;
    for (int i = 0; i < 3; ++i) {
      int& known = number[static_cast<std::size_t>(t[i])];
      if (known < 0) {
        known = static_cast<int>(part.points.size());
        part.points.push_back(mesh.points[static_cast<std::size_t>(t[i])]);
      }
      corners[i] = known;
    }
    part.triangles.push_back(corners);
  }
  return all;
}

Triangles hull_of(const Triangles& mesh, std::size_t most) {
  std::vector<Vector3d> corners = mesh.points;
  if (corners.size() > most) {
    // on a spiral round the sphere; what is outermost is a corner of the hull
    const double golden = M_PI * (3.0 - std::sqrt(5.0));
    std::vector<bool> chosen(mesh.points.size(), false);
    for (std::size_t i = 0; i < most; ++i) {
      const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(most);
      const double across = std::sqrt(1.0 - z * z), angle = golden * static_cast<double>(i);
      const Vector3d along(across * std::cos(angle), across * std::sin(angle), z);
      std::size_t best = 0;
      for (std::size_t j = 1; j < mesh.points.size(); ++j)
        if (along.dot(mesh.points[j]) > along.dot(mesh.points[best])) best = j;
      chosen[best] = true;
    }
    corners.clear();
    for (std::size_t j = 0; j < mesh.points.size(); ++j)
      if (chosen[j]) corners.push_back(mesh.points[j]);
  }
  std::vector<scene::Plane> faces;
  try {
    faces = scene::ConvexMesh(corners).faces();
  } catch (const std::invalid_argument& error) {
    throw Error(error.what());
  }
  double extent = 0.0;
  for (const Vector3d& corner : corners) extent = std::max(extent, (corner - corners[0]).norm());
  Triangles hull;
  std::vector<int> number(corners.size(), -1);
  for (const scene::Plane& face : faces) {
    std::vector<std::size_t> on;
    Vector3d middle = Vector3d::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (std::abs(face.normal.dot(corners[i]) - face.offset) > 1e-8 * extent) continue;
      on.push_back(i);
      middle += corners[i];
    }
    middle /= static_cast<double>(on.size());
    const Vector3d t = face.normal.unitOrthogonal(), s = face.normal.cross(t);
    const auto turn = [&](std::size_t i) {
      return std::atan2(s.dot(corners[i] - middle), t.dot(corners[i] - middle));
    };
    std::sort(on.begin(), on.end(), [&](auto a, auto b) { return turn(a) < turn(b); });
    // a polygon of the hull's corners: points on its sides or inside it are none
    for (bool again = true; again && on.size() > 3;) {
      again = false;
      for (std::size_t i = 0; i < on.size() && on.size() > 3; ++i) {
        const Vector3d &before = corners[on[(i + on.size() - 1) % on.size()]], &at = corners[on[i]],
                       &after = corners[on[(i + 1) % on.size()]];
        if (face.normal.dot((at - before).cross(after - at)) > 1e-10 * extent * extent) continue;
        on.erase(on.begin() + static_cast<std::ptrdiff_t>(i));
        again = true;
        break;
      }
    }
    std::vector<int> polygon;
    for (const std::size_t i : on) {
      if (number[i] < 0) {
        number[i] = static_cast<int>(hull.points.size());
        hull.points.push_back(corners[i]);
      }
      polygon.push_back(number[i]);
    }
    for (std::size_t i = 2; i < polygon.size(); ++i)
      hull.triangles.emplace_back(polygon[0], polygon[i - 1], polygon[i]);
  }
  return hull;
}

std::string to_obj(const Triangles& mesh) {
  std::string text;
  for (const Vector3d& p : mesh.points)
    text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
  for (const Vector3i& t : mesh.triangles)
    text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

}  // namespace c3rt::cli::mesh
