#include "plant_emulator/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

#include <Eigen/Eigenvalues>

#include "plant_emulator/box_collision.hpp"

namespace c3rt::plant {
namespace {

struct Inertia {
  double xx, xy, xz, yy, yz, zz;
};

/// One moving link: where its joint sits in the parent, how the parent's frame turns about x, mass
/// properties.
struct Link {
  std::array<double, 3> origin;  // of the joint in the parent's frame [m]
  int quarter_turns_x;  // rotation of the joint's frame about the parent's x, in quarter turns
  double mass;          // [kg]
  std::array<double, 3> center;  // of mass, in the link's frame [m]
  Inertia inertia;               // about the centre of mass, in the link's axes [kg m^2]
};

// Source: panda.urdf of example-robot-data in Pinocchio's source release 3.4.0; the test compares
// both.
constexpr std::array<Link, kJoints> kLinks{{
    {{0, 0, 0.333},
     0,
     4.970684,
     {0.003875, 0.002081, -0.04762},
     {0.70337, -0.000139, 0.006772, 0.70661, 0.019169, 0.009117}},
    {{0, 0, 0},
     -1,
     0.646926,
     {-0.003141, -0.02872, 0.003495},
     {0.007962, -0.003925, 0.010254, 0.02811, 0.000704, 0.025995}},
    {{0, -0.316, 0},
     1,
     3.228604,
     {0.027518, 0.039252, -0.066502},
     {0.037242, -0.004761, -0.011396, 0.036155, -0.012805, 0.01083}},
    {{0.0825, 0, 0},
     1,
     3.587895,
     {-0.05317, 0.104419, 0.027454},
     {0.025853, 0.007796, -0.001332, 0.019552, 0.008641, 0.028323}},
    {{-0.0825, 0.384, 0},
     -1,
     1.225946,
     {-0.011953, 0.041065, -0.038437},
     {0.035549, -0.002117, -0.004037, 0.029474, 0.000229, 0.008627}},
    {{0, 0, 0},
     1,
     1.666555,
     {0.060149, -0.014117, -0.010517},
     {0.001964, 0.000109, -0.001158, 0.004354, 0.000341, 0.005433}},
    {{0.088, 0, 0},
     1,
     0.735522,
     {0.010517, -0.004252, 0.061597},
     {0.012516, -0.000428, -0.001196, 0.010027, -0.000741, 0.004815}},
}};
constexpr double kJointDamping = 0.003;  // same source [N m s/rad]

constexpr double kFlangeOffset = 0.107;  // along z of link 7 [m]

// Contacts as stiff as the step allows: 2 ms lets a sphere sink 0.04 mm under its weight.
constexpr const char* kContactStiffness = R"(solref="0.002 1" solimp="0.9 0.95 0.001 0.5 2")";

constexpr double kTagThickness = 2e-5;  // half of it [m]
constexpr int kPixelsPerCell = 16;      // of a tag's texture

// The arm's looks: capsules along its links, {link (0 = base), from, to, radius} in the link's
// frame [m].
struct Capsule {
  int link;
  std::array<double, 3> from, to;
  double radius;
};
constexpr std::array<Capsule, 13> kCapsules{{
    {0, {-0.08, 0, 0.06}, {0, 0, 0.06}, 0.06},
    {0, {0, 0, 0.06}, {0, 0, 0.14}, 0.07},
    {1, {0, 0, -0.19}, {0, 0, -0.05}, 0.06},
    {1, {0, -0.06, 0}, {0, 0.06, 0}, 0.06},
    {2, {0, -0.06, 0}, {0, -0.19, 0}, 0.06},
    {3, {0, 0, -0.12}, {0, 0, -0.03}, 0.058},
    {3, {0.0825, -0.05, 0}, {0.0825, 0.05, 0}, 0.055},
    {4, {-0.0825, 0.06, 0}, {-0.0825, 0.13, 0}, 0.055},
    {5, {0, 0, -0.26}, {0, 0.07, -0.2}, 0.05},
    {5, {0, 0.07, -0.2}, {0, 0.02, -0.02}, 0.04},
    {6, {0, 0, -0.03}, {0, 0, 0.03}, 0.05},
    {6, {0.088, 0, 0}, {0.088, -0.05, 0}, 0.045},
    {7, {0, 0, 0.03}, {0, 0, 0.085}, 0.042},
}};

void require(bool condition, const std::string& what) {
  if (!condition) throw std::invalid_argument("scene: " + what);
}

template <typename T>
std::string join(const T& numbers) {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10);
  for (const double number : numbers) text << (text.tellp() > 0 ? " " : "") << number;
  return text.str();
}
std::string join(const Eigen::Vector3d& v) {
  return join(std::array<double, 3>{v.x(), v.y(), v.z()});
}
std::string join(const Eigen::Quaterniond& q) {
  return join(std::array<double, 4>{q.w(), q.x(), q.y(), q.z()});
}
std::string join(double number) { return join(std::array<double, 1>{number}); }

Eigen::Quaterniond table_orientation(const World& world) {
  return Eigen::AngleAxisd(world.table_tilt.x(), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(world.table_tilt.y(), Eigen::Vector3d::UnitY());
}
Eigen::Vector3d table_center(const World& world) {
  return {kTablePivot.x(), kTablePivot.y(), world.table_height};
}

Eigen::Quaterniond orientation_on_level_table(const ObjectParameters& object) {
  return Eigen::AngleAxisd(object.yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(object.roll_pitch.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(object.roll_pitch.x(), Eigen::Vector3d::UnitX());
}

Eigen::Quaterniond start_orientation(const World& world, const ObjectParameters& object) {
  return table_orientation(world) * orientation_on_level_table(object);
}

/// How far an object that is turned like that reaches against a direction in W from its centre of
/// mass [m].
double reach_against(const ObjectParameters& object, const Eigen::Quaterniond& q_WB,
                     const Eigen::Vector3d& direction) noexcept {
  return scene::reach(object.object.shape(), q_WB.conjugate() * -direction);
}

std::string capsules(int link) {
  std::string text;
  for (const Capsule& c : kCapsules) {
    if (c.link != link) continue;
    text += R"(<geom class="arm" type="capsule" fromto=")" + join(c.from) + " " + join(c.to) +
            R"(" size=")" + join(c.radius) + "\"/>\n";
  }
  return text;
}

std::string mesh(int link, const SceneParameters& parameters) {
  if (parameters.mesh_directory.empty()) return "";
  return R"(<geom class="arm_mesh" mesh="link)" + std::to_string(link) + "\"/>\n";
}

/// Link `index` (0-based) with all that hangs on it.
std::string link(int index, const SceneParameters& parameters) {
  const Link& l = kLinks.at(static_cast<std::size_t>(index));
  const std::string number = std::to_string(index + 1);
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(l.quarter_turns_x * M_PI_2, Eigen::Vector3d::UnitX()));
  // the inertia here is a placeholder that the compiler accepts; write_inertia() puts the true one
  std::string text =
      "<body name=\"link" + number + "\" pos=\"" + join(l.origin) + "\" quat=\"" + join(turn) +
      "\">\n<inertial pos=\"" + join(l.center) + "\" mass=\"" + join(l.mass) +
      "\" quat=\"0.8 0.6 0 0\" diaginertia=\"0.01 0.01 0.01\"/>\n<joint name=\"joint" + number +
      R"(" type="hinge" axis="0 0 1" damping=")" + join(kJointDamping) + "\"/>\n" +
      capsules(index + 1) + mesh(index + 1, parameters);
  if (index + 1 < kJoints) {
    text += link(index + 1, parameters);
  } else {
    const EndEffector& tool = parameters.world.end_effector;
    text += R"(<body name="end_effector" pos="0 0 )" + join(kFlangeOffset) + R"(">
<inertial pos="0 0 )" +
            join(tool.center_of_mass) + R"(" mass=")" + join(tool.mass) +
            R"(" quat="0.8 0.6 0 0" diaginertia="0.01 0.01 0.01"/>
<geom class="tool" type="cylinder" fromto="0 0 0 0 0 0.0096" size="0.0315"/>
<geom class="tool" type="cylinder" fromto="0 0 0.0096 0 0 0.1112" size="0.0127"/>
<geom class="tool" name="end_effector" type="sphere" pos="0 0 )" +
            join(tool.sphere_center) + R"(" size=")" + join(tool.sphere_radius) + R"("/>
<site name="end_effector" pos="0 0 )" +
            join(tool.sphere_center) + R"(" size="0.001" group="5"/>
</body>
)";
  }
  return text + "</body>\n";
}

