#pragma once
// The table from above, without a graphics library: a ray of MuJoCo's for each pixel.
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "plant_emulator/plant.hpp"

namespace c3rt::plant {

/// A picture as on a map of W turned by a quarter: x to the top, y to the left, each pixel red
/// green blue, by rows from the top. The arm is left out; the end effector's sphere is drawn over
/// what is below it.
/// @param of that it shows, in W [m]  @param width, height [px], positive
std::vector<std::uint8_t> top_view(const Plant& plant, const Eigen::AlignedBox2d& of, int width,
                                   int height);

}  // namespace c3rt::plant
