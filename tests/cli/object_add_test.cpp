// c3rt object add as a person meets it.
#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>

#include "cli/mesh/mesh.hpp"
#include "controller/mjcf/object.hpp"
#include "tests/cli/folder.hpp"
#include "tests/support/outcome.hpp"

namespace {

using namespace c3rt;
using c3rt::support::Outcome;
using Catch::Contains;
using Eigen::Vector3d;
namespace fs = std::filesystem;

Outcome run(const std::string& arguments) {
  return support::outcome_of("'" C3RT_BINARY_DIRECTORY "/bin/c3rt' " + arguments);
}

/// A block from `low` to `high` as one part of an OBJ that has `before` points.
std::string block(const Vector3d& low, const Vector3d& high, int before = 0) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += "v " + std::to_string((i & 1) != 0 ? high.x() : low.x()) + " " +
            std::to_string((i & 2) != 0 ? high.y() : low.y()) + " " +
            std::to_string((i & 4) != 0 ? high.z() : low.z()) + "\n";
  }
  const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& face : faces) {
    text += "f";
    for (const int corner : face) text += " " + std::to_string(before + corner + 1);
    text += "\n";
  }
  return text;
}

/// An L from (0, 0): 120 mm along x, 100 mm along y, 40 mm wide and high; one surface.
std::string l_of_one_part() {
  const double at[6][2] = {{0, 0}, {0.12, 0}, {0.12, 0.04}, {0.04, 0.04}, {0.04, 0.1}, {0, 0.1}};
  std::string text;
  for (const char* z : {"0", "0.04"})
    for (const auto& p : at)
      text += "v " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + z + "\n";
  // two quadrilaterals below and above each; triangles fan out from the hollow's corner
  text += "f 4 3 2 1\nf 4 1 6 5\nf 10 7 8 9\nf 10 11 12 7\n";
  for (int i = 0; i < 6; ++i) {
    const int next = (i + 1) % 6;
    text += "f " + std::to_string(i + 1) + " " + std::to_string(next + 1) + " " +
            std::to_string(next + 7) + " " + std::to_string(i + 7) + "\n";
  }
  return text;
}

struct Place {
  explicit Place(const std::string& text, const std::string& name = "part.obj") {
    file = folder.path() / name;
    std::ofstream(file) << text;
  }
  Outcome draw(const std::string& more) const {
    return run("object add '" + file.string() + "' --out '" + folder.path().string() + "' " + more);
  }
  Outcome add(const std::string& more) const { return draw(more + " --no-picture"); }
  mjcf::ObjectFile object(const std::string& name) const {
    return mjcf::read_object((folder.path() / (name + ".xml")).string());
  }
  cli::Folder folder;
  fs::path file;
};

/// Of an L in two pieces, beside the same as one part.
void check_l(const mjcf::ObjectFile& two, const mjcf::ObjectFile& whole) {
  CHECK((two.p_body_com - whole.p_body_com).norm() < 1e-8);
  CHECK((two.object.inertia - whole.object.inertia).norm() < 1e-9);
  // a point in the hollow is outside
  const Vector3d hollow = Vector3d(0.08, 0.07, 0.02) - two.p_body_com;
  CHECK(scene::nearest(two.object.shape(), hollow).distance == Approx(0.03).margin(1e-6));
}

}  // namespace

TEST_CASE("object add: a block becomes an object of the mass, inertia and friction it has") {
  const Place place(block({0, 0, 0}, {0.1, 0.06, 0.04}));
  const Outcome outcome = place.add("--mass 0.5 --friction 0.3");
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("part: 100 x 60 x 40 mm, volume 240 cm3, mass 0.5 kg") &&
                                 Contains("centre of mass 50 30 20 mm") &&
                                 Contains("convex, 8 corners") && Contains("c3rt lcs inspect"));
  const mjcf::ObjectFile file = place.object("part");
  const scene::Object& object = file.object;
  CHECK(object.mass == Approx(0.5));
  CHECK(object.friction == Approx(0.3));
  const Eigen::Matrix3d expected =
      (0.5 / 12.0 * Vector3d(0.0036 + 0.0016, 0.01 + 0.0016, 0.01 + 0.0036)).asDiagonal();
  CHECK((object.inertia - expected).norm() < 1e-9);
  CHECK((file.p_body_com - Vector3d(0.05, 0.03, 0.02)).norm() < 1e-9);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d along = Vector3d::Unit(axis);
    CHECK(scene::reach(object.shape(), along) == Approx(file.p_body_com[axis]).margin(1e-7));
  }
  CHECK(run("lcs inspect '" + (place.folder.path() / "part.xml").string() + "'").status == 0);
}

