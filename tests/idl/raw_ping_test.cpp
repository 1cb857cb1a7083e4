#include "idl/raw_ping.hpp"

#include <catch2/catch.hpp>

#include "tests/idl/bus_fixture.hpp"

using namespace c3rt::wire;

TEST_CASE("RawPing: another process's echo answers; without one the answer is missing, and said") {
  test::Child peer([] {
    Bus bus(test::settings());
    const RawEcho echo(bus);
    sleep(30);
    return 0;
  });
  Bus bus(test::settings());
  RawPing ping(bus);
  std::int64_t round_trip_ns = -1;
  REQUIRE(
      test::eventually([&] { return (round_trip_ns = ping.round_trip_ns(50 * test::kMs)) > 0; }));
  CHECK(round_trip_ns < 50 * test::kMs);
  peer.kill(SIGKILL);
  CHECK(test::eventually([&] { return ping.round_trip_ns(50 * test::kMs) == -1; }));
}
