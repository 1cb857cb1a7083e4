#include "tests/support/allocation_counter.hpp"

#include <cstdlib>
#include <memory>
#include <vector>

#include <catch2/catch.hpp>

using c3rt::support::AllocationCounter;

TEST_CASE("allocation counter: it counts malloc and operator new, and nothing else") {
  if (!AllocationCounter::counts()) return;
  std::int64_t none = -1, some = -1;
  {
    const AllocationCounter heap;
    none = heap.count();
  }
  std::vector<double> values;
  {
    const AllocationCounter heap;
    values.resize(100);
    void* volatile p = std::malloc(16);
    some = heap.count();
    std::free(p);
  }
  REQUIRE(none == 0);
  REQUIRE(some == 2);
}
