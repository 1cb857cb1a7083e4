#include "controller/planner/heuristic.hpp"

#include <cmath>

namespace c3rt::planner {

Phase phase_at(const HeuristicParameters& parameters, double elapsed) {
  const double in_cycle = std::fmod(elapsed, parameters.return_duration + parameters.roll_duration);
  if (in_cycle >= parameters.return_duration) return Phase::kRoll;
  const double part = 3.0 * in_cycle / parameters.return_duration;
  return part < 1.0 ? Phase::kReturnUp : part < 2.0 ? Phase::kReturnSideways : Phase::kReturnDown;
}

int ball_to_work_on(const Task& task, const Scene& scene) {
  const auto* line = std::get_if<LineTask>(&task);
  if (line == nullptr) return 0;
  const double forward = line->step < 0.0 ? -1.0 : 1.0;
  int last = 0;
  for (int i = 1; i < scene.ball_count; ++i) {
    const auto y = [&](int ball) { return scene.balls[static_cast<std::size_t>(ball)].p_WB.y(); };
    if (forward * y(i) < forward * y(last)) last = i;
  }
  return last;
}

Eigen::Vector3d end_effector_target(const HeuristicParameters& parameters,
                                    const model::BallModelParameters& model, Phase phase,
                                    const Eigen::Vector3d& end_effector,
                                    const Eigen::Vector3d& ball, const Eigen::Vector2d& target) {
  const double touching = model.table_height + 2.0 * model.ball_radius + model.end_effector_radius;
  if (phase == Phase::kRoll) return {ball.x(), ball.y(), touching + parameters.roll_clearance};
  const int part = phase == Phase::kReturnUp ? 0 : phase == Phase::kReturnSideways ? 1 : 2;
  const double height = model.table_height + parameters.return_heights[part];
  if (phase == Phase::kReturnUp) return {end_effector.x(), end_effector.y(), height};
  const Eigen::Vector2d to_target = target - ball.head<2>();
  const double distance = to_target.norm();
  const Eigen::Vector2d e =
      distance > 1e-9 ? Eigen::Vector2d(to_target / distance) : Eigen::Vector2d::Zero();
  const Eigen::Vector2d behind = ball.head<2>() - parameters.return_back * e;
  return {behind.x(), behind.y(), height};
}

}  // namespace c3rt::planner
