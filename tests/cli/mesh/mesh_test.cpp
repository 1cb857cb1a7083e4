#include "cli/mesh/mesh.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

namespace {

using namespace c3rt::cli::mesh;
using Catch::Contains;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Half sizes 1, 2, 3 about (10, 20, 30), by polygons with slashes and numbers from the end.
const std::string kBox = R"(# a box
o box
v 9 18 27
v 11 18 27
v 11 22 27
v 9 22 27
v 9 18 33
v 11 18 33
v 11 22 33
v 9 22 33
vn 0 0 1
f 4//1 3//1 2//1 1//1
f -4 -3 -2 -1
f 1/1 2/2 6/3 5/4
f 2/1/1 3/1/1 7/1/1 6/1/1
f 3 4 8 7
f 4 1 5 8
)";

std::string sphere(double radius, int rings, int sectors) {
  std::string text;
  const auto v = [&](double z, double r, double angle) {
    text += "v " + std::to_string(r * std::cos(angle)) + " " + std::to_string(r * std::sin(angle)) +
            " " + std::to_string(z) + "\n";
  };
  v(-radius, 0.0, 0.0);
  for (int ring = 1; ring < rings; ++ring)
    for (int i = 0; i < sectors; ++i)
      v(-radius * std::cos(M_PI * ring / rings), radius * std::sin(M_PI * ring / rings),
        2.0 * M_PI * i / sectors);
  v(radius, 0.0, 0.0);
  const auto at = [&](int ring, int i) {
    return std::to_string(2 + (ring - 1) * sectors + i % sectors) + " ";
  };
  const std::string top = std::to_string(2 + (rings - 1) * sectors);
  for (int i = 0; i < sectors; ++i) {
    text += "f 1 " + at(1, i + 1) + at(1, i) + "\n";
    for (int ring = 1; ring + 1 < rings; ++ring)
      text += "f " + at(ring, i) + at(ring, i + 1) + at(ring + 1, i + 1) + at(ring + 1, i) + "\n";
    text += "f " + at(rings - 1, i) + at(rings - 1, i + 1) + top + "\n";
  }
  return text;
}

std::string facet(const Triangles& mesh, std::size_t i) {
  std::string text = "facet normal 0 0 0\nouter loop\n";
  for (const int corner : mesh.triangles[i]) {
    const Vector3d& p = mesh.points[static_cast<std::size_t>(corner)];
    text += "vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
            std::to_string(p.z()) + "\n";
  }
  return text + "endloop\nendfacet\n";
}

std::string ascii_stl(const Triangles& mesh) {
  std::string text = "solid a\n";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) text += facet(mesh, i);
  return text + "endsolid a\n";
}

std::string binary_stl(const Triangles& mesh) {
  // the head may begin like that of a text
  std::string text = "solid" + std::string(75, ' ') + std::string(4, '\0');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(&text[80], &count, sizeof count);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    float values[12] = {};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        values[3 + 3 * i + k] = static_cast<float>(mesh.points[static_cast<std::size_t>(t[i])][k]);
    text.append(reinterpret_cast<const char*>(values), sizeof values);
    text.append(2, '\0');
  }
  return text;
}

}  // namespace

TEST_CASE(
    "mesh: a box has the volume, centre and inertia of the closed form, far from the origin") {
  const Triangles box = parse(kBox, "box.obj");
  CHECK(box.triangles.size() == 12);
  CHECK(open_edges(box) == 0);
  const Solid solid = solid_of(box);
  CHECK(solid.volume == Approx(48.0).epsilon(1e-12));
  CHECK((solid.com - Vector3d(10, 20, 30)).norm() < 1e-12);
  const Matrix3d expected = Vector3d(16 + 36, 4 + 36, 4 + 16).asDiagonal();
  CHECK((12.0 * solid.inertia - expected).norm() < 1e-10);
}

TEST_CASE("mesh: a fine sphere has the volume and inertia of the ball") {
  const double r = 0.05;
  const Solid solid = solid_of(parse(sphere(r, 60, 120), "s.obj"));
  CHECK(solid.volume == Approx(4.0 / 3.0 * M_PI * r * r * r).epsilon(2e-3));
  CHECK((solid.inertia / (0.4 * r * r) - Matrix3d::Identity()).norm() < 5e-3);
}

TEST_CASE("mesh: STL of either kind is the mesh of the same OBJ") {
  const Triangles box = parse(kBox, "box.obj");
  for (const std::string& text : {ascii_stl(box), binary_stl(box)}) {
    const Triangles read = parse(text, "BOX.STL");
    CHECK(read.points.size() == 8);
    CHECK(open_edges(read) == 0);
    CHECK(solid_of(read).volume == Approx(48.0));
    CHECK((solid_of(read).inertia - solid_of(box).inertia).norm() < 1e-9);
  }
}

