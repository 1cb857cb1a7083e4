#include "controller/planner/heuristic.hpp"

#include <cmath>

namespace c3rt::planner {

Phase phase_at(const HeuristicParameters& parameters, double elapsed) {
  const double in_cycle = std::fmod(elapsed, parameters.return_duration + parameters.roll_duration);
  if (in_cycle >= parameters.return_duration) return Phase::kRoll;
  const double part = 3.0 * in_cycle / parameters.return_duration;
  return part < 1.0 ? Phase::kReturnUp : part < 2.0 ? Phase::kReturnSideways : Phase::kReturnDown;
}

int balls_behind(const LineTask& task, const scene::Scene& scene, int ball) {
  const auto place = [&](int i) {
    return forward(task) * scene.body(i).p_WB.y();
  };
  int behind = 0;
  for (int i = 0; i < scene.body_count; ++i) behind += place(i) < place(ball) ? 1 : 0;
  return behind;
}

int ball_to_work_on(const HeuristicParameters& parameters, const Task& task, const scene::Scene& scene,
                    int now) {
  const auto* line = std::get_if<LineTask>(&task);
  if (line == nullptr) return 0;
  scene::Scene ahead = scene;
  for (scene::Body& ball : ahead.bodies) ball.p_WB += parameters.look_ahead * ball.v_WB;
  const auto place = [&](int ball) -> Eigen::Vector2d {
    return ahead.body(ball).p_WB.head<2>();
  };
  const auto along = [&](int ball) {
    return way_to_go(*line, place(ball), balls_behind(*line, ahead, ball));
  };
  const auto way = [&](int ball) {
    return std::abs(along(ball)) + parameters.beside_weight * std::abs(place(ball).x() - line->x);
  };
  int chosen = now;
  for (int i = 0; i < scene.body_count; ++i) {
    if (way(i) > way(chosen) + (chosen == now ? parameters.change_margin : 0.0)) chosen = i;
  }
  // at most each ball once: what is in the way lies ahead. One that is at its place stays there:
  // the other's place has room for both
  for (int turn = 1; turn < scene.body_count; ++turn) {
    int in_the_way = chosen;
    double nearest = parameters.room_ahead;
    for (int i = 0; i < scene.body_count; ++i) {
      const Eigen::Vector2d apart = place(i) - place(chosen);
      const bool has_to_go = along(i) > parameters.change_margin;
      if (has_to_go && forward(*line) * apart.y() > 0.0 && apart.norm() < nearest) {
        in_the_way = i;
        nearest = apart.norm();
      }
    }
    if (in_the_way == chosen) break;
    chosen = in_the_way;
  }
  return chosen;
}

Eigen::Vector3d end_effector_target(const HeuristicParameters& parameters,
                                    const Geometry& geometry, Phase phase,
                                    const Eigen::Vector3d& end_effector,
                                    const Eigen::Vector3d& ball, const Eigen::Vector2d& target) {
  const double touching = geometry.table_height + 2.0 * geometry.ball_radius + geometry.end_effector_radius;
  if (phase == Phase::kRoll) return {ball.x(), ball.y(), touching + parameters.roll_clearance};
  const int part = phase == Phase::kReturnUp ? 0 : phase == Phase::kReturnSideways ? 1 : 2;
  const double height = geometry.table_height + parameters.return_heights[part];
  if (phase == Phase::kReturnUp) return {end_effector.x(), end_effector.y(), height};
  const Eigen::Vector2d to_target = target - ball.head<2>();
  const double distance = to_target.norm();
  const Eigen::Vector2d e =
      distance > 1e-9 ? Eigen::Vector2d(to_target / distance) : Eigen::Vector2d::Zero();
  const Eigen::Vector2d behind = ball.head<2>() - parameters.return_back * e;
  return {behind.x(), behind.y(), height};
}

}  // namespace c3rt::planner
