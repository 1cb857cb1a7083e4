#pragma once
// The MuJoCo model of robot, table and objects; the plant steps it and the virtual cameras render
// it.
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <mujoco/mujoco.h>

#include "controller/scene/object.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::plant {

constexpr int kJoints = 7;

/// Visual groups of the geoms (mjvOption.geomgroup). Render kGroupWorld and one of the arm's two
/// looks.
enum GeomGroup {
  kGroupWorld = 0,          // table, objects, end effector
  kGroupArmPrimitives = 1,  // the arm as capsules: cheap
  kGroupArmMeshes = 2,      // the arm as meshes; empty without SceneParameters::mesh_directory
};

/// Colour of each object, red green blue: far apart in hue, so that a camera can tell them apart.
inline const std::array<Eigen::Vector3d, scene::kMaxBodies> kObjectColours{
    Eigen::Vector3d{1.00, 0.36, 0.06}, Eigen::Vector3d{0.05, 0.35, 0.95},
    Eigen::Vector3d{0.10, 0.75, 0.15}, Eigen::Vector3d{0.85, 0.10, 0.75},
    Eigen::Vector3d{0.05, 0.90, 0.80}, Eigen::Vector3d{0.45, 0.10, 0.95},
    Eigen::Vector3d{0.78, 0.95, 0.05}, Eigen::Vector3d{1.00, 0.05, 0.29}};

/// An object and how it starts: it lies on the table.
struct ObjectParameters {
  scene::Object object;
  Eigen::Vector2d position;  // of its centre of mass, seen from above [m]
  double yaw = 0.0;          // about the table's normal, after roll and pitch [rad]
  Eigen::Vector2d roll_pitch = Eigen::Vector2d::Zero();  // which side is down [rad]
  bool held = false;  // a hand holds it where it starts until the end effector touches it
  // what the seed draws, about the pose above
  double start_spread = 0.0;                                  // on a disc of this radius [m], or
  Eigen::Vector2d start_spread_xy = Eigen::Vector2d::Zero();  // this far along x and y [m]
  double yaw_spread = 0.0;                                    // either way [rad]
  // Coulomb friction coefficients with ...
  double friction_table = 1.0;
  double friction_end_effector = 1.0;
};

/// Coulomb friction coefficients, by pair; those of an object with table and end effector are its
/// own.
struct Friction {
  double object_object;
  double end_effector_table;
};

/// The tool on the flange: disc, rod and sphere as one body, along the flange's z.
struct EndEffector {
  double mass;            // [kg]
  double center_of_mass;  // [m]
  double inertia_xx;      // about the centre of mass; also yy [kg m^2]
  double inertia_zz;      // [kg m^2]
  double sphere_center;   // [m]
  double sphere_radius;   // [m]
};

struct World {
  double table_height;  // z of the table's surface below kTablePivot [m]
  Eigen::Vector2d
      table_tilt;  // about x, then about the tilted y [rad]; the surface turns about kTablePivot
  Friction friction;
  double rolling_friction;  // lever of the rolling resistance, 0 for none [m]
  double step;              // of the integration [s]
  EndEffector end_effector;
  std::vector<ObjectParameters> objects;
  bool tilt_drawn = false;  // table_tilt's direction is the seed's, its size the scenario's
  // if there, the objects' coefficients with table and end effector are drawn between these from
  // the seed
  std::optional<Eigen::Vector2d> friction_drawn;
};

/// Point of the ground plan about which the table tilts: below the arm's home pose [m].
inline const Eigen::Vector2d kTablePivot{0.55, 0.0};

/// A pinhole camera without distortion. Axes of C as in OpenGL and MuJoCo: x right, y up, it looks
/// along -z.
struct CameraPose {
  std::string name;
  Eigen::Vector3d p_WC;  // [m]
  Eigen::Quaterniond q_WC;
  double fovy;  // vertical field of view [rad]
};

/// What is printed where an object has a tag: square cells, black and white.
struct TagPicture {
  int id = 0;
  int side = 0;                     // cells along an edge, the white border included
  int border = 0;                   // cells of white on each side of the black square
  std::vector<std::uint8_t> cells;  // 0 or 255, by rows from the top
};

struct SceneParameters {
  World world;
  std::vector<CameraPose> cameras;
  int offscreen_width;         // [px]; its size costs render time, so no larger than needed
  int offscreen_height;        // [px]
  int offscreen_samples;       // multisampling, 0 for none
  std::string mesh_directory;  // folder of link0.stl .. link7.stl; empty: primitives only
  std::vector<TagPicture> tag_pictures = {};  // of the tags that are drawn, others are not
};

struct ModelDeleter {
  void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
};
struct DataDeleter {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};
using Model = std::unique_ptr<mjModel, ModelDeleter>;
using Data = std::unique_ptr<mjData, DataDeleter>;

/// The model of an MJCF document.
/// @throws std::runtime_error with MuJoCo's words
Model compile_model(const std::string& mjcf);

/// Names: joints joint1..joint7 (qpos 0..6 and qvel 0..6, then the free joint of each object, whose
/// frame is in its centre of mass), bodies link1..link7, end_effector, table and those of the
/// objects, whose geoms are named by geom_name, site end_effector at the centre of its sphere,
/// cameras as given.
/// @throws std::invalid_argument for parameters out of range, std::runtime_error with MuJoCo's
/// words otherwise
Model build_model(const SceneParameters& parameters);

/// Of a part of an object: the object's own name where it has but one.
std::string geom_name(const scene::Object& object, std::size_t part);

/// Whether an object may be called so beside the names that the scene has already.
bool is_free_name(const World& world, const std::string& name);

/// A sphere looks the same however it lies, and rolls.
bool is_sphere(const ObjectParameters& object) noexcept;

/// How high its centre of mass is above a level table [m].
double start_height(const ObjectParameters& object) noexcept;

/// The pose of object `index` when it touches the table at its start.
Eigen::Isometry3d object_start(const World& world, std::size_t index);

/// Folder of the arm's meshes that the set-up installed, or empty if they are not there.
std::string installed_mesh_directory();

}  // namespace c3rt::plant
