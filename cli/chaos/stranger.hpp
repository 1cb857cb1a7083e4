#pragma once
// Somebody else on the bus: writes what one of the four writes, or more than anybody can read.
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "cli/chaos/schedule.hpp"
#include "idl/dds.hpp"

namespace c3rt::cli::chaos {

class Stranger {
 public:
  /// @param fault of Act::kDouble or Act::kFlood; its target is a topic
  /// @throws wire::WireError
  Stranger(wire::Bus& bus, const Fault& fault);
  /// Writes what is due since the last call.
  void speak(std::int64_t now_ns) { speak_(now_ns); }

 private:
  std::function<void(std::int64_t)> speak_;
};

/// Topics that a second writer can be on, and those that can be flooded.
const std::vector<std::string_view>& doubled_topics();
const std::vector<std::string_view>& flooded_topics();

}  // namespace c3rt::cli::chaos
