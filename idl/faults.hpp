#pragma once
// Which faults can be injected, into which process and how far: one answer for the processes and
// for who asks them.
#include <string>
#include <vector>

#include "idl/topics.hpp"

namespace c3rt::wire {

/// What the scenario has that a fault can be about. Empty where that is not known: then only what
/// no scenario could do is refused.
struct FaultScope {
  std::vector<double> ball_masses;  // [kg]
  int cameras = -1;                 // negative: not known
};

constexpr double kLongestFault = 3600.0;  // [s]
constexpr double kHardestPush = 3.0;      // of a ball's speed [m/s]

/// Whether the process has this fault and the numbers are ones that it can do.
/// @return what was expected and what came; empty if nothing is wrong
std::string refusal(const FaultInject& fault, const FaultScope& scope);

/// "push-ball 0 by (0.005, 0, 0) N s", "stall for 2 s"
std::string describe(const FaultInject& fault);

/// "push-ball"; "?" for no kind.
const char* fault_name(c3rt_v2_FaultKind kind);

}  // namespace c3rt::wire
