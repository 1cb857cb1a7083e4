#pragma once
// The MuJoCo model of robot, table and balls; the plant steps it and the virtual cameras render it.
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <mujoco/mujoco.h>

namespace c3rt::plant {

constexpr int kJoints = 7;
constexpr int kMaxBalls = 4;

/// Visual groups of the geoms (mjvOption.geomgroup). Render kGroupWorld and one of the arm's two
/// looks.
enum GeomGroup {
  kGroupWorld = 0,          // table, balls, end effector
  kGroupArmPrimitives = 1,  // the arm as capsules: cheap
  kGroupArmMeshes = 2,      // the arm as meshes; empty without SceneParameters::mesh_directory
};

/// Colour of each ball, red green blue: far apart in hue, so that a camera can tell them apart.
inline const std::array<Eigen::Vector3d, kMaxBalls> kBallColours{
    Eigen::Vector3d{1.00, 0.36, 0.06}, Eigen::Vector3d{0.05, 0.35, 0.95},
    Eigen::Vector3d{0.10, 0.75, 0.15}, Eigen::Vector3d{0.85, 0.10, 0.75}};

struct BallParameters {
  Eigen::Vector2d position;   // of the centre, seen from above, at the start [m]
  double radius;              // [m]
  double mass;                // [kg]; the inertia is that of a solid sphere
  bool held = false;          // a hand holds it where it starts until the end effector touches it
  double start_spread = 0.0;  // `position` is within this of where the scenario says, by seed [m]
  // a box of even density instead, lying on the table; its radius is 0
  std::optional<Eigen::Vector3d> half_sizes = {};  // [m]
  double yaw = 0.0;                                // of a box, at the start [rad]
};

/// Coulomb friction coefficients, by pair.
struct Friction {
  double ball_table;
  double ball_end_effector;
  double ball_ball;
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
  std::vector<BallParameters> balls;
  bool tilt_drawn = false;  // table_tilt's direction is the seed's, its size the scenario's
  // if there, both of the ball's coefficients are drawn between these from the seed
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

struct SceneParameters {
  World world;
  std::vector<CameraPose> cameras;
  int offscreen_width;         // [px]; its size costs render time, so no larger than needed
  int offscreen_height;        // [px]
  int offscreen_samples;       // multisampling, 0 for none
  std::string mesh_directory;  // folder of link0.stl .. link7.stl; empty: primitives only
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

/// Names: joints joint1..joint7 (qpos 0..6 and qvel 0..6, then one free joint per ball), bodies
/// link1..link7, end_effector, table, ball0.., site end_effector at the centre of its sphere,
/// cameras as given.
/// @throws std::invalid_argument for parameters out of range, std::runtime_error with MuJoCo's
/// words otherwise
Model build_model(const SceneParameters& parameters);

/// "ball0", "box1": of its body, joint and geom.
std::string object_name(const World& world, int index);

/// Centre of ball `index` when it touches the table at its start position. [m]
Eigen::Vector3d ball_start(const World& world, int index);

/// Folder of the arm's meshes that the set-up installed, or empty if they are not there.
std::string installed_mesh_directory();

}  // namespace c3rt::plant
