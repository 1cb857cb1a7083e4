#pragma once
// What the planner is given in one period.
#include <array>
#include <limits>

#include "controller/planner/target.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

/// What is known of one body.
struct BodyInput {
  bool seen = false;  // by vision, at the exposure; else it is where it was last seen
  double age = std::numeric_limits<double>::infinity();  // since the exposure; before the first [s]
  scene::Body body;                                      // at the exposure
};

struct Input {
  double now;        // session time [s]
  double state_age;  // of what follows; infinite before the first [s]
  scene::Effector effector;
  std::array<BodyInput, scene::kMaxBodies> bodies;  // the first ModelParameters::bodies of them
  bool robot_follows = true;                        // it moves, and its controller tracks the plans
  bool stopped;                                     // a person has stopped the robot
  Target target;                                    // a client's
  double solve_time;  // duration of the previous solve [s], for DeltaTcSource::kSolveTime
};

}  // namespace c3rt::planner
