#pragma once
// Bad lines between the nodes of a run in one process.
#include <cstdint>
#include <string_view>

#include "cli/chaos/schedule.hpp"
#include "idl/exchange.hpp"

namespace c3rt::cli::chaos {

/// @param fault of an edge
/// @param bus the reader's: Bus::identity()
void set_line(wire::Exchange& exchange, const Fault& fault, std::uint64_t bus);
/// It is a good line again.
void clear_line(wire::Exchange& exchange, const Fault& fault, std::uint64_t bus);

/// An edge by its name. @return nullptr if there is none
const Edge* edge_of(std::string_view name);

}  // namespace c3rt::cli::chaos
