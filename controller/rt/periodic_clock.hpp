#pragma once
// Time and pace of a real-time thread.
#include <cstdint>

namespace c3rt::rt {

/// CLOCK_MONOTONIC of this host [ns]: the session's clock in realtime. RT: no heap, no lock, no
/// throw.
std::int64_t now_ns() noexcept;

/// What PeriodicClock::wait() saw.
struct Wakeup {
  std::int64_t deadline_ns;  // the grid point that this cycle belongs to
  std::int64_t woke_ns;      // now
  std::int64_t latency_ns;   // woke - deadline
  std::int64_t missed;       // whole cycles skipped before this one
};

/// Ticks on a fixed grid of CLOCK_MONOTONIC: deadlines are absolute, so lateness never accumulates.
///
/// A cycle that is late by less than a period starts at once; one that is later is skipped and
/// counted.
class PeriodicClock {
 public:
  /// The grid is first_ns + k * period_ns, k = 1, 2, ...
  /// @throws std::invalid_argument unless period_ns > 0
  explicit PeriodicClock(std::int64_t period_ns, std::int64_t first_ns = now_ns());

  /// Sleeps until the next grid point. RT: no heap, no lock, no throw.
  Wakeup wait() noexcept;

 private:
  std::int64_t period_ns_;
  std::int64_t deadline_ns_;
};

}  // namespace c3rt::rt
