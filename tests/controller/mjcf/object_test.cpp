#include "controller/mjcf/object.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include <catch2/catch.hpp>
#include <mujoco/mujoco.h>

#include "controller/scene/object.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Catch::Contains;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const std::string kObjects = C3RT_SOURCE_DIRECTORY "/config/objects/";

/// A file with this in its world, and what else belongs beside it.
std::string file_with(const std::string& world, const std::string& beside = "") {
  static int count = 0;
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("c3rt_object_test_" + std::to_string(++count) + ".xml"))
                               .string();
  std::ofstream(path) << "<mujoco>" << beside << "<worldbody>" << world << "</worldbody></mujoco>";
  return path;
}

std::string free_body(const std::string& inside) {
  return "<body name=\"thing\"><freejoint name=\"free\"/>" + inside + "</body>";
}

const std::string kBox = R"(<geom name="block" type="box" size="0.05 0.03 0.02" mass="0.5"/>)";

std::string refusal(const std::string& file) {
  try {
    (void)mjcf::read_object(file);
  } catch (const mjcf::Error& e) {
    return e.what();
  }
  return "accepted";
}

bool notes(const mjcf::ObjectFile& read, const std::string& words) {
  return std::any_of(read.notes.begin(), read.notes.end(), [&](const std::string& note) {
    return note.find(words) != std::string::npos;
  });
}

}  // namespace

TEST_CASE("object: the shipped T is two boxes about their centre of mass") {
  const mjcf::ObjectFile read = mjcf::read_object(kObjects + "t.xml");
  const scene::Object& t = read.object;
  CHECK(t.name == "t");
  CHECK(t.mass == Approx(0.56));
  CHECK(t.friction == 0.4);
  REQUIRE(t.parts->parts.size() == 2);
  // the stem's share of the mass is 3 of 7, its middle 80 mm below that of the top
  CHECK(read.p_body_com.isApprox(Vector3d(0.0, -0.08 * 3.0 / 7.0, 0.0), 1e-12));
  CHECK(t.parts->parts[0].p_BP.isApprox(Vector3d(0.0, 0.08 * 3.0 / 7.0, 0.0), 1e-12));
  CHECK(t.parts->parts[1].p_BP.isApprox(Vector3d(0.0, -0.08 * 4.0 / 7.0, 0.0), 1e-12));
  // by Steiner: two even boxes, each 0.034 and 0.046 m off
  const double top = 0.32 / 12.0 * (0.16 * 0.16 + 0.04 * 0.04),
               stem = 0.24 / 12.0 * (0.12 * 0.12 + 0.04 * 0.04), off_top = 0.08 * 3.0 / 7.0,
               off_stem = 0.08 * 4.0 / 7.0;
  CHECK(t.inertia(2, 2) ==
        Approx(top + stem + 0.32 * off_top * off_top + 0.24 * off_stem * off_stem));
  CHECK(scene::nearest(t.shape(), {0.0, 0.1, 0.0}).distance == Approx(0.1 - off_top - 0.02));
  CHECK(notes(read, "centre of mass"));
}

