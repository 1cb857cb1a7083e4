#include "cli/latency/wakeup.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>

#include <pthread.h>
#include <sched.h>

#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"

namespace c3rt::cli::latency {
namespace {

constexpr std::int64_t kFirst_ns = 20'000'000;  // until every thread stands ready
constexpr std::size_t kMostReferences = 8;
constexpr double kSlack_s = 2.0;  // of the room for samples

/// The cores that this process may use, as many as get a reference thread.
std::vector<int> cores() {
  std::vector<int> all;
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) {
    for (int cpu = 0; cpu < CPU_SETSIZE && all.size() < kMostReferences; ++cpu) {
      if (CPU_ISSET(cpu, &set)) all.push_back(cpu);
    }
  }
  return all;
}

/// As cyclictest does: sleeps until an absolute time, reads the clock. RT: no heap, no lock, no
/// throw.
Wakeup bare_wait(std::int64_t& deadline_ns) noexcept {
  deadline_ns += kPeriod_ns;
  // whole cycles that have passed already are skipped
  if (const std::int64_t late_ns = rt::now_ns() - deadline_ns; late_ns > 0)
    deadline_ns += late_ns / kPeriod_ns * kPeriod_ns;
  const timespec at{static_cast<std::time_t>(deadline_ns / 1'000'000'000),
                    static_cast<long>(deadline_ns % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
  }
  return {deadline_ns, rt::now_ns() - deadline_ns};
}

}  // namespace

std::size_t measure_loop(std::vector<Wakeup>& room, std::int64_t first_ns,
                         const std::atomic<bool>& stop) noexcept {
  rt::PeriodicClock clock(kPeriod_ns, first_ns);
  std::size_t count = 0;
  while (count < room.size() && !stop.load(std::memory_order_relaxed)) {
    const rt::Wakeup woke = clock.wait();
    room[count++] = {woke.deadline_ns, woke.latency_ns};
  }
  return count;
}

std::size_t measure_reference(std::vector<Wakeup>& room, std::int64_t first_ns,
                              const std::atomic<bool>& stop) noexcept {
  std::int64_t at_ns = first_ns;
  std::size_t count = 0;
  while (count < room.size() && !stop.load(std::memory_order_relaxed))
    room[count++] = bare_wait(at_ns);
  return count;
}

/// One thread and what it has seen.
struct WakeupProbe::Lane {
  int core = -1;  // of a reference; -1: the loop, anywhere
  std::vector<Wakeup> wakeups;
  std::size_t count = 0;
  std::string refused;
  std::thread thread;

  void run(const std::atomic<bool>& stop, std::int64_t first_ns, int priority) {
    pthread_setname_np(pthread_self(), core < 0 ? "loop" : "reference");
    rt::ThreadSettings settings;
    settings.fifo_priority = priority;
    if (core >= 0) settings.cpus = {core};
    refused = rt::setup_thread(settings);
    count = core < 0 ? measure_loop(wakeups, first_ns, stop)
                     : measure_reference(wakeups, first_ns, stop);
  }
};

WakeupProbe::WakeupProbe(double duration_s, int fifo_priority) {
  const auto room =
      static_cast<std::size_t>(std::llround((duration_s + kSlack_s) * 1e9 / kPeriod_ns));
  std::vector<int> all{-1};
  for (const int core : cores()) all.push_back(core);
  for (const int core : all) {
    lanes_.push_back(std::make_unique<Lane>());
    lanes_.back()->core = core;
    // written once, so that no page is missing later
    lanes_.back()->wakeups.assign(room, Wakeup{1, 1});
  }
  const std::int64_t first_ns = rt::now_ns() + kFirst_ns;
  const auto lanes = static_cast<std::int64_t>(lanes_.size());
  std::int64_t phase_ns = 0;
  for (const auto& lane : lanes_) {
    lane->thread = std::thread([this, &lane = *lane, at_ns = first_ns + phase_ns, fifo_priority] {
      lane.run(stop_, at_ns, fifo_priority);
    });
    phase_ns += kPeriod_ns / lanes;
  }
}

WakeupProbe::~WakeupProbe() { join(); }

void WakeupProbe::join() {
  stop_.store(true);
  for (const auto& lane : lanes_) {
    if (lane->thread.joinable()) lane->thread.join();
  }
}

WakeupRecord WakeupProbe::stop() {
  join();
  WakeupRecord record;
  for (const auto& lane : lanes_) {
    lane->wakeups.resize(lane->count);
    if (lane->core < 0) {
      record.refused = lane->refused;
      record.loop = std::move(lane->wakeups);
    } else {
      record.references.push_back(std::move(lane->wakeups));
    }
  }
  return record;
}

std::vector<double> WakeupRecord::reference_latencies() const {
  std::vector<double> all;
  for (const std::vector<Wakeup>& reference : references) {
    const std::vector<double> one = latencies_of(reference);
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

Load::Load(int threads) {
  for (int i = 0; i < threads; ++i) {
    threads_.emplace_back([this] {
      volatile double value = 1.0;
      while (!stop_.load(std::memory_order_relaxed)) {
        for (int k = 0; k < 1000; ++k) value = std::sqrt(value + 1.0);
      }
    });
  }
}

Load::~Load() {
  stop_.store(true);
  for (std::thread& thread : threads_) thread.join();
}

}  // namespace c3rt::cli::latency