std::string contact_pair(const std::string& a, const std::string& b, double friction,
                         double rolling) {
  // condim 3: sliding friction only, so a sphere rolls freely; 6 adds torsional and rolling
  // resistance
  const bool resists = rolling > 0;
  const std::string f = join(friction);
  const std::string r = join(rolling);
  return "<pair geom1=\"" + a + "\" geom2=\"" + b + "\" condim=\"" + (resists ? "6" : "3") +
         "\" friction=\"" + f + " " + f + (resists ? " " + r + " " + r + " " + r : "") + "\" " +
         kContactStiffness + "/>\n";
}

std::string geom(const scene::Part& part, const std::string& name, std::size_t object) {
  std::string text = "<geom name=\"" + name + "\" type=\"";
  switch (part.shape.kind) {
    case scene::ShapeKind::kSphere:
      text += "sphere\" size=\"" + join(part.shape.radius);
      break;
    case scene::ShapeKind::kBox:
      text += "box\" size=\"" + join(part.shape.half_sizes);
      break;
    case scene::ShapeKind::kCapsule:
      text += "capsule\" size=\"" +
              join(std::array<double, 2>{part.shape.radius, part.shape.half_length});
      break;
    case scene::ShapeKind::kCylinder:
      text += "cylinder\" size=\"" +
              join(std::array<double, 2>{part.shape.radius, part.shape.half_length});
      break;
    default:
      text += "mesh\" mesh=\"" + name;
  }
  text += "\"";
  if (!part.p_BP.isZero(0.0)) text += " pos=\"" + join(part.p_BP) + "\"";
  if (part.R_BP != Eigen::Matrix3d::Identity())
    text += " quat=\"" + join(Eigen::Quaterniond(part.R_BP)) + "\"";
  return text + " rgba=\"" + join(kObjectColours.at(object)) + " 1\"/>\n";
}

