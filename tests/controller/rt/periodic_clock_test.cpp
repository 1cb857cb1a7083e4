#include "controller/rt/periodic_clock.hpp"

#include <stdexcept>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::rt;

namespace {

constexpr std::int64_t kMs = 1'000'000;

void spin_until(std::int64_t time_ns) {
  while (now_ns() < time_ns) {
  }
}

TEST_CASE("PeriodicClock: every deadline lies on the grid, and none is woken before its time") {
  const std::int64_t first_ns = now_ns();
  PeriodicClock clock(kMs, first_ns);
  std::int64_t cycle = 0;
  for (int i = 0; i < 100; ++i) {
    const Wakeup wakeup = clock.wait();
    cycle += wakeup.missed + 1;
    REQUIRE(wakeup.deadline_ns == first_ns + cycle * kMs);
    REQUIRE(wakeup.woke_ns >= wakeup.deadline_ns);
    REQUIRE(wakeup.latency_ns == wakeup.woke_ns - wakeup.deadline_ns);
  }
}

TEST_CASE(
    "PeriodicClock: a cycle late by less than a period starts at once and is not counted as "
    "missed") {
  // the grid begins in the past: the first deadline was 4 ms ago, the second is 6 ms ahead
  const std::int64_t begin_ns = now_ns();
  PeriodicClock clock(10 * kMs, begin_ns - 14 * kMs);
  const Wakeup wakeup = clock.wait();
  // only a machine that stalls for another 6 ms skips something here
  CHECK(wakeup.deadline_ns == begin_ns - 4 * kMs + wakeup.missed * 10 * kMs);
  CHECK(wakeup.missed <= (wakeup.woke_ns - (begin_ns - 4 * kMs)) / (10 * kMs));
}

TEST_CASE("PeriodicClock: whole periods that passed are counted, and the grid stays where it was") {
  const std::int64_t first_ns = now_ns();
  PeriodicClock clock(kMs, first_ns);
  const Wakeup before = clock.wait();
  spin_until(before.deadline_ns + 5 * kMs + kMs / 2);
  const Wakeup after = clock.wait();
  // deadlines 1 to 4 after `before` are over by a whole period; the fifth is late by half of one
  CHECK(after.missed >= 4);
  CHECK(after.deadline_ns == before.deadline_ns + (after.missed + 1) * kMs);
  CHECK((after.deadline_ns - first_ns) % kMs == 0);
}

TEST_CASE("PeriodicClock: a period of nothing is refused") {
  CHECK_THROWS_AS(PeriodicClock(0), std::invalid_argument);
  CHECK_THROWS_AS(PeriodicClock(-kMs), std::invalid_argument);
}

TEST_CASE("PeriodicClock: wait does not allocate") {
  PeriodicClock clock(kMs / 10);
  std::int64_t heap_calls = -1;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 50; ++i) (void)clock.wait();
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
}

}  // namespace
