#pragma once
// The hand that pushes the objects now and then: when, which and how hard, drawn from the seed.
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace c3rt::plant {

struct PushParameters {
  int count = 0;
  double from = 0.0, until = 0.0;               // of the plant's time [s]
  double impulse_min = 0.0, impulse_max = 0.0;  // [N s]
};

struct Push {
  double time;  // of the plant [s]
  int object;
  Eigen::Vector3d impulse;  // level [N s]
};

/// The time is cut into `count` equal pieces; each has its push at a random instant of its first
/// half, so that at least half a piece is between two. Object, direction and size are uniform.
/// @return in order of time
std::vector<Push> drawn_pushes(const PushParameters& parameters, int objects, std::uint64_t seed);

}  // namespace c3rt::plant
