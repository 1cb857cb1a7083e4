#include "plant_emulator/load_parameters.hpp"

#include <cmath>
#include <vector>

#include "plant_emulator/plant.hpp"

namespace c3rt::plant {

namespace {

/// Seen from above, how far another object has to keep from the centre [m].
double size(const BallParameters& object) {
  return object.half_sizes ? object.half_sizes->head<2>().norm() : object.radius;
}

bool may_overlap(const std::vector<BallParameters>& objects) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const BallParameters &a = objects[i], &b = objects[j];
      const double apart = (a.position - b.position).norm() - a.start_spread - b.start_spread;
      // two balls on one plane touch at this distance, seen from above
      const bool balls = !a.half_sizes && !b.half_sizes;
      const double touching = balls ? 2.0 * std::sqrt(a.radius * b.radius) : size(a) + size(b);
      if (apart < touching) return true;
    }
  }
  return false;
}

std::vector<config::Section> listed(config::Section& section, const char* key) {
  return section.has(key) ? section.list(key, 1, kMaxBalls) : std::vector<config::Section>{};
}

void load_objects(config::Section& section, World& world) {
  for (config::Section& ball : listed(section, "balls")) {
    world.balls.push_back({ball.numbers("position_m", 2, {-1, 1}),
                           ball.number("radius_m", {0.005, 0.2}),
                           ball.number("mass_kg", {0.001, 10})});
    if (ball.has("held")) world.balls.back().held = ball.boolean("held");
    world.balls.back().start_spread = ball.number("start_spread_m", {0, 0.1}, 0.0);
  }
  for (config::Section& box : listed(section, "boxes")) {
    world.balls.push_back(
        {box.numbers("position_m", 2, {-1, 1}), 0.0, box.number("mass_kg", {0.001, 10})});
    BallParameters& object = world.balls.back();
    object.half_sizes = box.numbers("half_sizes_m", 3, {0.005, 0.5});
    object.yaw = box.number("yaw_rad", {-3.2, 3.2}, 0.0);
    object.start_spread = box.number("start_spread_m", {0, 0.1}, 0.0);
  }
  if (world.balls.empty() || world.balls.size() > kMaxBalls) {
    section.fail("balls", "1 to " + std::to_string(kMaxBalls) + " objects, balls and boxes",
                 std::to_string(world.balls.size()));
  }
  if (may_overlap(world.balls))
    section.fail("balls", "balls that cannot overlap at the start, start_spread_m included",
                 "two that can");
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

Parameters load_parameters(config::Section section, const config::Robot& robot) {
  Parameters p{};
  p.limits = limits_of(robot);
  p.world.end_effector = end_effector_of(robot);
  p.world.table_height = section.number("table_height_m", {-0.5, 0.5});
  p.world.table_tilt = section.numbers("table_tilt_rad", 2, {-0.3, 0.3});
  if (section.has("table_tilt_drawn")) p.world.tilt_drawn = section.boolean("table_tilt_drawn");
  config::Section friction = section.section("friction");
  p.world.friction.ball_table = friction.number("ball_table", {0.01, 5});
  p.world.friction.ball_end_effector = friction.number("ball_end_effector", {0.01, 5});
  p.world.friction.ball_ball = friction.number("ball_ball", {0.01, 5});
  p.world.friction.end_effector_table = friction.number("end_effector_table", {0.01, 5});
  if (friction.has("ball_drawn")) {
    p.world.friction_drawn = friction.numbers("ball_drawn", 2, {0.01, 5});
    if (p.world.friction_drawn->x() > p.world.friction_drawn->y())
      friction.fail("ball_drawn", "the least, then the most", "the most first");
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
  load_objects(section, p.world);
  if (section.has("pushes")) p.pushes = load_pushes(section.section("pushes"));
  section.finish();
  return p;
}

}  // namespace c3rt::plant
