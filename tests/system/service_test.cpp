// The service with its real processes in lockstep: stopped, stalled and spoilt again and again, the
// robot never ends in a reflex and goes on; a ball that was let go meanwhile is taken up again.
#include <string>

#include <catch2/catch.hpp>

#include "plant_emulator/errors.hpp"
#include "tests/system/service.hpp"

using namespace c3rt;

namespace {

constexpr int kTimes = 20;
constexpr auto kLockstep = wire::ClockMode::kLockstep;

std::uint64_t reflexes(const test::Service& service) {
  return service.counter(c3rt_v1_PROCESS_PLANT, "reflexes");
}

}  // namespace

TEST_CASE("service: twenty stops and recoveries, and never a reflex") {
  test::Service service("circle_service", kLockstep);
  REQUIRE(service.until([&] { return service.tracks(); }, 5.0));
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    REQUIRE(service.ask(c3rt_v1_REQUEST_STOP) == "");
    CHECK(service.state().mode == c3rt_v1_ROBOT_USER_STOPPED);
    // answered when the robot has moved and its controller has tracked for 0.4 s
    REQUIRE(service.ask(c3rt_v1_REQUEST_RECOVER) == "");
    CHECK(service.state().mode == c3rt_v1_ROBOT_MOVE);
    service.run(0.02 * i);
  }
  CHECK(service.goes_on());
  CHECK(reflexes(service) == 0);
  CHECK(service.counter(c3rt_v1_PROCESS_PLANT, "lost_commands") == 0);
  CHECK(service.counter(c3rt_v1_PROCESS_IMPEDANCE, "stops") == kTimes);
}

TEST_CASE("service: twenty stalls and spoilt states of each kind, and never a reflex") {
  test::Service service("circle_service", kLockstep);
  REQUIRE(service.until([&] { return service.tracks(); }, 5.0));
  struct Fault {
    wire::Process process;
    c3rt_v1_FaultKind kind;
    double seconds, longer;  // every second one [s]
  };
  for (const Fault& fault : {Fault{c3rt_v1_PROCESS_PLANNER, c3rt_v1_FAULT_STALL, 0.05, 0.5},
                             Fault{c3rt_v1_PROCESS_VISION, c3rt_v1_FAULT_STALL, 0.05, 0.5},
                             // readers let no such state in, so the servo hears nothing
                             Fault{c3rt_v1_PROCESS_PLANT, c3rt_v1_FAULT_NAN, 0.015, 0.1}}) {
    CAPTURE(fault.process, fault.kind);
    for (int i = 0; i < kTimes; ++i) {
      CAPTURE(i);
      const double away = i % 2 == 0 ? fault.seconds : fault.longer;
      REQUIRE(service.inject(fault.process, fault.kind, away) == "");
      service.run(away + 0.2 + 0.02 * i);
      INFO(service.text(c3rt_v1_PROCESS_PLANT));
      REQUIRE(service.state().mode == c3rt_v1_ROBOT_MOVE);
    }
    CHECK(service.goes_on());
  }
  CHECK(service.until([&] { return service.tracks(); }, 5.0));
  CHECK(reflexes(service) == 0);
  CHECK(service.counter(c3rt_v1_PROCESS_PLANT, "faults") == kTimes);
  CHECK(service.counter(c3rt_v1_PROCESS_PLANT, "lost_commands") == 0);
}

TEST_CASE("service: states or commands that are missing for longer stop the robot, and it goes on alone") {
  test::Service service("circle_service", kLockstep);
  REQUIRE(service.until([&] { return service.tracks(); }, 5.0));
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    const bool states = i % 2 == 0;
    REQUIRE(service.inject(states ? c3rt_v1_PROCESS_PLANT : c3rt_v1_PROCESS_IMPEDANCE,
                           states ? c3rt_v1_FAULT_NAN : c3rt_v1_FAULT_STALL, 0.4) == "");
    REQUIRE(service.until([&] { return service.state().mode == c3rt_v1_ROBOT_REFLEX; }, 0.5));
    // missing commands and nothing else
    CHECK(service.state().errors == plant::bit(plant::Error::kCommunicationConstraintsViolation));
    REQUIRE(service.until([&] { return service.tracks(); }, 1.5));
    service.run(0.02 * i);
    REQUIRE(service.state().mode == c3rt_v1_ROBOT_MOVE);
  }
  CHECK(service.goes_on());
  CHECK(reflexes(service) == kTimes);
}
