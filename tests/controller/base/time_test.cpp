#include "controller/base/time.hpp"

#include <catch2/catch.hpp>

using namespace c3rt::base;

TEST_CASE("time: nanoseconds are the nearest, and back again the same, for eleven days") {
  CHECK(nanoseconds(0.001) == 1000000);
  CHECK(nanoseconds(-0.25) == -250000000);
  CHECK(nanoseconds(1.4e-9) == 1);
  CHECK(seconds(2500000000) == 2.5);
  for (std::int64_t time_ns = 1; time_ns < 1000000000000000; time_ns = time_ns * 7 + 3)
    CHECK(nanoseconds(seconds(time_ns)) == time_ns);
}