std::string inertia(const Eigen::Matrix3d& I) {
  if (Eigen::Matrix3d(I.diagonal().asDiagonal()) == I)
    return "diaginertia=\"" + join(Eigen::Vector3d(I.diagonal())) + "\"";
  return "fullinertia=\"" +
         join(std::array<double, 6>{I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}) + "\"";
}

std::string tag_name(int id) { return "tag" + std::to_string(id); }

const TagPicture* picture_of(const SceneParameters& parameters, int id) {
  const auto found = std::find_if(parameters.tag_pictures.begin(), parameters.tag_pictures.end(),
                                  [&](const TagPicture& picture) { return picture.id == id; });
  return found == parameters.tag_pictures.end() ? nullptr : &*found;
}

/// A picture just above the surface, so that it alone is seen.
std::string tag_geom(const scene::Tag& tag, const TagPicture& picture) {
  const double half = 0.5 * tag.size * picture.side / (picture.side - 2 * picture.border);
  return "<geom type=\"box\" size=\"" + join(Eigen::Vector3d(half, half, kTagThickness)) +
         "\" pos=\"" + join(tag.p_BT) + "\" quat=\"" + join(Eigen::Quaterniond(tag.R_BT)) +
         "\" material=\"" + tag_name(tag.id) + "\"/>\n";
}

std::string tag_assets(const SceneParameters& parameters) {
  std::string text;
  for (const TagPicture& picture : parameters.tag_pictures) {
    const std::string side = std::to_string(picture.side * kPixelsPerCell);
    const std::string name = tag_name(picture.id);
    // the pixels are a placeholder; paint_tags() puts the picture
    text += "<texture name=\"" + name + "\" type=\"2d\" builtin=\"flat\" width=\"" + side +
            "\" height=\"" + side + "\"/>\n<material name=\"" + name + "\" texture=\"" + name +
            "\" specular=\"0\"/>\n";
  }
  return text;
}

