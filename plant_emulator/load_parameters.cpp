#include "plant_emulator/load_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "controller/mjcf/object.hpp"
#include "plant_emulator/plant.hpp"

namespace c3rt::plant {

namespace {

/// Seen from above, how far an object reaches from where the scenario puts it [m].
double extent(const ObjectParameters& object) {
  const scene::Shape shape = object.object.shape();
  if (shape.kind == scene::ShapeKind::kSphere) return shape.radius;
  // turned by any yaw, it reaches as far as it does in any of these directions
  constexpr int kDirections = 72;
  const Eigen::Quaterniond q = Eigen::AngleAxisd(object.roll_pitch.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(object.roll_pitch.x(), Eigen::Vector3d::UnitX());
  double most = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * M_PI * i / kDirections;
    const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0.0);
    most = std::max(most, scene::reach(shape, q.conjugate() * direction));
  }
  return most / std::cos(M_PI / kDirections);
}

bool may_overlap(const ObjectParameters& a, const ObjectParameters& b) {
  // between the nearest points of the two rectangles
  const Eigen::Array2d spread = a.start_spread_xy + b.start_spread_xy;
  const Eigen::Array2d between = ((a.position - b.position).array().abs() - spread).max(0.0);
  const double apart = between.matrix().norm() - a.start_spread - b.start_spread;
  // two spheres on one plane touch at this distance, seen from above
  const bool spheres = is_sphere(a) && is_sphere(b);
  return apart < (spheres ? 2.0 * std::sqrt(extent(a) * extent(b)) : extent(a) + extent(b));
}

/// Of even density, from the sizes in the scenario.
scene::Object load_shape(config::Section& section, const std::string& number) {
  using scene::Shape;
  constexpr config::Range kRadius{0.005, 0.2}, kHalf{0.005, 0.5};
  enum class Kind { kSphere, kBox, kCapsule, kCylinder };
  const Kind kind = section.choice<Kind>("shape", {{"sphere", Kind::kSphere},
                                                   {"box", Kind::kBox},
                                                   {"capsule", Kind::kCapsule},
                                                   {"cylinder", Kind::kCylinder}});
  const double mass = section.number("mass_kg", {0.001, 10});
  if (kind == Kind::kBox)
    return scene::solid("box" + number, Shape::box(section.numbers("half_sizes_m", 3, kHalf)),
                        mass);
  const double radius = section.number("radius_m", kRadius);
  if (kind == Kind::kSphere) return scene::solid("ball" + number, Shape::sphere(radius), mass);
  const double half_length = section.number("half_length_m", kHalf);
  if (kind == Kind::kCapsule)
    return scene::solid("capsule" + number, Shape::capsule(radius, half_length), mass);
  return scene::solid("cylinder" + number, Shape::cylinder(radius, half_length), mass);
}

/// From a MuJoCo model; the real one may be heavier or larger.
scene::Object load_mjcf(config::Section& section) {
  if (section.has("shape"))
    section.fail("shape", "shape or mjcf, as the file has the shape", "both");
  const double mass = section.number("mass_scale", {0.01, 100}, 1.0);
  const double size = section.number("size_scale", {0.1, 10}, 1.0);
  try {
    return scene::scaled(mjcf::read_object(section.file("mjcf")).object, mass, size);
  } catch (const mjcf::Error& error) {
    section.fail("mjcf", "a rigid object that can be simulated", error.what());
  }
}

ObjectParameters load_object(config::Section& section, const World& world,
                             const Eigen::Vector2d& friction) {
  const bool from_file = section.has("mjcf");
  const std::string number = std::to_string(world.objects.size());
  ObjectParameters p{};
  p.object = from_file ? load_mjcf(section) : load_shape(section, number);
  if (section.has("name")) {
    p.object.name = section.name("name");
  } else if (!is_free_name(world, p.object.name)) {
    p.object.name += number;  // the second of one file
  }
  if (!is_free_name(world, p.object.name))
    section.fail("name", "a name that nothing else in the scene has", p.object.name);
  p.position = section.numbers("position_m", 2, {-1, 1});
  p.yaw = section.number("yaw_rad", {-3.2, 3.2}, 0.0);
  if (section.has("roll_pitch_rad"))
    p.roll_pitch = section.numbers("roll_pitch_rad", 2, {-3.2, 3.2});
  if (section.has("held")) p.held = section.boolean("held");
  p.start_spread = section.number("start_spread_m", {0, 0.3}, 0.0);
  if (section.has("start_spread_xy_m")) {
    if (p.start_spread > 0)
      section.fail("start_spread_xy_m", "start_spread_m (a disc) or this (a rectangle)", "both");
    p.start_spread_xy = section.numbers("start_spread_xy_m", 2, {0, 0.3});
  }
  p.yaw_spread = section.number("yaw_spread_rad", {0, 3.1416}, 0.0);
  constexpr config::Range kFriction{0.01, 5};
  const double of_file = p.object.friction;
  p.friction_table =
      section.number("friction_table", kFriction, from_file ? of_file : friction.x());
  p.friction_end_effector =
      section.number("friction_end_effector", kFriction, from_file ? of_file : friction.y());
  return p;
}

void load_objects(config::Section& section, World& world, const Eigen::Vector2d& friction) {
  for (config::Section& entry : section.list("objects", 1, scene::kMaxBodies)) {
    const ObjectParameters object = load_object(entry, world, friction);
    for (const ObjectParameters& other : world.objects) {
      if (may_overlap(other, object)) {
        section.fail("objects", "objects that cannot overlap at the start, spreads included",
                     "\"" + other.object.name + "\" and \"" + object.object.name + "\", which can");
      }
    }
    world.objects.push_back(object);
  }
}

PushParameters load_pushes(config::Section section) {
  PushParameters pushes;
  pushes.count = section.integer("count", {0, 1000});
  pushes.from = section.number("from_s", {0, 1e6});
  pushes.until = section.number("until_s", {0, 1e6});
  if (pushes.until <= pushes.from)
    section.fail("until_s", "a time after from_s", std::to_string(pushes.until));
  pushes.impulse_min = section.number("impulse_min_n_s", {0, 1});
  pushes.impulse_max = section.number("impulse_max_n_s", {0, 1});
  if (pushes.impulse_max < pushes.impulse_min) {
    section.fail("impulse_max_n_s", "no less than impulse_min_n_s",
                 std::to_string(pushes.impulse_max));
  }
  return pushes;
}

}  // namespace

