// The service with its real processes in lockstep: stopped, stalled and spoilt again and again, the
// robot never ends in a reflex and goes on; a ball that was let go meanwhile is taken up again.
#include "tests/system/service.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "plant_emulator/errors.hpp"
#include "tests/idl/raw_writer.hpp"

using namespace c3rt;

namespace {

constexpr int kTimes = 20;
constexpr auto kLockstep = wire::ClockMode::kLockstep;

std::uint64_t reflexes(const test::Service& service) {
  return service.counter(c3rt_v2_PROCESS_PLANT, "reflexes");
}

}  // namespace

TEST_CASE("service: twenty stops and recoveries, and never a reflex") {
  test::Service service("circle_service", kLockstep);
  REQUIRE(service.until([&] { return service.tracks(); }, 5.0));
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    REQUIRE(service.ask(c3rt_v2_REQUEST_STOP) == "");
    CHECK(service.state().mode == c3rt_v2_ROBOT_USER_STOPPED);
    // answered when the robot has moved and its controller has tracked for 0.4 s
    REQUIRE(service.ask(c3rt_v2_REQUEST_RECOVER) == "");
    CHECK(service.state().mode == c3rt_v2_ROBOT_MOVE);
    service.run(0.02 * i);
  }
  CHECK(service.goes_on());
  CHECK(reflexes(service) == 0);
  CHECK(service.counter(c3rt_v2_PROCESS_PLANT, "lost_commands") == 0);
  CHECK(service.counter(c3rt_v2_PROCESS_IMPEDANCE, "stops") == kTimes);
}

TEST_CASE("service: twenty stalls and spoilt states of each kind, and never a reflex") {
  test::Service service("circle_service", kLockstep);
  REQUIRE(service.until([&] { return service.tracks(); }, 5.0));
  struct Fault {
    wire::Process process;
    c3rt_v2_FaultKind kind;
    double seconds, longer;  // every second one [s]
  };
  for (const Fault& fault : {Fault{c3rt_v2_PROCESS_PLANNER, c3rt_v2_FAULT_STALL, 0.05, 0.4},
                             Fault{c3rt_v2_PROCESS_VISION, c3rt_v2_FAULT_STALL, 0.05, 0.4},
                             // readers let no such state in, so the servo hears nothing
                             Fault{c3rt_v2_PROCESS_PLANT, c3rt_v2_FAULT_NAN, 0.015, 0.1}}) {
    CAPTURE(fault.process, fault.kind);
    for (int i = 0; i < kTimes; ++i) {
      CAPTURE(i);
      const double away = i % 2 == 0 ? fault.seconds : fault.longer;
      REQUIRE(service.inject(fault.process, fault.kind, away) == "");
      service.run(away + 0.15 + 0.01 * i);
      INFO(service.text(c3rt_v2_PROCESS_PLANT));
      REQUIRE(service.state().mode == c3rt_v2_ROBOT_MOVE);
    }
    CHECK(service.goes_on());
  }
  CHECK(service.until([&] { return service.tracks(); }, 5.0));
  CHECK(reflexes(service) == 0);
  CHECK(service.counter(c3rt_v2_PROCESS_PLANT, "faults") == kTimes);
  CHECK(service.counter(c3rt_v2_PROCESS_PLANT, "lost_commands") == 0);
}

TEST_CASE(
    "service: states or commands that are missing for longer stop the robot, and it goes on "
    "alone") {
  test::Service service("circle_service", kLockstep);
  REQUIRE(service.until([&] { return service.tracks(); }, 5.0));
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    const bool states = i % 2 == 0;
    REQUIRE(service.inject(states ? c3rt_v2_PROCESS_PLANT : c3rt_v2_PROCESS_IMPEDANCE,
                           states ? c3rt_v2_FAULT_NAN : c3rt_v2_FAULT_STALL, 0.4) == "");
    REQUIRE(service.until([&] { return service.state().mode == c3rt_v2_ROBOT_REFLEX; }, 0.5));
    // missing commands and nothing else
    CHECK(service.state().errors == plant::bit(plant::Error::kCommunicationConstraintsViolation));
    REQUIRE(service.until([&] { return service.tracks(); }, 1.5));
    service.run(0.02 * i);
    REQUIRE(service.state().mode == c3rt_v2_ROBOT_MOVE);
  }
  CHECK(service.goes_on());
  CHECK(reflexes(service) == kTimes);
}

TEST_CASE("service: cycles that are missed on the way to the ball, and a hold: never a reflex") {
  test::Service service("circle_service", kLockstep);
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    REQUIRE(service.until([&] { return service.tracks(); }, 10.0));
    service.run(0.03 * i);
    // fewer than stop the robot
    REQUIRE(service.inject(c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_FAULT_STALL, 0.001 * (1 + i % 19)) ==
            "");
    REQUIRE(service.target(i % 2 == 0 ? "hold" : "scenario") == "");
    service.run(0.3);
    INFO(service.text(c3rt_v2_PROCESS_PLANT));
    REQUIRE(service.state().mode == c3rt_v2_ROBOT_MOVE);
  }
  CHECK(reflexes(service) == 0);
}

