#pragma once
// Moves one body to its goal with C3 from wherever that is best, without a schedule of contacts:
// places for the end effector are drawn about the body, each is planned from and the plan is tried,
// and the end effector goes through free space to the best, or stays where it is.
#include <memory>

#include "controller/planner/strategy/strategy.hpp"

namespace c3rt::planner {

/// What errors weigh more with as the goal comes near: else the other weights stop the body before
/// it is there.
double gain_near_goal(double distance, double angle);

std::unique_ptr<Strategy> make_sampling(const Parameters& parameters, C3Controller& c3);

}  // namespace c3rt::planner