/// MuJoCo reads textures from files alone.
void paint_tags(mjModel& model, const std::vector<TagPicture>& pictures) {
  for (const TagPicture& picture : pictures) {
    const int texture = mj_name2id(&model, mjOBJ_TEXTURE, tag_name(picture.id).c_str());
    mjtByte* pixel = model.tex_rgb + model.tex_adr[texture];
    const int side = picture.side * kPixelsPerCell;
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column, pixel += 3) {
        const int cell = row / kPixelsPerCell * picture.side + column / kPixelsPerCell;
        std::fill(pixel, pixel + 3, picture.cells[static_cast<std::size_t>(cell)]);
      }
    }
  }
}

std::string body(const SceneParameters& parameters, std::size_t index) {
  const World& world = parameters.world;
  const ObjectParameters& object = world.objects[index];
  const Eigen::Isometry3d start = object_start(world, index);
  const std::string& name = object.object.name;
  std::string text =
      "<body name=\"" + name + "\" pos=\"" + join(Eigen::Vector3d(start.translation())) +
      (is_sphere(object) ? "" : "\" quat=\"" + join(start_orientation(world, object))) +
      "\">\n<freejoint name=\"" + name + "\"/>\n<inertial pos=\"0 0 0\" mass=\"" +
      join(object.object.mass) + "\" " + inertia(object.object.inertia) + "/>\n";
  const std::vector<scene::Part>& parts = object.object.parts->parts;
  for (std::size_t k = 0; k < parts.size(); ++k)
    text += geom(parts[k], geom_name(object.object, k), index);
  for (const scene::Tag& tag : object.object.tags) {
    if (const TagPicture* picture = picture_of(parameters, tag.id)) text += tag_geom(tag, *picture);
  }
  return text + "</body>\n";
}

/// Those of an object with the table, the end effector and the objects before it.
std::string pairs_of(const World& world, std::size_t index) {
  const ObjectParameters& object = world.objects[index];
  std::string pairs;
  for (std::size_t k = 0; k < object.object.parts->parts.size(); ++k) {
    const std::string name = geom_name(object.object, k);
    pairs += contact_pair("table", name, object.friction_table, world.rolling_friction);
    pairs += contact_pair("end_effector", name, object.friction_end_effector, 0);
    for (std::size_t j = 0; j < index; ++j) {
      const scene::Object& other = world.objects[j].object;
      for (std::size_t l = 0; l < other.parts->parts.size(); ++l)
        pairs += contact_pair(geom_name(other, l), name, world.friction.object_object, 0);
    }
  }
  return pairs;
}

/// Of the objects' convex meshes: their corners.
std::string mesh_assets(const World& world) {
  std::string text;
  for (const ObjectParameters& object : world.objects) {
    const std::vector<scene::Part>& parts = object.object.parts->parts;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (parts[k].shape.kind != scene::ShapeKind::kConvexMesh) continue;
      text += "<mesh name=\"" + geom_name(object.object, k) + "\" vertex=\"";
      for (const Eigen::Vector3d& vertex : parts[k].shape.mesh->vertices())
        text += join(vertex) + " ";
      text += "\"/>\n";
    }
  }
  return text;
}