namespace {

void takes_up_the_ball(wire::ClockMode clock, int times) {
  test::Service service("circle_service", clock);
  const auto rolls = [&] {
    return service.plan().phase == std::string("roll") && service.tracks();
  };
  for (const wire::Process process : {c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION}) {
    for (int i = 0; i < times; ++i) {
      CAPTURE(process, i);
      REQUIRE(service.until([&] { return rolls() && service.ball_speed() > 0.02; }, 30.0));
      service.run(0.4 * i);
      REQUIRE(service.inject(process, c3rt_v2_FAULT_STALL, 1.0) == "");
      service.run(1.0);
      // the table's resistance stops it near by, and the arm comes back to it
      REQUIRE(service.until([&] { return service.ball_speed() < 1e-3; }, 10.0));
      const Eigen::Vector3d left = service.p_WB();
      REQUIRE(
          service.until([&] { return rolls() && (service.p_WB() - left).norm() > 0.01; }, 30.0));
    }
  }
  CHECK(reflexes(service) == 0);
}

}  // namespace

TEST_CASE("service: a ball that nobody plans for or sees for a second is taken up again") {
  takes_up_the_ball(kLockstep, 3);
}

TEST_CASE("service: the same in real time, ten times each", "[.realtime]") {
  takes_up_the_ball(wire::ClockMode::kRealtime, 10);
}

TEST_CASE("service: each cause of holding has its own words") {
  test::Service service("circle_service", kLockstep);
  const auto says = [&](wire::Process process, const std::string& words) {
    return service.until([&] { return service.text(process).find(words) != std::string::npos; },
                         8.0);
  };
  // the first approach may be over when the service's first words are heard
  REQUIRE(service.until([&] { return service.tracks(); }, 8.0));
  REQUIRE(service.inject(c3rt_v2_PROCESS_VISION, c3rt_v2_FAULT_STALL, 4.0) == "");
  CHECK(
      says(c3rt_v2_PROCESS_PLANNER, "holding: vision is silent: the last estimate of ball 0 is "));
  REQUIRE(service.inject(c3rt_v2_PROCESS_VISION, c3rt_v2_FAULT_LOSE_OBJECT, 4.0) == "");
  CHECK(says(c3rt_v2_PROCESS_PLANNER, "holding: ball 0 is not in view since "));
  CHECK(says(c3rt_v2_PROCESS_PLANNER, "approach"));
  REQUIRE(service.inject(c3rt_v2_PROCESS_PLANNER, c3rt_v2_FAULT_STALL, 4.0) == "");
  CHECK(says(c3rt_v2_PROCESS_IMPEDANCE, "holds its position: the plan is too old"));
  CHECK(says(c3rt_v2_PROCESS_IMPEDANCE, "tracks the plan"));
  REQUIRE(service.target("hold") == "");
  CHECK(says(c3rt_v2_PROCESS_PLANNER, "holding: asked to hold; ball 0 at ("));
  REQUIRE(service.ask(c3rt_v2_REQUEST_STOP) == "");
  CHECK(says(c3rt_v2_PROCESS_PLANNER, "stopped by a person; recover ends it"));
  CHECK(says(c3rt_v2_PROCESS_PLANT, "stopped by a person; request recover"));
  CHECK(says(c3rt_v2_PROCESS_IMPEDANCE,
             "stopped: a stop was requested; damps until a recovery is requested"));
}

TEST_CASE("service: with rendered cameras a hold brings the rolling ball to rest, and it goes on") {
  test::Service service("circle_vision", kLockstep);
  const auto rolls = [&] {
    return service.plan().phase == std::string("roll") && service.ball_speed() > 0.02;
  };
  REQUIRE(service.until(rolls, 30.0));
  service.run(2.0);
  REQUIRE(service.target("hold") == "");
  REQUIRE(service.until(
      [&] {
        return service.text(c3rt_v2_PROCESS_PLANNER).find("holding: asked to hold; ball 0 at") == 0;
      },
      15.0));
  CHECK(service.ball_speed() < 5e-3);
  const Eigen::Vector3d here = service.p_WB();
  service.run(3.0);
  CHECK((service.p_WB() - here).norm() < 0.01);
  CHECK(service.p_WE().z() - service.p_WB().z() > 0.06);  // left alone: they touch at 0.051 m
  REQUIRE(service.target("scenario") == "");
  CHECK(service.until(rolls, 30.0));
  CHECK(reflexes(service) == 0);
}

