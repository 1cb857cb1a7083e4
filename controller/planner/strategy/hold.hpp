#pragma once
// A strategy that holds the end effector where it is, out of the bodies' way.
#include <memory>

#include "controller/planner/strategy/strategy.hpp"

namespace c3rt::planner {

std::unique_ptr<Strategy> make_hold(const Parameters& parameters, C3Controller& c3);

}  // namespace c3rt::planner
