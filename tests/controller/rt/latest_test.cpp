#include "controller/rt/latest.hpp"

#include <array>
#include <thread>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::rt;

namespace {

// large enough that a torn copy shows: every number of a value is the same
using Value = std::array<std::int64_t, 64>;

Value filled(std::int64_t number) {
  Value value;
  value.fill(number);
  return value;
}

TEST_CASE("Latest: gives the newest value once, and leaves the output alone when there is none") {
  Latest<int> latest;
  int out = 7;
  CHECK_FALSE(latest.take(out));
  CHECK(out == 7);
  latest.put(1);
  latest.put(2);
  latest.put(3);
  REQUIRE(latest.take(out));
  CHECK(out == 3);
  CHECK_FALSE(latest.take(out));
  latest.put(4);
  REQUIRE(latest.take(out));
  CHECK(out == 4);
}

TEST_CASE(
    "Latest: between two threads no value is torn, none comes twice, and the last one arrives") {
  constexpr std::int64_t kValues = 300'000;
  Latest<Value> latest;
  std::thread writer([&] {
    for (std::int64_t i = 1; i <= kValues; ++i) latest.put(filled(i));
  });
  Value out = filled(0);
  std::int64_t previous = 0, torn = 0, backwards = 0;
  while (previous < kValues) {
    if (!latest.take(out)) continue;
    if (out != filled(out[0])) ++torn;
    if (out[0] <= previous) ++backwards;
    previous = out[0];
  }
  writer.join();
  CHECK(torn == 0);
  CHECK(backwards == 0);
  CHECK_FALSE(latest.take(out));
}

TEST_CASE("Latest: put and take do not allocate") {
  Latest<Value> latest;
  Value out = filled(0);
  std::int64_t heap_calls = -1;
  bool all = true;
  {
    const support::AllocationCounter heap;
    for (std::int64_t i = 0; i < 1000; ++i) {
      latest.put(filled(i));
      all = latest.take(out) && all;
    }
    heap_calls = heap.count();
  }
  CHECK(all);
  CHECK(heap_calls == 0);
}

}  // namespace
