#pragma once
// Who else is on the bus, as discovery tells it.
#include <string>
#include <vector>

#include "idl/dds.hpp"

namespace c3rt::wire {

/// A reader or writer of another participant.
struct PeerEndpoint {
  std::string topic, type;
  bool is_writer = false;
  std::string process, host;  // "c3rt-plant"; "" where it does not tell
  int pid = 0;
  std::string qos;  // "best effort, volatile, deadline 20 ms"
};

/// All that are known now: those of a participant that has just been made are not yet.
std::vector<PeerEndpoint> peer_endpoints(const Bus& bus);

/// Readers and writers of other participants on our topics that can never be served by each other:
/// other types, or QoS that does not fit.
std::vector<PeerProblem> peer_disagreements(const Bus& bus);

/// Of this host, as participants tell it.
std::string host_name();

/// The QoS that our own writers offer and our own readers ask for in realtime: what a client has to
/// match.
std::string offered_qos(const Topic& topic);
std::string requested_qos(const Topic& topic);

}  // namespace c3rt::wire