TEST_CASE("object add: of a convex mesh MuJoCo alone computes the same centre and inertia") {
  // a wedge that stands askew
  const Place place(
      "v 0 0 0\nv 0.1 0.01 0\nv 0.02 0.08 0.01\nv 0.03 0.02 0.06\nv 0.07 0.05 0.05\n"
      "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 5 4\nf 2 3 5\nf 3 4 5\n");
  REQUIRE(place.add("--mass 0.4").status == 0);
  const mjcf::ObjectFile ours = place.object("part");
  std::ofstream(place.folder.path() / "alone.xml")
      << "<mujoco><asset><mesh name='m' file='part_1.obj'/></asset><worldbody><body name='m'>"
         "<freejoint/><geom type='mesh' mesh='m' mass='0.4'/></body></worldbody></mujoco>";
  const mjcf::ObjectFile alone = place.object("alone");
  CHECK((ours.p_body_com - alone.p_body_com).norm() < 1e-7);
  CHECK((ours.object.inertia - alone.object.inertia).norm() < 1e-5 * alone.object.inertia.norm());
}

TEST_CASE("object add: a hollow that the hull fills is named with what it fills") {
  const Place place(l_of_one_part());
  const Outcome outcome = place.add("--mass 0.4 --name l");
  CHECK(outcome.status == 0);
  // areas: 7200 mm2 of the L, 9600 of the hull
  CHECK_THAT(outcome.output, Contains("volume 288 cm3") &&
                                 Contains("33.3 % more volume than it: hollows are filled") &&
                                 Contains("--decompose") &&
                                 Contains("separate closed convex parts"));
  // the centre of mass is the L's all the same: of 4800 mm2 about (60, 20) and 2400 about (20, 70)
  CHECK((place.object("l").p_body_com - Vector3d(0.14, 0.11, 0.06) / 3.0).norm() < 1e-6);
}

TEST_CASE("object add: the objects of a file are convex pieces, with the inertia of the whole") {
  const Place place(block({0, 0, 0}, {0.12, 0.04, 0.04}) + "o second\n" +
                    block({0, 0.04, 0}, {0.04, 0.1, 0.04}, 8)),
      whole(l_of_one_part());
  const Outcome outcome = place.add("--mass 0.4 --name l");
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("l_1.obj: convex, 8 corners") &&
                                 Contains("l_2.obj: convex, 8 corners") && !Contains("hollows"));
  REQUIRE(whole.add("--mass 0.4 --name l").status == 0);
  const mjcf::ObjectFile two = place.object("l"), one = whole.object("l");
  CHECK(two.object.parts->parts.size() == 2);
  check_l(two, one);
  CHECK(run("lcs inspect '" + (place.folder.path() / "l.xml").string() + "'").status == 0);
}

TEST_CASE("object add: millimetres, an open surface and one inside out are met with advice") {
  const Place large(block({0, 0, 0}, {100, 60, 40}));
  const Outcome refused = large.add("--mass 0.5");
  CHECK(refused.status == 2);
  CHECK_THAT(refused.output, Contains("got 100 m") && Contains("--scale 0.001"));
  CHECK(large.add("--mass 0.5 --scale 0.001").status == 0);

  const Place small(block({0, 0, 0}, {0.001, 0.001, 0.001}));
  CHECK_THAT(small.add("--mass 0.5").output, Contains("at least 5 mm, got 1 mm"));

  std::string open = block({0, 0, 0}, {0.1, 0.06, 0.04});
  const Place hole(open.substr(0, open.rfind('f')));
  const Outcome closed = hole.add("--mass 0.5");
  CHECK(closed.status == 0);
  CHECK_THAT(closed.output, Contains("not closed (4 edges") && Contains("volume 240 cm3"));
}

