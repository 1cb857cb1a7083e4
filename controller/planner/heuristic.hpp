#pragma once
// The time-based heuristic of Figure 10.
#include <Eigen/Core>

#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

enum class Phase { kRoll, kReturnUp, kReturnSideways, kReturnDown };

/// The phase at `elapsed` seconds after C3 took over; a cycle begins with Phase II.
Phase phase_at(const HeuristicParameters& parameters, double elapsed);

/// Where the end effector is drawn to in this phase, in W [m].
/// @param ball, target the ball's centre and its desired position; part "up" keeps the end
/// effector's own x and y
Eigen::Vector3d end_effector_target(const HeuristicParameters& parameters,
                                    const model::BallModelParameters& model, Phase phase,
                                    const Eigen::Vector3d& end_effector,
                                    const Eigen::Vector3d& ball, const Eigen::Vector2d& target);

}  // namespace c3rt::planner
