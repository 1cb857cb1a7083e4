#pragma once
// What every process does the same way: its clock, its status, its share of faults and requests.
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "controller/rt/latest.hpp"
#include "controller/rt/statistics.hpp"
#include "idl/dds.hpp"

namespace c3rt::wire {

/// A new session id: larger than every one drawn before on this machine. Only the plant draws.
std::uint64_t draw_session() noexcept;

/// A flag that one thread raises without ever blocking and another one sleeps on (eventfd).
class Signal {
 public:
  Signal();
  ~Signal();
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;
  void raise() noexcept;  // RT: no heap, no lock, no throw
  /// Returns when raised since the last wait, or after the time. @return whether it was raised.
  /// RT: no heap, no lock, no throw
  bool wait(std::int64_t timeout_ns) noexcept;
  std::int64_t raised_ns() const noexcept { return raised_ns_.load(); }  // the last time

 private:
  int event_;
  std::atomic<std::int64_t> raised_ns_{0};
};

/// Paces a process. The same loop runs in realtime (absolute deadlines on CLOCK_MONOTONIC) and in
/// lockstep (simulated time over sim/tick and sim/done):
///
///   while (loop.wait(now_ns)) { take inputs; step; write outputs; }
///
/// In lockstep, wait() first answers the previous tick with Done (so everything written before
/// counts as written in it), then blocks until a tick names this process and until every reader
/// holds the samples that the tick promises. Make the readers before the first wait(): it joins the
/// run. REQUEST_SHUTDOWN is obeyed and answered here.
class Loop {
 public:
  struct Settings {
    Process process;
    std::int64_t period_ns;
    std::int64_t phase_ns = 0;                      // lockstep: acts at ticks >= phase + k * period
    std::int64_t join_timeout_ns = 60'000'000'000;  // lockstep: until the first tick
    std::int64_t gone_timeout_ns =
        10'000'000'000;  // lockstep: the plant has died, or no tick for six times this
    rt::Statistics* wakeup_latency = nullptr;  // realtime: also added here (the StatusReporter's)
    /// Realtime: a cycle answers this, at once. Where it is not raised for two periods, a timer
    /// goes on with one cycle per period. nullptr: the timer alone.
    Signal* arrival = nullptr;
  };
  Loop(Bus& bus, const Settings& settings);
  ~Loop();
  /// @return false when a stop was requested (signal or REQUEST_SHUTDOWN) or, in lockstep, when the
  /// plant is gone. RT (realtime): no heap, no lock, no throw.
  bool wait(std::int64_t& now_ns);
  /// Why wait() returned false: empty for a requested stop, else a sentence ("no tick from the
  /// plant for 10 s").
  const std::string& failure() const;
  std::uint64_t missed_cycles() const noexcept;           // realtime: periods skipped
  const rt::Statistics& wakeup_latency() const noexcept;  // realtime [s]

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// The plant's side of lockstep: publishes ticks and waits for those that are due.
class LockstepMaster {
 public:
  /// Blocks until each expected process has joined. @throws WireError naming those missing after
  /// timeout_ns. After a stop request it returns at once, and advance() does nothing. Make the
  /// plant's readers before, and write nothing before: the constructor is the start of the run.
  /// @param answer_timeout_ns how long one tick may take; a process that has died is noticed after
  /// a third of it
  LockstepMaster(Bus& bus, const std::vector<Process>& expected, std::int64_t timeout_ns,
                 std::int64_t answer_timeout_ns = 30'000'000'000);
  ~LockstepMaster();
  /// Announces now_ns (after the state of now_ns was written), waits for every process that is due,
  /// and then for what they wrote: the plant's readers hold it when this returns.
  /// @return false after a stop request, or when a process did not answer (see failure()).
  bool advance(std::int64_t now_ns);
  const std::string& failure() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Publishes service/status at 10 Hz from a thread of its own; the loop only sets atomics. What
/// goes wrong with peers and what readers refuse is told there, too.
class StatusReporter {
 public:
  /// @param log gets a sentence for every new problem with a peer and every new kind of refused
  /// samples, from the reporter's thread
  StatusReporter(Bus& bus, Process process, std::function<void(const std::string&)> log = {});
  ~StatusReporter();  // publishes SERVICE_STOPPING (a SERVICE_FAILED stays)
  void set_state(c3rt_v2_ServiceState state, std::string_view text);  // not for the servo thread
  /// A named counter; the reference stays valid, incrementing it is wait-free.
  /// @throws WireError beyond COUNTERS names or 31 letters
  std::atomic<std::uint64_t>& counter(std::string_view name);
  rt::Statistics& wakeup_latency() noexcept;  // wait-free to add to, from one thread
  rt::Statistics& compute() noexcept;         // one sample per cycle: rate_hz is counted here

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
  static void clear() noexcept;  // for a second run in one process
};

/// Gives the calling helper thread a name (at most 15 letters) and the ordinary scheduler, whatever
/// its parent has.
void become_helper_thread(const char* name) noexcept;

/// Gives the calling thread, one that carries samples, a name and SCHED_FIFO below the servo
/// threads where that is allowed: behind a busy core's ordinary threads a command would come too
/// late however punctual the servo is.
void become_bus_thread(const char* name) noexcept;

/// DDS -> servo thread, for topics with one writer. Realtime: a helper thread takes, the servo
/// thread gets the newest, wait-free. Lockstep: no thread; the samples that the tick promised are
/// taken directly.
template <typename T>
class Inlet {
 public:
  /// @param arrival is raised when a sample has come (realtime)
  explicit Inlet(Bus& bus, Signal* arrival = nullptr)
      : bus_(bus),
        arrival_(arrival),
        realtime_(bus.clock() == ClockMode::kRealtime),
        reader_(bus, 64, realtime_ ? Wakes::kItself : Wakes::kBus) {
    if (realtime_) thread_ = std::thread([this] { run(); });
  }
  ~Inlet() {
    if (!thread_.joinable()) return;
    stop_.store(true);
    reader_.interrupt();
    thread_.join();
  }
  Inlet(const Inlet&) = delete;
  Inlet& operator=(const Inlet&) = delete;

  /// Newest sample not taken before; false, and `out` untouched, if there is none or if it is of
  /// another session. RT (realtime): no heap, no lock, no throw.
  bool take(T& out) noexcept { return realtime_ ? take_latest(out) : reader_.take_newest(out); }
  /// The same, but only samples whose time has come: header.time_ns <= now_ns. Those that are early
  /// wait here. RT (realtime): no heap, no lock, no throw.
  bool take(std::int64_t now_ns, T& out) noexcept {
    if (!realtime_) return reader_.take_effective(now_ns, out);
    if (take_latest(early_[next_early_])) next_early_ = (next_early_ + 1) % kEarly;
    T* newest = nullptr;
    for (T& sample : early_) {
      if (sample.header.session_id != bus_.session_id()) sample.header.seq = 0;
      const bool due = sample.header.seq != 0 && sample.header.time_ns <= now_ns;
      if (due && (newest == nullptr || sample.header.seq > newest->header.seq)) newest = &sample;
    }
    if (newest == nullptr) return false;
    out = *newest;
    // what is older than the newest that is due will never be wanted
    for (T& sample : early_) {
      if (sample.header.seq <= out.header.seq) sample.header.seq = 0;
    }
    return true;
  }
  ReaderCounters counters() const noexcept { return reader_.counters(); }

 private:
  bool take_latest(T& out) noexcept {
    if (!latest_.take(taken_)) return false;
    if (taken_.header.session_id != bus_.session_id()) return false;
    out = taken_;
    return true;
  }
  void run() noexcept {
    become_bus_thread("inlet");
    while (!stop_.load()) {
      reader_.wait(1'000'000'000);
      // checks and refuses in this thread, as every reader does
      if (!reader_.take_newest(arrived_)) continue;
      latest_.put(arrived_);
      if (arrival_ != nullptr) arrival_->raise();
    }
  }

  Bus& bus_;
  Signal* const arrival_;
  const bool realtime_;
  rt::Latest<T> latest_;
  T arrived_{}, taken_{};  // of the helper thread, of the servo thread
  static constexpr std::size_t kEarly = 4;
  std::array<T, kEarly> early_{};  // of the servo thread: taken before their time; seq 0 = free
  std::size_t next_early_ = 0;
  std::atomic<bool> stop_{false};
  Reader<T> reader_;
  std::thread thread_;
};

/// Servo thread -> DDS. Realtime: put() is wait-free; a helper thread writes, and never skips the
/// newest. Lockstep: put() writes.
template <typename T>
class Outlet {
 public:
  explicit Outlet(Bus& bus) : realtime_(bus.clock() == ClockMode::kRealtime), writer_(bus) {
    if (realtime_) thread_ = std::thread([this] { run(); });
  }
  ~Outlet() {
    if (!thread_.joinable()) return;
    stop_.store(true);
    signal_.raise();
    thread_.join();
  }
  Outlet(const Outlet&) = delete;
  Outlet& operator=(const Outlet&) = delete;

  /// Hands the sample over; the helper writes it with this time_ns (time of handing over; in
  /// lockstep: of effect). RT (realtime): no heap, no lock, no throw.
  void put(const T& sample, std::int64_t time_ns) noexcept {
    handed_.sample = sample;
    handed_.time_ns = time_ns;
    if (!realtime_) {
      write(handed_);
      return;
    }
    latest_.put(handed_);
    signal_.raise();
  }
  std::uint64_t written() const noexcept { return writer_.seq(); }
  std::uint64_t failed() const noexcept { return failed_.load(std::memory_order_relaxed); }
  int matched_readers() const { return writer_.matched_readers(); }

 private:
  struct Item {
    T sample{};
    std::int64_t time_ns = 0;
  };
  void write(Item& item) noexcept {
    if (!writer_.write(item.sample, item.time_ns)) failed_.fetch_add(1, std::memory_order_relaxed);
  }
  void run() noexcept {
    become_bus_thread("outlet");
    while (true) {
      const bool last = stop_.load();  // what was put before the stop is still written
      while (latest_.take(writing_)) write(writing_);
      if (last) return;
      signal_.wait(1'000'000'000);
    }
  }

  const bool realtime_;
  rt::Latest<Item> latest_;
  Item handed_, writing_;  // of the servo thread, of the helper thread
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> failed_{0};
  Signal signal_;
  Writer<T> writer_;
  std::thread thread_;
};

}  // namespace c3rt::wire