TEST_CASE("object add: groups that are patches of one surface are one piece") {
  const std::string closed = block({0, 0, 0}, {0.1, 0.06, 0.04});
  std::string patches = closed;
  // the last face has points of its own
  patches.insert(patches.rfind('f'),
                 "g last\nv 0.1 0 0\nv 0.1 0.06 0\nv 0.1 0.06 0.04\nv 0.1 0 0.04\n");
  patches.replace(patches.rfind('f'), std::string::npos, "f -4 -3 -2 -1\n");
  const Place place(patches);
  const Outcome outcome = place.add("--mass 0.5");
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("part_1.obj: convex, 8 corners") && !Contains("part_2") &&
                                 !Contains("not closed"));
}

TEST_CASE("object add: nothing is overwritten without --force") {
  const Place place(block({0, 0, 0}, {0.1, 0.06, 0.04}));
  REQUIRE(place.add("--mass 0.5").status == 0);
  const Outcome again = place.add("--mass 0.7");
  CHECK(again.status == 2);
  CHECK_THAT(again.output, Contains("part.xml: expected no such file") && Contains("--force"));
  CHECK(place.object("part").object.mass == Approx(0.5));
  CHECK(place.add("--mass 0.7 --force").status == 0);
  CHECK(place.object("part").object.mass == Approx(0.7));
}

TEST_CASE("object add: a wrong call is status 2 and writes nothing") {
  const Place place(block({0, 0, 0}, {0.1, 0.06, 0.04}));
  for (const char* wrong : {"", "--mass 0", "--mass 0.5 --name '../x'", "--mass 0.5 --name 'a b'",
                            "--mass 0.5 --scale 0", "--mass 0.5 --friction -1"}) {
    INFO(wrong);
    CHECK(place.add(wrong).status == 2);
  }
  CHECK_FALSE(fs::exists(place.folder.path() / "part.xml"));
  CHECK(run("object add not_there.obj --mass 1").status == 2);
  CHECK(run("object add --help").status == 0);
}

namespace {
/// A program in the place of CoACD that does this with $in and $out.
struct Decomposer {
  explicit Decomposer(const std::string& does) {
    const fs::path file = folder.path() / "coacd";
    std::ofstream(file) << "#!/bin/sh\nin=$2; out=$4\n" << does << "\n";
    fs::permissions(file, fs::perms::owner_all);
  }
  std::string first() const { return "PATH='" + folder.path().string() + "':\"$PATH\" "; }
  cli::Folder folder;
};

Outcome add_with(const std::string& first, const Place& place, const std::string& more) {
  return support::outcome_of(first + "'" C3RT_BINARY_DIRECTORY "/bin/c3rt' object add '" +
                             place.file.string() + "' --out '" + place.folder.path().string() +
                             "' " + more);
}
}  // namespace

TEST_CASE(
    "object add: --decompose divides what is hollow by CoACD, with the inertia of the whole") {
  const Place place(l_of_one_part());
  const cli::Folder made;
  std::ofstream(made.path() / "made.obj")
      << "o geometry_0\n"
      << block({0, 0, 0}, {0.12, 0.04, 0.04}) << "o geometry_1\n"
      << block({0, 0.04, 0}, {0.04, 0.1, 0.04}, 8);
  // it gets the mesh of the file, and what it makes of it is taken
  const Decomposer coacd("grep -c '^v' \"$in\" > '" + (made.path() / "points").string() +
                         "'; cp '" + (made.path() / "made.obj").string() + "' \"$out\"");
  REQUIRE(place.add("--mass 0.4 --name whole").status == 0);
  const Outcome outcome = add_with(coacd.first(), place, "--mass 0.4 --name l --decompose");
  INFO(outcome.output);
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("l_1.obj: convex, 8 corners") &&
                                 Contains("l_2.obj: convex, 8 corners") && !Contains("hollows"));
  int points = 0;
  std::ifstream(made.path() / "points") >> points;
  CHECK(points == 12);
  const mjcf::ObjectFile two = place.object("l"), whole = place.object("whole");
  REQUIRE(two.object.parts->parts.size() == 2);
  check_l(two, whole);
}

