#include "cli/latency/wakeup.hpp"

#include <chrono>
#include <thread>

#include <catch2/catch.hpp>

#include "controller/rt/periodic_clock.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt::cli::latency;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

/// Every deadline lies later than the one before, on the grid of the first.
bool on_a_grid(const std::vector<Wakeup>& wakeups) {
  for (std::size_t i = 1; i < wakeups.size(); ++i) {
    const std::int64_t step_ns = wakeups[i].deadline_ns - wakeups[i - 1].deadline_ns;
    if (step_ns <= 0 || step_ns % kPeriod_ns != 0) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("measuring a wake-up allocates nothing, and ends with its room or when it is told to") {
  const std::atomic<bool> go_on{false}, stop{true};
  for (const auto measure : {measure_loop, measure_reference}) {
    std::vector<Wakeup> room(20);
    std::size_t count = 0;
    std::int64_t heap_calls = 0;
    {
      const c3rt::support::AllocationCounter heap;
      count = measure(room, c3rt::rt::now_ns(), go_on);
      heap_calls = heap.count();
    }
    CHECK(heap_calls == 0);
    CHECK(count == room.size());
    CHECK(on_a_grid(room));
    CHECK(measure(room, c3rt::rt::now_ns(), stop) == 0);
  }
}

TEST_CASE("WakeupProbe: loop and references wake on grids of 1 ms, never before their time") {
  WakeupProbe probe(0.3, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const WakeupRecord record = probe.stop();
  CHECK(record.refused.empty());  // no priority was asked for
  REQUIRE(!record.references.empty());
  std::vector<std::vector<Wakeup>> all = record.references;
  all.push_back(record.loop);
  for (const std::vector<Wakeup>& lane : all) {
    REQUIRE(lane.size() > 1);
    CHECK(on_a_grid(lane));
    for (const Wakeup& wakeup : lane) REQUIRE(wakeup.latency_ns >= 0);
  }
  std::size_t count = 0;
  for (const std::vector<Wakeup>& reference : record.references) count += reference.size();
  CHECK(record.reference_latencies().size() == count);
}

TEST_CASE(
    "WakeupProbe: a thread ends when its room is full, and one that is dropped ends its threads") {
  const WakeupProbe dropped(3600.0, 0);
  WakeupProbe probe(-1.9, 0);  // room for a tenth of a second
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  CHECK(probe.stop().loop.size() <= 100);
}
