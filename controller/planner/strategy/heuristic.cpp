#include "controller/planner/strategy/heuristic.hpp"

#include <array>
#include <cmath>

namespace c3rt::planner {

Phase phase_at(const HeuristicParameters& parameters, double elapsed) {
  const double in_cycle = std::fmod(elapsed, parameters.return_duration + parameters.roll_duration);
  if (in_cycle >= parameters.return_duration) return Phase::kRoll;
  const double part = 3.0 * in_cycle / parameters.return_duration;
  return part < 1.0 ? Phase::kReturnUp : part < 2.0 ? Phase::kReturnSideways : Phase::kReturnDown;
}

int sphere_to_work_on(const HeuristicParameters& parameters, const task::Task& task,
                      const scene::Scene& scene, int now) {
  scene::Scene ahead = scene;
  for (scene::Body& sphere : ahead.bodies) sphere.p_WB += parameters.look_ahead * sphere.v_WB;
  std::array<task::Along, scene::kMaxBodies> along;
  for (int i = 0; i < scene.body_count; ++i) {
    const std::optional<task::Along> of_sphere = task.along(ahead, i);
    if (!of_sphere) return 0;
    along[static_cast<std::size_t>(i)] = *of_sphere;
  }
  const auto of = [&](int sphere) -> const task::Along& {
    return along[static_cast<std::size_t>(sphere)];
  };
  const auto way = [&](int sphere) {
    return std::abs(of(sphere).way) + parameters.beside_weight * of(sphere).beside;
  };
  int chosen = now;
  for (int i = 0; i < scene.body_count; ++i) {
    if (way(i) > way(chosen) + (chosen == now ? parameters.change_margin : 0.0)) chosen = i;
  }
  // at most each sphere once: what is in the way lies ahead. One that is at its place stays there:
  // the other's place has room for both
  for (int turn = 1; turn < scene.body_count; ++turn) {
    int in_the_way = chosen;
    double nearest = parameters.room_ahead;
    for (int i = 0; i < scene.body_count; ++i) {
      const double apart = (ahead.body(i).p_WB - ahead.body(chosen).p_WB).head<2>().norm();
      const bool has_to_go = of(i).way > parameters.change_margin;
      if (has_to_go && of(i).place > of(chosen).place && apart < nearest) {
        in_the_way = i;
        nearest = apart;
      }
    }
    if (in_the_way == chosen) break;
    chosen = in_the_way;
  }
  return chosen;
}

Eigen::Vector3d end_effector_target(const HeuristicParameters& parameters, const Geometry& geometry,
                                    Phase phase, const Eigen::Vector3d& end_effector, double radius,
                                    const Eigen::Vector3d& sphere, const Eigen::Vector2d& target) {
  const double touching = geometry.table_height + 2.0 * radius + geometry.end_effector_radius;
  if (phase == Phase::kRoll) return {sphere.x(), sphere.y(), touching + parameters.roll_clearance};
  const int part = phase == Phase::kReturnUp ? 0 : phase == Phase::kReturnSideways ? 1 : 2;
  const double height = geometry.table_height + parameters.return_heights[part];
  if (phase == Phase::kReturnUp) return {end_effector.x(), end_effector.y(), height};
  const Eigen::Vector2d to_target = target - sphere.head<2>();
  const double distance = to_target.norm();
  const Eigen::Vector2d e =
      distance > 1e-9 ? Eigen::Vector2d(to_target / distance) : Eigen::Vector2d::Zero();
  const Eigen::Vector2d behind = sphere.head<2>() - parameters.return_back * e;
  return {behind.x(), behind.y(), height};
}

}  // namespace c3rt::planner
