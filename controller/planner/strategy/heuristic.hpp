#pragma once
// The time-based heuristic of Figure 10.
#include <Eigen/Core>

#include "controller/planner/parameters.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

enum class Phase { kRoll, kReturnUp, kReturnSideways, kReturnDown };

/// The phase at `elapsed` seconds after C3 took over; a cycle begins with Phase II.
Phase phase_at(const HeuristicParameters& parameters, double elapsed);

/// The sphere that the end effector is to work on in the next cycle. Along a line it is the one
/// that has the farthest way to its place, the way to the line included [C3, section VII-B: the one
/// that is farthest behind], but the one in its way if there is one that is not at its place yet.
/// Of other tasks it is the first.
/// @param now the one that is worked on: another one has to be worth the change
int sphere_to_work_on(const HeuristicParameters& parameters, const task::Task& task,
                      const scene::Scene& scene, int now);

/// Where the end effector is drawn to in this phase, in W [m].
/// @param radius of the sphere that is worked on [m]
/// @param sphere, target its centre and its desired position; part "up" keeps the end effector's
/// own x and y
Eigen::Vector3d end_effector_target(const HeuristicParameters& parameters, const Geometry& geometry,
                                    Phase phase, const Eigen::Vector3d& end_effector, double radius,
                                    const Eigen::Vector3d& sphere, const Eigen::Vector2d& target);

}  // namespace c3rt::planner
