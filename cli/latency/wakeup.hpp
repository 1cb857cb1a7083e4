#pragma once
// How late the kernel wakes periodic threads: our loop beside bare ones, at the same time.
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "cli/latency/analysis.hpp"

namespace c3rt::cli::latency {

/// Wakes every millisecond from first_ns on, paced as the servo's timer (rt::PeriodicClock) or by
/// bare clock_nanosleep as cyclictest, until `room` is full or `stop`. RT: no heap, no lock, no
/// throw.
/// @return how many wake-ups were written
std::size_t measure_loop(std::vector<Wakeup>& room, std::int64_t first_ns,
                         const std::atomic<bool>& stop) noexcept;
std::size_t measure_reference(std::vector<Wakeup>& room, std::int64_t first_ns,
                              const std::atomic<bool>& stop) noexcept;

/// What the threads have measured.
struct WakeupRecord {
  std::vector<Wakeup> loop;                     // paced as the servo's timer: rt::PeriodicClock
  std::vector<std::vector<Wakeup>> references;  // bare clock_nanosleep, one bound to each core
  std::string refused;                          // of the priority; empty: granted
  /// Of all references together [s].
  std::vector<double> reference_latencies() const;
};

/// Threads of the servo's period and priority that do nothing but wake, each at another time of the
/// period. After the start they allocate, lock and log nothing.
class WakeupProbe {
 public:
  /// @param duration_s room for so many samples; then a thread ends
  /// @param fifo_priority SCHED_FIFO 1 … 99, where it is allowed
  WakeupProbe(double duration_s, int fifo_priority);
  ~WakeupProbe();  // ends the threads
  WakeupProbe(const WakeupProbe&) = delete;
  WakeupProbe& operator=(const WakeupProbe&) = delete;

  /// Ends the threads and hands out what they measured.
  WakeupRecord stop();

 private:
  struct Lane;
  void join();
  std::atomic<bool> stop_{false};
  std::vector<std::unique_ptr<Lane>> lanes_;  // the loop first
};

/// Ordinary threads that compute without an end, one core each.
class Load {
 public:
  explicit Load(int threads);
  ~Load();
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace c3rt::cli::latency