TEST_CASE("mesh: a surface that is inside out is turned, one with a hole is known") {
  Triangles box = parse(kBox, "box.obj");
  CHECK_FALSE(turn_outwards(box));
  for (Eigen::Vector3i& t : box.triangles) std::swap(t[0], t[1]);
  CHECK_THROWS_AS(solid_of(box), Error);
  CHECK(turn_outwards(box));
  CHECK(solid_of(box).volume == Approx(48.0));
  box.triangles.pop_back();
  CHECK(open_edges(box) == 3);
}

TEST_CASE("mesh: what does not hang together is apart, and keeps all its triangles") {
  Triangles two = parse(kBox, "box.obj");
  const Triangles one = two;
  for (const Vector3d& point : one.points) two.points.push_back(point + Vector3d(5, 0, 0));
  for (const Eigen::Vector3i& t : one.triangles) two.triangles.emplace_back(t.array() + 8);
  const std::vector<Triangles> parts = components(two);
  REQUIRE(parts.size() == 2);
  CHECK((solid_of(parts[0]).com - Vector3d(10, 20, 30)).norm() < 1e-12);
  CHECK((solid_of(parts[1]).com - Vector3d(15, 20, 30)).norm() < 1e-12);
}

TEST_CASE("mesh: the hull is closed, convex and holds every point; corners within it are none") {
  Triangles mesh = parse(kBox, "box.obj");
  mesh.points.emplace_back(10, 20, 30);  // inside
  mesh.points.emplace_back(10, 20, 33);  // in the middle of a face
  mesh.points.emplace_back(11, 20, 33);  // in the middle of an edge
  const Triangles hull = hull_of(mesh, 100);
  CHECK(hull.points.size() == 8);
  CHECK(open_edges(hull) == 0);
  CHECK(solid_of(hull).volume == Approx(48.0).epsilon(1e-12));
}

TEST_CASE("mesh: of many corners the hull is one with fewer, inside and hardly smaller") {
  const double r = 0.05;
  const Triangles ball = parse(sphere(r, 40, 80), "s.obj");
  const Triangles hull = hull_of(ball, 150);
  CHECK(hull.points.size() <= 150);
  CHECK(open_edges(hull) == 0);
  const double of_ball = solid_of(ball).volume, of_hull = solid_of(hull).volume;
  CHECK(of_hull < of_ball);
  CHECK(of_hull > 0.93 * of_ball);
  // along every direction it reaches as far, or up to 3 % less
  for (const Vector3d& along : ball.points) {
    double reach = 0.0;
    for (const Vector3d& corner : hull.points)
      reach = std::max(reach, corner.dot(along.normalized()));
    CHECK(reach <= r + 1e-6);
    CHECK(reach > 0.97 * r);
  }
}

TEST_CASE("mesh: a mistake is named with file and line") {
  const auto [text, file, expected] = GENERATE(table<std::string, std::string, std::string>({
      {"v 0 0 0\nv 1 0\n", "a.obj", "a.obj:2: expected three coordinates"},
      {"v 0 0 nan\n", "a.obj", "a.obj:1: expected a coordinate"},
      {"v 0 0 1x\n", "a.obj", "a.obj:1: expected a coordinate"},
      {"v 0 0 0\nf 1 2 3\n", "a.obj", "a.obj:2: expected the number of one of the 1 points"},
      {"v 0 0 0\nf 0 1 1\n", "a.obj", "a.obj:2: expected the number"},
      {"v 0 0 0\nf 1 1\n", "a.obj", "a.obj:2: expected three corners"},
      {"", "a.obj", "a.obj: expected a mesh of at least 4 triangles, got 0"},
      {"solid a\nvertex 0 0\n", "a.stl", "a.stl:2: expected three coordinates"},
      {"solid a\nvertex 0 0 0\nendfacet\n", "a.stl", "a.stl:3: expected three vertices"},
      {"solid a\nnonsense\n", "a.stl", "a.stl:2: expected a word of ASCII STL"},
      {"PK something else", "a.stl", "a.stl: expected binary STL"},
      {"ply\n", "a.ply", "expected a file that ends with .obj or .stl, got .ply"},
  }));
  CHECK_THROWS_WITH(parse(text, file), Contains(expected));
}

TEST_CASE("mesh: half a binary STL is no STL") {
  const std::string whole = binary_stl(parse(kBox, "box.obj"));
  std::string head = whole;
  head.replace(0, 5, "other");
  CHECK_THROWS_WITH(parse(head.substr(0, head.size() - 10), "a.stl"), Contains("84 bytes, and 50"));
}
