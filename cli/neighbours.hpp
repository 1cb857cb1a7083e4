#pragma once
// Instances that our own locks know nothing of: another user's, another XDG_RUNTIME_DIR's, another
// host's, or processes started by hand. Seen on the bus.
#include <map>
#include <string>
#include <vector>

#include "idl/dds.hpp"

namespace c3rt::cli {

/// A process of a plant's loop that lives on this domain.
struct Neighbour {
  std::string process, host, user;  // what is not known is empty
  int pid = 0;

  /// "c3rt-plant (pid 12, user ada)", with the host where that is another one
  std::string text() const;
};

/// Who writes each topic now, as far as discovery knows: one that lives, or is on another host.
std::map<std::string, Neighbour> writers(const wire::Bus& bus);

/// Listens until one is known for certain to live, or for `seconds`: what has died is not told.
std::vector<Neighbour> neighbours(const wire::Bus& bus, double seconds);

/// "c3rt-plant (pid 12, user ada), c3rt-planner (pid 14, user ada)"
std::string text(const std::vector<Neighbour>& all);

/// How long discovery may take on one host or in one network [s]
constexpr double kLookForNeighbours = 0.7;

}  // namespace c3rt::cli
