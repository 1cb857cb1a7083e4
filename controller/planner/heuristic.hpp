#pragma once
// The time-based heuristic of Figure 10.
#include <Eigen/Core>

#include "controller/planner/parameters.hpp"
#include "controller/planner/scene.hpp"

namespace c3rt::planner {

enum class Phase { kRoll, kReturnUp, kReturnSideways, kReturnDown };

/// The phase at `elapsed` seconds after C3 took over; a cycle begins with Phase II.
Phase phase_at(const HeuristicParameters& parameters, double elapsed);

/// The ball that the end effector is to work on: along a line the one that is farthest behind, else
/// the first. Source: [C3, section VII-B].
int ball_to_work_on(const Task& task, const Scene& scene);

/// Where the end effector is drawn to in this phase, in W [m].
/// @param ball, target the ball's centre and its desired position; part "up" keeps the end
/// effector's own x and y
Eigen::Vector3d end_effector_target(const HeuristicParameters& parameters,
                                    const model::BallModelParameters& model, Phase phase,
                                    const Eigen::Vector3d& end_effector,
                                    const Eigen::Vector3d& ball, const Eigen::Vector2d& target);

}  // namespace c3rt::planner
