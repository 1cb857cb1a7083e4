#pragma once
// What every process does the same way: its clock, its status, its share of faults and requests.
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "controller/rt/latest.hpp"
#include "controller/rt/statistics.hpp"
#include "idl/dds.hpp"

namespace c3rt::wire {

/// Paces a process. The same loop runs in realtime (absolute deadlines on CLOCK_MONOTONIC) and in lockstep
/// (simulated time over sim/tick and sim/done):
///
///   while (loop.wait(now_ns)) { take inputs; step; write outputs; }
///
/// In lockstep, wait() first answers the previous tick with Done (so everything written before counts as written in
/// it), then blocks until a tick names this process and until every reader holds the samples that the tick promises.
class Loop {
 public:
  struct Settings {
    Process process;
    std::int64_t period_ns;
    std::int64_t phase_ns = 0;  // lockstep: acts at ticks >= phase + k * period
  };
  Loop(Bus& bus, const Settings& settings);
  ~Loop();
  /// @return false when a stop was requested (signal or REQUEST_SHUTDOWN) or, in lockstep, when the plant is gone.
  bool wait(std::int64_t& now_ns);
  /// Why wait() returned false: empty for a requested stop, else a sentence ("no tick from the plant for 10 s").
  const std::string& failure() const;
  std::uint64_t missed_cycles() const noexcept;                  // realtime: periods skipped
  const rt::Statistics& wakeup_latency() const noexcept;         // realtime [s]

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// The plant's side of lockstep: publishes ticks and waits for those that are due.
class LockstepMaster {
 public:
  /// Blocks until each expected process has joined. @throws WireError naming those missing after timeout_ns.
  LockstepMaster(Bus& bus, const std::vector<Process>& expected, std::int64_t timeout_ns);
  ~LockstepMaster();
  /// Announces now_ns (after the state of now_ns was written) and waits for every process that is due.
  /// @return false after a stop request, or when a process did not answer within 30 s (see failure()).
  bool advance(std::int64_t now_ns);
  const std::string& failure() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Publishes service/status at 10 Hz from a thread of its own; the loop only sets atomics.
class StatusReporter {
 public:
  StatusReporter(Bus& bus, Process process);
  ~StatusReporter();  // publishes SERVICE_STOPPING
  void set_state(c3rt_v1_ServiceState state, std::string_view text);  // not for the servo thread
  /// A named counter (at most COUNTERS); the reference stays valid, incrementing it is wait-free.
  std::atomic<std::uint64_t>& counter(std::string_view name);
  rt::Statistics& wakeup_latency() noexcept;   // wait-free to add to
  rt::Statistics& compute() noexcept;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// SIGINT and SIGTERM set a flag; nothing else happens in the handler. Made once, first in main.
class StopFlag {
 public:
  StopFlag();
  static bool requested() noexcept;
  static void request() noexcept;
};

/// DDS -> servo thread. Realtime: a helper thread takes, the servo thread gets the newest, wait-free.
template <typename T>
class Inlet {
 public:
  explicit Inlet(Bus& bus);
  ~Inlet();
  bool take(T& out) noexcept { return latest_.take(out); }

 private:
  rt::Latest<T> latest_;
  std::atomic<bool> stop_{false};
  Reader<T> reader_;
  std::thread thread_;
};

/// Servo thread -> DDS. Realtime: put() is wait-free; a helper thread writes.
template <typename T>
class Outlet {
 public:
  explicit Outlet(Bus& bus);
  ~Outlet();
  /// Hands the sample over; the helper writes it with time_ns = time of handing over.
  void put(const T& sample, std::int64_t time_ns) noexcept;

 private:
  struct Item { T sample; std::int64_t time_ns; };
  rt::Latest<Item> latest_;
  std::atomic<bool> stop_{false};
  Writer<T> writer_;
  int event_ = -1;  // eventfd: writing to it never blocks here
  std::thread thread_;
};

}  // namespace c3rt::wire