std::string xml(const SceneParameters& parameters) {
  const World& world = parameters.world;
  const bool meshes = !parameters.mesh_directory.empty();
  std::string text = R"(<mujoco model="c3rt">
<compiler angle="radian" coordinate="local" inertiafromgeom="false" balanceinertia="false" meshdir=")" +
                     parameters.mesh_directory + R"("/>
<option timestep=")" +
                     join(world.step) +
                     R"(" gravity="0 0 -9.81" integrator="Euler" cone="elliptic" impratio="10"
  solver="Newton" iterations="50" tolerance="1e-12"/>
<statistic extent="1" center="0.5 0 0.2"/>
<visual>
  <global offwidth=")" +
                     std::to_string(parameters.offscreen_width) + R"(" offheight=")" +
                     std::to_string(parameters.offscreen_height) + R"("/>
  <quality shadowsize="0" offsamples=")" +
                     std::to_string(parameters.offscreen_samples) + R"("/>
  <headlight active="0"/>
  <map znear="0.02" zfar="10"/>
</visual>
<default>
  <geom contype="0" conaffinity="0" group="0"/>
  <default class="arm"><geom group="1" rgba="0.93 0.94 0.96 1"/></default>
  <default class="arm_mesh"><geom group="2" type="mesh" rgba="0.93 0.94 0.96 1"/></default>
  <default class="tool"><geom group="0" rgba="0.10 0.11 0.13 1"/></default>
</default>
)";
  text += "<asset>\n" + mesh_assets(world) + tag_assets(parameters);
  for (int i = 0; meshes && i <= kJoints; ++i)
    text += "<mesh file=\"link" + std::to_string(i) + ".stl\"/>\n";
  text += "</asset>\n";
  text += R"(<worldbody>
<light directional="true" castshadow="false" pos="0.5 0 3" dir="0.2 0.3 -1" ambient="0.45 0.45 0.45"
  diffuse="0.40 0.40 0.40" specular="0 0 0"/>
<light directional="true" castshadow="false" pos="3 0 1" dir="-1 -0.4 -0.25" ambient="0 0 0"
  diffuse="0.25 0.25 0.25" specular="0 0 0"/>
)";
  text += R"(<body name="table" pos=")" + join(table_center(world)) + "\" quat=\"" +
          join(table_orientation(world)) +
          "\">\n<geom name=\"table\" type=\"plane\" size=\"1.2 1.2 0.1\" rgba=\"0.86 0.87 0.88 "
          "1\"/>\n</body>\n";
  text += capsules(0) + mesh(0, parameters) + link(0, parameters);

  std::string pairs;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    text += body(parameters, i);
    pairs += pairs_of(world, i);
  }
  pairs += contact_pair("table", "end_effector", world.friction.end_effector_table, 0);

  for (const CameraPose& camera : parameters.cameras)
    text += "<camera name=\"" + camera.name + "\" pos=\"" + join(camera.p_WC) + "\" quat=\"" +
            join(camera.q_WC.normalized()) + "\" fovy=\"" + join(camera.fovy * 180.0 / M_PI) +
            "\"/>\n";
  return text + "</worldbody>\n<contact>\n" + pairs + "</contact>\n</mujoco>\n";
}

/// MuJoCo's compiler refuses some inertias of the URDF, so they are written behind its back, in
/// principal axes.
void write_inertia(mjModel& model, const std::string& name, const Inertia& i) {
  Eigen::Matrix3d I;
  I << i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(I);
  Eigen::Matrix3d R = principal.eigenvectors();
  if (R.determinant() < 0) R.col(2) *= -1;
  const Eigen::Quaterniond q(R);
  const int body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
  Eigen::Map<Eigen::Vector3d>(model.body_inertia + 3 * body) = principal.eigenvalues();
  Eigen::Map<Eigen::Vector4d>(model.body_iquat + 4 * body) << q.w(), q.x(), q.y(), q.z();
}

