#pragma once
// Pushes one body to its goal from one place: behind it, as seen from the goal. C3 pushes; where
// the body is no longer between end effector and goal, the end effector goes round it.
#include <memory>

#include "controller/planner/strategy/strategy.hpp"

namespace c3rt::planner {

/// Where to begin: behind the body as seen from the goal, this far off its surface, in W [m].
/// @param height of the end effector in W [m]
Eigen::Vector3d behind(const scene::Body& body, const Eigen::Vector2d& goal,
                       const PushParameters& parameters, double end_effector_radius, double height);

/// What errors weigh more with as the goal comes near: else the other weights stop the body before
/// it is there.
double near_goal_gain(double distance, double angle);

std::unique_ptr<Strategy> make_push(const Parameters& parameters, C3Controller& c3);

}  // namespace c3rt::planner