TEST_CASE("object add: what is convex already is not divided") {
  const Place place(block({0, 0, 0}, {0.1, 0.06, 0.04}));
  CHECK(add_with(Decomposer("exit 1").first(), place, "--mass 0.4 --decompose").status == 0);
}

TEST_CASE("object add: without CoACD, or where it fails, --decompose says what to do") {
  const Place place(l_of_one_part());
  const Outcome missing = add_with("C3RT_PYTHON=/bin/false ", place, "--mass 0.4 --decompose");
  CHECK(missing.status == 2);
  CHECK_THAT(missing.output, Contains("which is not in PATH: pip install coacd trimesh") &&
                                 Contains("separate closed convex parts"));
  const Outcome failed =
      add_with(Decomposer("echo 'no manifold'; exit 3").first(), place, "--mass 0.4 --decompose");
  CHECK(failed.status == 2);
  CHECK_THAT(failed.output, Contains("exited with status 3: no manifold"));
  const Outcome nothing = add_with(Decomposer("exit 0").first(), place, "--mass 0.4 --decompose");
  CHECK(nothing.status == 2);
  CHECK_THAT(nothing.output, Contains("got a file that is none"));
  CHECK_FALSE(fs::exists(place.folder.path() / "part.xml"));
}

TEST_CASE("object add: tags lie on its top, and are what cameras look for") {
  const Place place(block({0.1, 0, 0}, {0.22, 0.045, 0.04}));
  const Outcome outcome = place.add("--mass 0.4 --tags 584 --tag-size 0.032");
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("3 tags of 32 mm on its top: tag36h11_584 to 586"));
  const mjcf::ObjectFile file = place.object("part");
  REQUIRE(file.object.tags.size() == 3);
  for (int i = 0; i < 3; ++i) {
    const scene::Tag& tag = file.object.tags[static_cast<std::size_t>(i)];
    CHECK(tag.id == 584 + i);
    CHECK(tag.size == Approx(0.032));
    // 40 mm with their borders: side by side along x, the middle one over the block's
    CHECK((file.p_body_com + tag.p_BT - Vector3d(0.12 + 0.04 * i, 0.0225, 0.04)).norm() < 1e-6);
    CHECK((tag.R_BT - Eigen::Matrix3d::Identity()).norm() < 1e-9);
  }
  const Outcome small = place.add("--mass 0.4 --tags 0 --tag-size 0.04 --force");
  CHECK(small.status == 2);
  CHECK_THAT(small.output, Contains("--tags: expected a flat place of 50 x 50 mm"));
  for (const char* wrong : {"--tags -1", "--tags 587", "--tags 0 --tag-size 0"})
    CHECK(place.add(std::string("--mass 0.4 --force ") + wrong).status == 2);
}

TEST_CASE("object add: it draws the object, and says why where it cannot") {
  const Place place(block({0, 0, 0}, {0.1, 0.06, 0.04}));
  const fs::path picture = place.folder.path() / "part.png";
  REQUIRE(place.add("--mass 0.5").status == 0);
  CHECK_FALSE(fs::exists(picture));
  const Outcome without = add_with("C3RT_PYTHON=/bin/false ", place, "--mass 0.5 --force");
  CHECK(without.status == 0);
  CHECK_THAT(without.output, Contains("no part.png: no Python with the package matplotlib"));
  const Outcome drawn = place.draw("--mass 0.5 --force");
  CHECK(drawn.status == 0);
  // a block has four sides to push on, the widest two of 100 x 40 mm
  CHECK_THAT(drawn.output, Contains("to push on: faces of 4 directions, widest") &&
                               Contains("(0, -1, 0) 40 cm2") && Contains("(1, 0, 0) 24 cm2"));
  std::ifstream file(picture, std::ios::binary);
  std::string head(8, ' ');
  file.read(head.data(), 8);
  CHECK(head.substr(1, 3) == "PNG");
  CHECK(fs::file_size(picture) > 2000);
}