TEST_CASE(
    "service: targets and faults end with 0 taken, 1 refused by a process, 2 wrong in itself") {
  test::Service service("circle_service", kLockstep);
  struct Case {
    const char* arguments;
    int own, foreign;  // exit status: of who started it, of another user, whose command knows no
                       // scenario
    const char* says;
  };
  for (const Case& c : std::vector<Case>{
           {"target hold", 0, 0, "planner: "},
           {"target circle --center 0.55 0 --radius 0.08", 0, 0, "planner: "},
           {"target circle --center 5 5", 2, 2, "center_m: expected 2 numbers from -1 to 1"},
           {"target circle --center 0.8 0", 2, 1, "expected a centre with x in [0.47, 0.63]"},
           {"target circle --center 0.55 0 --radius 0.5", 2, 1, "radius"},
           {"target circle --center 0.55 0 --lead-deg -180", 2, 2, "lead"},
           {"target pose 0.55 0.05", 0, 0, "planner: "},
           {"target pose 0.9 0", 2, 1, "expected a goal with x in [0.37, 0.73]"},
           {"target task circle center_m=0.55,0 radius_m=0.08 lead_rad=0.35", 0, 0, "planner: "},
           {"fault push-ball --impulse 0.001 0 0", 0, 0, "plant: "},
           {"target scenario", 0, 0, "planner: "},
           {"target circle --center nan 0", 2, 2, ""},
           {"fault stall planner --for 0.05", 0, 0, "planner: "},
           {"fault nan plant --for 0.01", 0, 0, "plant: "},
           {"fault push-object --impulse 0.001 0 0", 0, 0, "plant: "},
           {"fault push-object --impulse 100 0 0", 2, 1, "at most"},
           {"fault push-object --impulse 0.001 0 0 --object 3", 2, 1, "object"},
           {"fault push-object --impulse nan 0 0", 2, 2, ""},
           {"fault freeze-camera --camera 99", 2, 2, "camera"},
           {"fault stall nobody", 2, 2, ""}}) {
    CAPTURE(c.arguments);
    for (const bool own : {true, false}) {
      CAPTURE(own);
      const support::Outcome outcome =
          own ? service.c3rt(c.arguments) : service.stranger(c.arguments);
      CHECK(outcome.status == (own ? c.own : c.foreign));
      CHECK_THAT(outcome.output, Catch::Contains(c.says));
    }
  }
  CHECK(reflexes(service) == 0);
}

TEST_CASE(
    "service: a target with an old number or of another session is refused, counted and answered") {
  test::Service service("circle_service", kLockstep);
  wire::test::RawWriter targets(service.bus(), wire::topic<wire::TaskTarget>());
  REQUIRE(service.until([&] { return targets.matched(); }, 10.0));
  service.run(0.5);
  const auto refused = [&](const char* reason) {
    return service.refused(c3rt_v2_PROCESS_PLANNER, "task/target", reason);
  };
  const auto send = [&](std::uint64_t session, std::uint64_t seq) {
    wire::TaskTarget target{};
    wire::set_text(target.kind, "scenario");
    return service.question(
        target, [&](const wire::TaskTarget& asked) { targets.write(asked, session, seq); });
  };
  CHECK(send(0, 7) == "");
  CHECK_THAT(send(0, 3), Catch::Contains("planner: refused: ") && Catch::Contains("sequence"));
  CHECK_THAT(send(1234, 8), Catch::Contains("planner: refused: ") && Catch::Contains("session"));
  CHECK(service.until([&] { return refused("old sequence") && refused("other session"); }, 20.0));
  for (const char* reason : {"old sequence", "other session"}) {
    REQUIRE(refused(reason));
    CHECK(refused(reason)->count == 1);
    CHECK_THAT(std::string(refused(reason)->latest),
               Catch::Contains("(pid " + std::to_string(getpid()) + ")"));
  }
  CHECK(send(0, 9) == "");
}

TEST_CASE("service: each process is killed ten times, and the task goes on within 3 s",
          "[.realtime]") {
  // by hand: the machine decides how long it takes. One of them: -c impedance
  for (const wire::Process process : {c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION,
                                      c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANT}) {
    DYNAMIC_SECTION(wire::process_name(process)) {
      test::Service service("circle_service", wire::ClockMode::kRealtime);
      std::vector<double> away;
      for (int i = 0; i < 10; ++i) {
        usleep(7'000'000);  // more often than this is given up
        REQUIRE(service.until([&] { return service.tracks(); }, 20.0));
        const pid_t before = service.status(process)->pid;
        const std::int64_t killed_ns = rt::now_ns();
        REQUIRE(kill(before, SIGKILL) == 0);
        // its successor speaks, the robot follows the plan, and has moved since then
        std::optional<Eigen::Vector3d> from;
        while (rt::now_ns() - killed_ns < 20'000'000'000) {
          service.look();
          const bool well = service.status(process)->pid != before && service.tracks();
          if (well && !from) from = service.p_WE();
          if (!well) from.reset();
          if (from && (service.p_WE() - *from).norm() > 0.002) break;
        }
        away.push_back(1e-9 * static_cast<double>(rt::now_ns() - killed_ns));
      }
      std::sort(away.begin(), away.end());
      std::printf("%-10s killed 10 times: goes on after p50 %.2f s, at most %.2f s\n",
                  wire::process_name(process), away[4], away[9]);
      std::fflush(stdout);
      INFO(service.c3rt("status").output);
      CHECK(away.back() < 3.0);
    }
  }
}
