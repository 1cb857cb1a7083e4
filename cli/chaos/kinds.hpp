#pragma once
// Everything that chaos can do to a run, in one table. A new kind is a line here and its case where
// it acts: lines.cpp on samples, simulated.cpp and realtime.cpp on processes.
#include <string>
#include <string_view>
#include <vector>

#include "idl/topics.hpp"

namespace c3rt::cli::chaos {

/// What a fault does.
enum class Act {
  kKill,         // the process is gone at once and is started again
  kKillService,  // kill -9 of the supervisor, and with it all four; as systemd starts it again
  kStop,         // it stands still, as under SIGSTOP, and goes on
  kInject,       // what the process itself offers: c3rt fault
  kDelay,        // samples of an edge come later; amount: by [s]
  kDrop,         // are lost; amount: share
  kDuplicate,    // come twice, the second time later; amount: share
  kReorder,      // come later by a time of their own each; amount: at most [s]
  kSpoil,        // have a NaN; amount: share
  kShiftClock,   // have the stamps of a clock that has jumped; amount: by [s], of either sign
  kShiftObject,  // tell the object elsewhere; amount: by [m]
  kDouble,       // somebody else writes a topic, too; amount: so many a second
  kFlood,        // somebody asks what nobody grants; amount: so many times a second
  kFillDisk,     // nothing more can be written into the run's folder
};

/// Where a kind is offered.
enum Where : unsigned { kRealtime = 1, kSimulated = 2 };

struct Kind {
  std::string_view name;
  Act act;
  c3rt_v2_FaultKind injected;  // of kInject
  unsigned where;
  std::vector<std::string_view> targets;  // processes, edges or topics; one is drawn
  std::vector<double> durations;          // one is drawn [s]; empty: it is over at once
  double least, most;                     // of its amount; its logarithm is uniform
  std::string_view says;
  bool if_named = false;  // not among those that are drawn where nobody names kinds
};

const std::vector<Kind>& kinds();

/// From a topic to a reader, where lines can be bad.
struct Edge {
  std::string_view name;  // "state-to-planner"
  const wire::Topic* topic;
  wire::Process reader;
};
const std::vector<Edge>& edges();

/// What a person chose: a kind, and of its targets all or one.
struct Choice {
  const Kind* kind;
  std::vector<std::string_view> targets;
};

/// What the machine and the scenario have.
struct Offer {
  Where where;
  int cameras;              // 0: no camera can fail
  bool small_disk = false;  // results go to a file system that may be filled
};

/// @param list "kill,stop:planner"; empty: every kind that is offered
/// @throws UsageError that names what is offered, or where a kind is
std::vector<Choice> choose(const std::string& list, const Offer& offer);

/// The table for --help.
std::string kinds_text();

/// A process by its name. @pre it is one
wire::Process process_of(std::string_view name);

}  // namespace c3rt::cli::chaos
