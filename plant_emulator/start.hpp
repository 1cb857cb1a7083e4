#pragma once
// Where a run begins: what the scenario leaves to the seed.
#include <cstdint>

#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

/// The same world with table_tilt in a direction that is drawn from the seed, if it is to be drawn,
/// and likewise the ball's friction.
World drawn_table(World world, std::uint64_t seed);

/// The same plant on its drawn table with every ball moved by a draw, uniform on the disc of radius
/// BallParameters::start_spread about its position. A seed draws the same for a ball whatever the
/// spread of the others.
Parameters drawn_start(Parameters parameters, std::uint64_t seed);

}  // namespace c3rt::plant
