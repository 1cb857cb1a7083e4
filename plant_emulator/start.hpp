#pragma once
// Where a run begins: what the scenario leaves to the seed.
#include <cstdint>

#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

/// The same world with table_tilt in a direction that is drawn from the seed, if it is to be drawn,
/// and likewise the objects' friction.
World drawn_table(World world, std::uint64_t seed);

/// The same plant on its drawn table with every object moved by a draw: uniform on the disc of
/// radius start_spread about its position or on the rectangle of start_spread_xy, and turned,
/// uniform within yaw_spread. A seed draws the same for an object whatever the spread of the
/// others.
Parameters drawn_start(Parameters parameters, std::uint64_t seed);

}  // namespace c3rt::plant
