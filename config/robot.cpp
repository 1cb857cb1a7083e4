#include "config/robot.hpp"

#include <cmath>

#include "config/directory.hpp"

namespace c3rt::config {
namespace {

constexpr const char* kDefault = "panda";
constexpr Range kAngle{-2 * M_PI, 2 * M_PI};

Robot::Thresholds read_thresholds(Section section) {
  constexpr Range kAny{0.0, 1e6};
  Robot::Thresholds thresholds;
  thresholds.contact_torque = section.numbers("contact_torque_nm", 7, kAny);
  thresholds.collision_torque = section.numbers("collision_torque_nm", 7, kAny);
  thresholds.contact_force = section.numbers("contact_force_n", 6, kAny);
  thresholds.collision_force = section.numbers("collision_force_n", 6, kAny);
  return thresholds;
}

Robot::Safety::Motion read_motion(Section section) {
  constexpr Range kAny{1e-3, 1e9};
  Robot::Safety::Motion motion;
  motion.joint_acceleration = section.numbers("joint_acceleration_max_rad_per_s2", 7, kAny);
  motion.joint_jerk = section.numbers("joint_jerk_max_rad_per_s3", 7, kAny);
  motion.acceleration = section.number("acceleration_max_m_per_s2", kAny);
  motion.angular_acceleration = section.number("angular_acceleration_max_rad_per_s2", kAny);
  motion.jerk = section.number("jerk_max_m_per_s3", kAny);
  motion.angular_jerk = section.number("angular_jerk_max_rad_per_s3", kAny);
  return motion;
}

Robot::Safety read_safety(Section section) {
  Robot::Safety safety;
  safety.velocity_max = section.number("velocity_max_m_per_s", {0.01, 100});
  safety.angular_velocity_max = section.number("angular_velocity_max_rad_per_s", {0.01, 100});
  safety.power_max = section.number("power_max_w", {1, 1e6});
  safety.tau_sensor_max = section.numbers("tau_sensor_max_nm", 7, {0.1, 1e4});
  safety.clearance_min = section.number("clearance_min_m", {-1, 1});
  if (section.has("motion")) safety.motion = read_motion(section.section("motion"));
  safety.nominal = read_thresholds(section.section("nominal"));
  safety.acceleration = section.has("acceleration")
                            ? read_thresholds(section.section("acceleration"))
                            : safety.nominal;
  return safety;
}

Robot read(Section& section) {
  Robot robot{};
  robot.urdf = section.text("urdf");
  robot.flange = section.text("flange");
  Section joints = section.section("joints");
  robot.q_min = joints.numbers("q_min_rad", 7, kAngle);
  robot.q_max = joints.numbers("q_max_rad", 7, kAngle);
  if ((robot.q_min.array() >= robot.q_max.array()).any())
    joints.fail("q_max_rad", "every entry above that of q_min_rad", "one that is not");
  robot.dq_max = joints.numbers("dq_max_rad_per_s", 7, {0.01, 10});
  robot.tau_max = joints.numbers("tau_max_nm", 7, {0.1, 1000});
  robot.tau_rate_max = joints.number("tau_rate_max_nm_per_s", {1, 1e5});
  if (section.has("safety")) robot.safety = read_safety(section.section("safety"));
  Section tool = section.section("end_effector");
  robot.end_effector.mass = tool.number("mass_kg", {1e-3, 20});
  robot.end_effector.center_of_mass = tool.number("center_of_mass_m", {0, 1});
  robot.end_effector.inertia_xx = tool.number("inertia_xx_kg_m2", {1e-9, 10});
  robot.end_effector.inertia_zz = tool.number("inertia_zz_kg_m2", {1e-9, 10});
  robot.end_effector.sphere_center = tool.number("sphere_center_m", {0, 1});
  robot.end_effector.sphere_radius = tool.number("sphere_radius_m", {1e-3, 0.2});
  return robot;
}

}  // namespace

Robot load_robot(Section& root) {
  if (!root.has("robot")) return load_robot(kDefault);
  Section section = root.section("robot");
  Robot robot = read(section);
  section.finish();
  return robot;
}

Robot load_robot(const std::string& name) {
  Section section = Document::load((directory() / "robots" / (name + ".yaml")).string());
  return read(section);
}

}  // namespace c3rt::config