EndEffector end_effector_of(const config::Robot& robot) {
  const config::Robot::EndEffector& tool = robot.end_effector;
  return {tool.mass,       tool.center_of_mass, tool.inertia_xx,
          tool.inertia_zz, tool.sphere_center,  tool.sphere_radius};
}

JointLimits limits_of(const config::Robot& robot) {
  return {robot.q_min, robot.q_max, robot.dq_max, robot.tau_max, robot.tau_rate_max};
}

Safety safety_of(const config::Robot& robot) {
  Safety safety;
  if (!robot.safety) return safety;
  const config::Robot::Safety& from = *robot.safety;
  const auto thresholds = [](const config::Robot::Thresholds& t) {
    return Thresholds{t.contact_torque, t.collision_torque, t.contact_force, t.collision_force};
  };
  safety.velocity_max = from.velocity_max;
  safety.angular_velocity_max = from.angular_velocity_max;
  safety.power_max = from.power_max;
  safety.tau_sensor_max = from.tau_sensor_max;
  safety.clearance_min = from.clearance_min;
  safety.collision = {thresholds(from.acceleration), thresholds(from.nominal)};
  if (from.motion) {
    safety.motion = {
        from.motion->joint_acceleration,   from.motion->joint_jerk, from.motion->acceleration,
        from.motion->angular_acceleration, from.motion->jerk,       from.motion->angular_jerk};
  }
  return safety;
}

Parameters load_parameters(config::Section section, const config::Robot& robot) {
  Parameters p{};
  p.limits = limits_of(robot);
  p.safety = safety_of(robot);
  p.world.end_effector = end_effector_of(robot);
  p.world.table_height = section.number("table_height_m", {-0.5, 0.5});
  p.world.table_tilt = section.numbers("table_tilt_rad", 2, {-0.3, 0.3});
  if (section.has("table_tilt_drawn")) p.world.tilt_drawn = section.boolean("table_tilt_drawn");
  config::Section friction = section.section("friction");
  // of objects whose own entry says nothing else
  const Eigen::Vector2d of_objects(friction.number("object_table", {0.01, 5}),
                                   friction.number("object_end_effector", {0.01, 5}));
  p.world.friction.object_object = friction.number("object_object", {0.01, 5});
  p.world.friction.end_effector_table = friction.number("end_effector_table", {0.01, 5});
  if (friction.has("object_drawn")) {
    p.world.friction_drawn = friction.numbers("object_drawn", 2, {0.01, 5});
    if (p.world.friction_drawn->x() > p.world.friction_drawn->y())
      friction.fail("object_drawn", "the least, then the most", "the most first");
  }
  p.world.rolling_friction = section.number("rolling_friction_m", {0, 0.005});
  p.world.step = section.number("step_s", {1e-4, 1e-3});
  if (!divides_cycle(p.world.step))
    section.fail("step_s", "a step that divides 0.001 s", std::to_string(p.world.step));
  p.initial_q = section.numbers("initial_q_rad", kJoints, {-4, 4});
  for (int i = 0; i < kJoints; ++i) {
    if (p.initial_q[i] < p.limits.q_min[i] || p.initial_q[i] > p.limits.q_max[i])
      section.fail("initial_q_rad",
                   "joint " + std::to_string(i + 1) + " in [" + std::to_string(p.limits.q_min[i]) +
                       ", " + std::to_string(p.limits.q_max[i]) + "]",
                   std::to_string(p.initial_q[i]));
  }
  load_objects(section, p.world, of_objects);
  if (section.has("walls_min_m") || section.has("walls_max_m")) {
    p.walls = VirtualWalls{section.numbers("walls_min_m", 3, {-2, 2}),
                           section.numbers("walls_max_m", 3, {-2, 2})};
    if ((p.walls->min.array() >= p.walls->max.array()).any())
      section.fail("walls_max_m", "every entry above that of walls_min_m", "one that is not");
  }
  if (section.has("torque_jump_stops")) p.torque_jump_stops = section.boolean("torque_jump_stops");
  if (section.has("pushes")) p.pushes = load_pushes(section.section("pushes"));
  section.finish();
  return p;
}

}  // namespace c3rt::plant
