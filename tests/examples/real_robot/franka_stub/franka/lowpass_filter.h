#pragma once
// Of the stub: robot.h.

namespace franka {

constexpr double kMaxCutoffFrequency = 1000.0;

}  // namespace franka