TEST_CASE("object: mass, inertia and parts are MuJoCo's, whatever is turned and fixed to what") {
  const std::string file = file_with(
      "<geom name=\"floor\" type=\"plane\" size=\"1 1 1\"/>"
      "<body name=\"thing\" pos=\"0.3 0.2 0.1\" euler=\"20 30 40\"><freejoint/>"
      "<geom type=\"box\" size=\"0.05 0.03 0.02\" pos=\"0.01 0.02 0.03\" euler=\"10 0 50\" "
      "mass=\"0.5\"/>"
      "<geom name=\"picture\" type=\"sphere\" size=\"0.3\" contype=\"0\" conaffinity=\"0\" "
      "mass=\"0\"/>"
      "<body pos=\"0.1 0 0\" euler=\"0 70 0\"><geom type=\"capsule\" size=\"0.02 0.04\" "
      "mass=\"0.3\" friction=\"0.7 0 0\"/>"
      "<geom type=\"cylinder\" size=\"0.02 0.04\" pos=\"0 0.1 0\" mass=\"0.2\"/></body></body>");
  const mjcf::ObjectFile read = mjcf::read_object(file);
  CHECK(read.object.parts->parts.size() == 3);
  CHECK(read.object.friction == 1.0);
  CHECK(notes(read, "floor"));
  CHECK(notes(read, "picture"));
  CHECK(notes(read, "frictions from 0.7 to 1"));
  CHECK(notes(read, "degrees"));

  std::array<char, 1000> error{};
  const std::unique_ptr<mjModel, void (*)(mjModel*)> model(
      mj_loadXML(file.c_str(), nullptr, error.data(), 1000), mj_deleteModel);
  REQUIRE(model);
  const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(model.get()), mj_deleteData);
  mj_forward(model.get(), data.get());
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> M;
  mj_fullM(model.get(), M.data(), data->qM);
  // M of a free joint, in world and body axes, about the body's origin r from the centre of mass
  const double mass = read.object.mass;
  const Vector3d r = read.p_body_com;
  const Matrix3d about_origin =
      read.object.inertia + mass * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
  CHECK(M(0, 0) == Approx(mass));
  CHECK((M.bottomRightCorner<3, 3>() - about_origin).cwiseAbs().maxCoeff() < 1e-12);
  const Matrix3d R_WB = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9);
  const Vector3d p_WC = Eigen::Map<Vector3d>(data->xpos + 3) + R_WB * r;
  CHECK((p_WC - Eigen::Map<Vector3d>(data->subtree_com + 3)).norm() < 1e-12);
  for (std::size_t i = 0; i < 3; ++i) {
    const scene::Part& part = read.object.parts->parts[i];
    const std::size_t geom = i == 0 ? 1 : i + 2;
    CHECK((p_WC + R_WB * part.p_BP - Eigen::Map<Vector3d>(data->geom_xpos + 3 * geom)).norm() <
          1e-12);
    CHECK((R_WB * part.R_BP -
           Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->geom_xmat + 9 * geom))
              .norm() < 1e-12);
  }
}

