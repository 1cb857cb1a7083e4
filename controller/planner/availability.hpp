#pragma once
// What of an input can be used, and why the rest cannot.
#include "controller/planner/activity.hpp"
#include "controller/planner/input.hpp"
#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// The first thing that cannot be used: the robot's state, or a body.
struct Availability {
  Cause cause;   // kNone: all of it can
  int body = 0;  // of a cause that is a body's
  bool state() const noexcept;
  bool all() const noexcept { return cause == Cause::kNone; }
};

Availability available(const Parameters& parameters, const Input& input) noexcept;

/// Whether it is known where a body is, be it within reach or not.
bool in_view(const Parameters& parameters, const BodyInput& body) noexcept;

}  // namespace c3rt::planner
