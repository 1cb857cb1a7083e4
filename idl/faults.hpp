#pragma once
// Which faults can be injected, into which process and how far: one answer for the processes and
// for who asks them.
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "idl/topics.hpp"

namespace c3rt::wire {

/// What the scenario has that a fault can be about. Empty where that is not known: then only what
/// no scenario could do is refused.
struct FaultScope {
  std::vector<double> object_masses;  // [kg]
  int cameras = -1;                   // negative: not known
};

constexpr double kLongestFault = 3600.0;  // [s]
constexpr double kHardestPush = 3.0;      // of an object's speed [m/s]

/// Whether the process has this fault and the numbers are ones that it can do.
/// @return what was expected and what came; empty if nothing is wrong
std::string refusal(const FaultInject& fault, const FaultScope& scope);

/// "push-object 0 by (0.005, 0, 0) N s", "stall for 2 s"
std::string describe(const FaultInject& fault);

/// "push-object"; "?" for no kind.
const char* fault_name(c3rt_v2_FaultKind kind);

/// Until when a process takes and sends nothing (stall), and until when what it sends is spoilt
/// (NaN). One thread begins them, another one may ask.
class FaultWindows {
 public:
  /// Of a fault that was let in; other kinds change nothing, FAULT_NONE ends both.
  void begin(const FaultInject& fault, std::int64_t now_ns) noexcept;
  // RT: no heap, no lock, no throw
  bool stalls(std::int64_t now_ns) const noexcept { return now_ns < stall_until_ns_.load(); }
  bool spoils(std::int64_t now_ns) const noexcept { return now_ns < nan_until_ns_.load(); }

 private:
  std::atomic<std::int64_t> stall_until_ns_{0}, nan_until_ns_{0};
};

/// The instant at which a fault that begins now ends.
std::int64_t end_of(const FaultInject& fault, std::int64_t now_ns) noexcept;

}  // namespace c3rt::wire