TEST_CASE("object: a mesh counts as its convex hull") {
  // the corners of a box, its middle, and one on a face
  const mjcf::ObjectFile read = mjcf::read_object(file_with(
      free_body(R"(<geom name="hull" type="mesh" mesh="points" mass="0.4"/>)"),
      R"(<asset><mesh name="points" vertex="-0.05 -0.03 -0.02 0.05 -0.03 -0.02 -0.05 0.03 -0.02
        0.05 0.03 -0.02 -0.05 -0.03 0.02 0.05 -0.03 0.02 -0.05 0.03 0.02 0.05 0.03 0.02 0 0 0"/>
        </asset>)"));
  const scene::Shape shape = read.object.shape();
  const scene::Shape box = scene::Shape::box({0.05, 0.03, 0.02});
  REQUIRE(read.object.parts->meshes.size() == 1);
  CHECK(read.object.parts->meshes[0]->vertices().size() == 8);
  CHECK(notes(read, "convex hull"));
  support::Random random(1);
  for (int i = 0; i < 500; ++i) {
    const Vector3d p = 0.1 * random.vector(3);
    // single precision in the file
    REQUIRE(scene::nearest(shape, p).distance ==
            Approx(scene::nearest(box, p).distance).margin(1e-7));
  }
}

TEST_CASE("object: what nobody here can use is refused by its name and that of the file") {
  const auto refuses = [](const std::string& file, const std::string& what) {
    const std::string said = refusal(file);
    CAPTURE(said);
    CHECK(said.find(file) == 0);
    CHECK(said.find("expected") != std::string::npos);
    CHECK(said.find(what) != std::string::npos);
  };
  refuses("/nowhere/thing.xml", "thing.xml");
  refuses(file_with(free_body(kBox) + "<box"), "XML");
  refuses(file_with("<body name=\"still\">" + kBox + "</body>"), "none");
  refuses(file_with(free_body(kBox) + "<body name=\"other\"><freejoint/>" + kBox.substr(0, 6) +
                    "type=\"sphere\" size=\"0.1\"/></body>"),
          "\"thing\", \"other\"");
  refuses(file_with(free_body(kBox + "<body name=\"lid\"><joint name=\"hinge\"/>" +
                              "<geom type=\"sphere\" size=\"0.1\"/></body>")),
          "a hinge, the joint \"hinge\" of body \"lid\"");
  refuses(file_with("<body name=\"door\"><joint name=\"rail\" type=\"slide\"/>" + kBox + "</body>"),
          "a slide, the joint \"rail\"");
  refuses(file_with("<body name=\"thing\"><joint name=\"thick\" type=\"free\" damping=\"1\"/>" +
                    kBox + "</body>"),
          "damping of joint \"thick\"");
  refuses(
      file_with("<body name=\"thing\"><joint type=\"free\" armature=\"1\"/>" + kBox + "</body>"),
      "armature");
  refuses(file_with(free_body("<geom type=\"ellipsoid\" name=\"egg\" size=\"0.1 0.1 0.2\"/>")),
          "geom \"egg\", which is an ellipsoid");
  refuses(file_with(free_body("<geom type=\"hfield\" name=\"hill\" hfield=\"h\" mass=\"1\"/>"),
                    "<asset><hfield name=\"h\" nrow=\"2\" ncol=\"2\" size=\"1 1 1 1\"/></asset>"),
          "hill");
  refuses(file_with(free_body("<geom type=\"sphere\" size=\"0.1\" contype=\"0\" "
                              "conaffinity=\"0\"/>")),
          "at least one geom that collides");
  const std::string with_site = free_body(kBox + "<site name=\"s\"/>");
  refuses(file_with(with_site, "<equality><weld name=\"glue\" body1=\"thing\"/></equality>"),
          "the equality \"glue\"");
  refuses(file_with(with_site,
                    "<actuator><motor name=\"thruster\" joint=\"free\" gear=\"1\"/></actuator>"),
          "the actuator \"thruster\"");
  refuses(file_with(with_site + "<site name=\"w\"/>",
                    "<tendon><spatial name=\"rope\"><site site=\"s\"/><site site=\"w\"/></spatial>"
                    "</tendon>"),
          "the tendon \"rope\"");
}

TEST_CASE("object: a scale or a mass that is likely a mistake is told") {
  CHECK(notes(mjcf::read_object(file_with(free_body("<geom type=\"box\" size=\"50 30 20\"/>"))),
              "millimetres"));
  CHECK(notes(mjcf::read_object(file_with(free_body("<geom type=\"box\" size=\".05 .03 .02\"/>"))),
              "1000 kg/m3"));
  CHECK(mjcf::read_object(file_with(free_body(kBox))).notes.empty());
}

TEST_CASE("reach: the farthest that any of many points is, along any direction") {
  const scene::Object t = mjcf::read_object(kObjects + "t.xml").object;
  CHECK(scene::reach(t.shape(), Vector3d::UnitX()) == Approx(0.08));
  CHECK(scene::reach(t.shape(), -Vector3d::UnitY()) == Approx(0.08 * 4.0 / 7.0 + 0.06));
  support::Random random(2);
  for (const scene::Shape& shape :
       {scene::Shape::sphere(0.03), scene::Shape::box({0.05, 0.03, 0.02}),
        scene::Shape::capsule(0.02, 0.05), scene::Shape::cylinder(0.03, 0.04), t.shape()}) {
    for (int i = 0; i < 20; ++i) {
      const Vector3d way = random.vector(3).normalized();
      const double far = scene::reach(shape, way);
      // a plane at that distance touches it: no point beyond is inside, and some near it is
      double most = -1.0;
      for (int j = 0; j < 20000; ++j) {
        const Vector3d p = 0.15 * random.vector(3);
        if (scene::nearest(shape, p).distance < 0.0) most = std::max(most, way.dot(p));
      }
      CHECK(most <= far);
      CHECK(most > far - 0.02);
    }
  }
}

TEST_CASE("object: sites called tag36h11_ID are its tags, seen from the centre of mass") {
  const mjcf::ObjectFile read = mjcf::read_object(kObjects + "t.xml");
  REQUIRE(read.object.tags.size() == 7);
  const scene::Tag& first = read.object.tags[0];
  CHECK(first.id == 0);
  CHECK(first.size == Approx(0.032));
  CHECK(first.p_BT.isApprox(Vector3d(-0.06, 0.0, 0.02) - read.p_body_com, 1e-12));
  CHECK(first.R_BT.isApprox(Matrix3d::Identity(), 1e-12));
  // of another size the tags are larger, too
  const scene::Object larger = scene::scaled(read.object, 1.0, 1.1);
  CHECK(larger.tags[0].size == Approx(0.0352));
  CHECK(larger.tags[0].p_BT.isApprox(1.1 * first.p_BT, 1e-12));

  // turned with what it is fixed to; other sites are nothing
  const mjcf::ObjectFile turned = mjcf::read_object(file_with(free_body(
      kBox +
      R"(<body pos="0.05 0 0" quat="0.5 0.5 0.5 0.5"><geom type="sphere" size="0.001" mass="0"/>
        <site name="tag36h11_586" type="box" size="0.01 0.01 0.001"/></body>
        <site name="target" pos="0 0 1"/><site name="tag" pos="0 0 1"/>)")));
  REQUIRE(turned.object.tags.size() == 1);
  CHECK(turned.object.tags[0].id == 586);
  // (0.5, 0.5, 0.5, 0.5) turns z into x and x into y
  CHECK(turned.object.tags[0].R_BT.col(2).isApprox(Vector3d::UnitX(), 1e-12));
  CHECK(turned.object.tags[0].R_BT.col(0).isApprox(Vector3d::UnitY(), 1e-12));
}

TEST_CASE("object: a tag that nobody could see as the file says is refused by name") {
  const auto with = [](const std::string& site) { return file_with(free_body(kBox + site)); };
  for (const char* name :
       {"tag36h11_587", "tag36h11_07", "tag36h11_", "tag25h9_1", "tag36h11_1x"}) {
    CAPTURE(name);
    const std::string said = refusal(
        with("<site name=\"" + std::string(name) + "\" type=\"box\" size=\"0.01 0.01 0.001\"/>"));
    CHECK_THAT(said, Contains("tags called tag36h11_0 to tag36h11_586") && Contains(name));
  }
  CHECK_THAT(refusal(with(R"(<site name="tag36h11_1" type="box" size="0.01 0.02 0.001"/>)")),
             Contains("a tag as a square") && Contains("tag36h11_1") && Contains("20 x 40 mm"));
  CHECK_THAT(refusal(with(R"(<site name="tag36h11_1" size="0.01"/>)")), Contains("no box"));
  // MuJoCo itself refuses one name twice
  CHECK_THAT(refusal(with(R"(<site name="tag36h11_1" type="box" size="0.01 0.01 0.001"/>
    <site name="tag36h11_1" type="box" size="0.01 0.01 0.001" pos="0.02 0 0"/>)")),
             Contains("tag36h11_1"));
  const mjcf::ObjectFile read = mjcf::read_object(file_with(
      free_body(kBox) + R"(<site name="tag36h11_1" type="box" size="0.01 0.01 0.001"/>)"));
  CHECK(read.object.tags.empty());
  CHECK(notes(read, "tag36h11_1"));
}

TEST_CASE("mjcf: the shipped objects' tags lie on their tops with their borders, each id once") {
  std::vector<int> ids;
  for (const auto& [name, count] :
       {std::pair<const char*, std::size_t>{"t", 7}, {"box", 4}, {"l", 6}, {"h", 7}, {"e", 4}}) {
    CAPTURE(name);
    const scene::Object object = mjcf::read_object(kObjects + name + ".xml").object;
    REQUIRE(object.tags.size() == count);
    const double top = scene::reach(object.shape(), Vector3d::UnitZ());
    for (std::size_t i = 0; i < count; ++i) {
      const scene::Tag& tag = object.tags[i];
      CAPTURE(tag.id);
      CHECK(std::find(ids.begin(), ids.end(), tag.id) == ids.end());
      ids.push_back(tag.id);
      CHECK(tag.p_BT.z() == Approx(top).margin(1e-9));
      CHECK((tag.R_BT - Matrix3d::Identity()).norm() < 1e-9);
      const double half = 0.625 * tag.size;  // with the white border
      for (const double x : {-half, 0.0, half}) {
        for (const double y : {-half, 0.0, half}) {
          const scene::Nearest at = scene::nearest(object.shape(), tag.p_BT + Vector3d(x, y, 0.0));
          CHECK(std::abs(at.distance) < 1e-8);
        }
      }
      for (std::size_t other = 0; other < i; ++other) {
        const Vector3d apart = tag.p_BT - object.tags[other].p_BT;
        CHECK(apart.head<2>().lpNorm<Eigen::Infinity>() > 2.0 * half - 1e-9);
      }
    }
  }
}
