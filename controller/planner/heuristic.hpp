#pragma once
// The time-based heuristic of Figure 10 and the state-based target of (25).
#include <Eigen/Core>

#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// The ball's next desired position on the circle, (x, y) in W [m]:
///
///   α = atan2(x − x_c, y − y_c),  x_d = x_c + r sin(α + α^l),  y_d = y_c + r cos(α + α^l)
///
/// Source: [C3, eq. (25)].
Eigen::Vector2d circle_target(const CircleTask& task, const Eigen::Vector2d& ball);

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