void check(const SceneParameters& p) {
  const World& w = p.world;
  require(w.step > 0 && w.step <= 1e-3, "step must be in (0, 0.001] s");
  require(!w.objects.empty() && w.objects.size() <= scene::kMaxBodies,
          "1 to " + std::to_string(scene::kMaxBodies) + " objects");
  require(w.table_tilt.allFinite() && w.table_tilt.cwiseAbs().maxCoeff() < 0.5,
          "table_tilt must be below 0.5 rad");
  require(std::isfinite(w.table_height), "table_height must be finite");
  const auto require_friction = [](double mu) {
    require(mu > 0 && mu < 10, "friction must be in (0, 10)");
  };
  require_friction(w.friction.object_object);
  require_friction(w.friction.end_effector_table);
  require(w.rolling_friction >= 0 && w.rolling_friction < 0.01,
          "rolling_friction must be in [0, 0.01) m");
  const EndEffector& e = w.end_effector;
  require(e.mass > 0 && e.inertia_xx > 0 && e.inertia_zz > 0 && e.sphere_radius > 0,
          "the end effector needs a mass, inertias and a radius");
  for (const ObjectParameters& o : w.objects) {
    require_friction(o.friction_table);
    require_friction(o.friction_end_effector);
    require(o.object.parts && !o.object.parts->parts.empty() && o.object.mass > 0 &&
                reach_against(o, Eigen::Quaterniond::Identity(), Eigen::Vector3d::UnitZ()) > 0 &&
                o.position.allFinite() && std::isfinite(o.yaw) && o.roll_pitch.allFinite(),
            "an object needs a size, a mass and a position");
  }
  require(p.offscreen_width > 0 && p.offscreen_height > 0 && p.offscreen_samples >= 0,
          "offscreen size must be > 0");
}

}  // namespace

std::string geom_name(const scene::Object& object, std::size_t part) {
  return object.parts->parts.size() == 1 ? object.name : object.name + "_" + std::to_string(part);
}

bool is_free_name(const World& world, const std::string& name) {
  for (const char* taken : {"world", "table", "end_effector"})
    if (name == taken) return false;
  for (int i = 1; i <= kJoints; ++i)
    if (name == "link" + std::to_string(i) || name == "joint" + std::to_string(i)) return false;
  return std::none_of(world.objects.begin(), world.objects.end(),
                      [&](const ObjectParameters& other) { return other.object.name == name; });
}

bool is_sphere(const ObjectParameters& object) noexcept {
  return object.object.shape().kind == scene::ShapeKind::kSphere;
}

double start_height(const ObjectParameters& object) noexcept {
  return reach_against(object, orientation_on_level_table(object), Eigen::Vector3d::UnitZ());
}

Eigen::Isometry3d object_start(const World& world, std::size_t index) {
  const ObjectParameters& object = world.objects.at(index);
  const Eigen::Vector3d n = table_orientation(world) * Eigen::Vector3d::UnitZ();
  const Eigen::Vector2d offset = object.position - kTablePivot;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  if (!is_sphere(object)) X_WB = start_orientation(world, object);
  // n . (p - table_center) = height above the table
  X_WB.translation() << object.position,
      world.table_height + (start_height(object) - n.head<2>().dot(offset)) / n.z();
  return X_WB;
}

std::string installed_mesh_directory() {
  const std::filesystem::path folder(C3RT_PANDA_MESHES);
  return std::filesystem::exists(folder / "link0.stl") ? folder.string() : std::string();
}

Model compile_model(const std::string& mjcf) {
  check_box_collisions();
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  constexpr const char* kName = "c3rt.xml";
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(mjcf.size()));
  std::copy(mjcf.begin(), mjcf.end(),
            static_cast<char*>(files->filedata[mj_findFileVFS(files.get(), kName)]));
  std::array<char, 1000> error{};
  Model model(mj_loadXML(kName, files.get(), error.data(), static_cast<int>(error.size())));
  mj_deleteVFS(files.get());
  if (!model)
    throw std::runtime_error(std::string("scene: MuJoCo refuses the model: ") + error.data());
  return model;
}

Model build_model(const SceneParameters& parameters) {
  check(parameters);
  Model model = compile_model(xml(parameters));
  paint_tags(*model, parameters.tag_pictures);

  for (int i = 0; i < kJoints; ++i)
    write_inertia(*model, "link" + std::to_string(i + 1),
                  kLinks.at(static_cast<std::size_t>(i)).inertia);
  const EndEffector& tool = parameters.world.end_effector;
  write_inertia(*model, "end_effector",
                {tool.inertia_xx, 0, 0, tool.inertia_xx, 0, tool.inertia_zz});
  const Data data(mj_makeData(model.get()));
  mj_setConst(model.get(), data.get());
  return model;
}

}  // namespace c3rt::plant
