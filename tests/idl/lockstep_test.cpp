#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <thread>

#include <catch2/catch.hpp>

#include "idl/process.hpp"
#include "tests/idl/bus_fixture.hpp"
#include "tests/idl/samples.hpp"

using namespace c3rt;
using namespace c3rt::wire;
namespace test = c3rt::wire::test;

namespace {

using test::Child;
using test::kMs;
using test::kSecond;
using test::plain;

constexpr std::int64_t kPlanPeriod_ns = 13 * kMs;
/// Exit status of a process whose run was ended by a signal, as every run is here.
int stopped(const Loop& loop) {
  if (loop.failure().empty()) return 0;
  std::fprintf(stderr, "%s\n", loop.failure().c_str());
  return 1;
}

/// Answers every state with a command that tells what was seen: the state and the plan in effect.
int impedance() {
  const StopFlag stop;
  Bus bus(test::settings(ClockMode::kLockstep));
  Reader<RobotState> states(bus);
  Reader<Plan> plans(bus);
  Writer<RobotCommand> commands(bus);
  Loop loop(bus, {c3rt_v2_PROCESS_IMPEDANCE, kMs});
  auto state = plain<RobotState>();
  auto plan = plain<Plan>();
  RobotCommand command{};
  std::int64_t now_ns = 0;
  while (loop.wait(now_ns)) {
    if (!states.take_effective(now_ns, state)) return 2;
    if (plans.take_effective(now_ns, plan)) command.tau_nm[0] = plan.knots[0].p_WE_m[0];
    command.origin.state_ns = state.header.time_ns;
    command.origin.plan_ns = static_cast<std::int64_t>(plan.header.seq);
    commands.write(command, now_ns);
  }
  return states.counters().lost + states.counters().refused_for(Reason::kOldSequence) == 0
             ? stopped(loop)
             : 3;
}

/// Plans every 13 ms; odd plans take effect at once, which only works if nobody sees them within
/// the tick.
int planner() {
  const StopFlag stop;
  Bus bus(test::settings(ClockMode::kLockstep));
  Reader<RobotState> states(bus);
  Writer<Plan> plans(bus);
  Loop loop(bus, {c3rt_v2_PROCESS_PLANNER, kPlanPeriod_ns});
  auto state = plain<RobotState>();
  auto plan = plain<Plan>();
  std::int64_t now_ns = 0;
  while (loop.wait(now_ns)) {
    int seen = 0;
    while (states.take(state)) ++seen;
    // at the first tick one state, then one per millisecond
    if (seen != (now_ns == 0 ? 1 : kPlanPeriod_ns / kMs)) return 2;
    plan.knots[0].p_WE_m[0] = state.q_rad[0];
    plan.valid_until_ns = now_ns + kSecond;
    plans.write(plan, now_ns + (plans.seq() % 2 == 0 ? 0 : 5 * kMs));
  }
  return stopped(loop);
}

struct Run {
  std::uint64_t hash = 14695981039346656037ull;
  std::uint64_t newest_plan = 0;
  int commands = 0;
  int impedance_status = -1, planner_status = -1;
  std::string failure;
  void mix(std::uint64_t value) { hash = (hash ^ value) * 1099511628211ull; }
};

Run run(int ticks) {
  Run result;
  Child impedance_process(impedance), planner_process(planner);
  {
    Bus bus(test::settings(ClockMode::kLockstep, draw_session()));
    Writer<RobotState> states(bus);
    Reader<RobotCommand> commands(bus);
    LockstepMaster master(bus, {c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER}, 10 * kSecond);
    auto state = plain<RobotState>();
    RobotCommand command{};
    for (int k = 0; k < ticks; ++k) {
      const std::int64_t now_ns = k * kMs;
      state.q_rad[0] =
          std::sin(0.01 * k) + 0.1 * command.tau_nm[0];  // what was commanded comes back
      states.write(state, now_ns);
      if (!master.advance(now_ns)) break;
      while (commands.take(command)) {
        ++result.commands;
        if (command.header.seq != static_cast<std::uint64_t>(result.commands)) return result;
        std::uint64_t bits = 0;
        std::memcpy(&bits, &command.tau_nm[0], sizeof bits);
        result.mix(static_cast<std::uint64_t>(command.origin.state_ns));
        result.mix(static_cast<std::uint64_t>(command.origin.plan_ns));
        result.mix(bits);
        result.newest_plan = static_cast<std::uint64_t>(command.origin.plan_ns);
      }
      if (command.origin.state_ns != now_ns) break;
    }
    result.failure = master.failure();
  }
  impedance_process.kill(SIGTERM);
  planner_process.kill(SIGTERM);
  result.impedance_status = impedance_process.wait();
  result.planner_status = planner_process.wait();
  return result;
}

TEST_CASE(
    "lockstep: over 2000 ticks every sample arrives in order, and a run on a loaded machine has "
    "the same bits") {
  constexpr int kTicks = 2000;
  const Run idle = run(kTicks);
  CHECK(idle.failure == "");
  CHECK(idle.commands == kTicks);
  // plans of ticks 0, 13, ... 1989: 154 of them; the last one, even, is in effect from 1994 on
  CHECK(idle.newest_plan == 154);
  CHECK(idle.impedance_status == 0);
  CHECK(idle.planner_status == 0);

  Child load([] {
    std::atomic<bool> never{false};
    std::thread other([&] {
      while (!never) {
      }
    });
    while (!never) {
    }
    return 0;
  });
  const Run loaded = run(kTicks);
  CHECK(loaded.failure == "");
  CHECK(loaded.commands == kTicks);
  CHECK(loaded.impedance_status == 0);
  CHECK(loaded.planner_status == 0);
  CHECK(loaded.hash == idle.hash);
}

TEST_CASE("lockstep: a process acts at phase + k * period and at no other tick") {
  Child child([] {
    const StopFlag stop;
    Bus bus(test::settings(ClockMode::kLockstep));
    Writer<ObjectEstimate> estimates(bus);
    Loop loop(bus, {c3rt_v2_PROCESS_VISION, 10 * kMs, 3 * kMs});
    auto estimate = plain<ObjectEstimate>();
    std::int64_t now_ns = 0;
    while (loop.wait(now_ns)) estimates.write(estimate, now_ns);
    return stopped(loop);
  });
  {
    Bus bus(test::settings(ClockMode::kLockstep, draw_session()));
    Reader<ObjectEstimate> estimates(bus);
    LockstepMaster master(bus, {c3rt_v2_PROCESS_VISION}, 10 * kSecond);
    auto estimate = plain<ObjectEstimate>();
    std::vector<std::int64_t> acted_ms;
    for (int k = 0; k < 40; ++k) {
      REQUIRE(master.advance(k * kMs));
      while (estimates.take(estimate)) acted_ms.push_back(estimate.header.time_ns / kMs);
    }
    CHECK(acted_ms == std::vector<std::int64_t>{3, 13, 23, 33});
  }
  child.kill(SIGTERM);
  CHECK(child.wait() == 0);
}

TEST_CASE("LockstepMaster: names the processes that did not join") {
  Bus bus(test::settings(ClockMode::kLockstep, draw_session()));
  CHECK_THROWS_WITH(
      LockstepMaster(bus, {c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_VISION}, 200 * kMs),
      "did not join the lockstep run within 0.2 s: impedance, vision");
}

TEST_CASE("LockstepMaster: names the process that died, and the tick") {
  Child survivor([] { return impedance(); });
  Child child([] {
    Bus bus(test::settings(ClockMode::kLockstep));
    Loop loop(bus, {c3rt_v2_PROCESS_PLANNER, kMs});
    std::int64_t now_ns = 0;
    while (loop.wait(now_ns) && now_ns < 10 * kMs) {
    }
    _exit(0);  // as a crash: nothing is closed
    return 0;
  });
  Bus bus(test::settings(ClockMode::kLockstep, draw_session()));
  Writer<RobotState> states(bus);
  LockstepMaster master(bus, {c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER}, 10 * kSecond,
                        kSecond);
  auto state = plain<RobotState>();
  int ticks = 0;
  do {
    states.write(state, ticks * kMs);
  } while (master.advance(ticks * kMs) && ++ticks < 100);
  CHECK(ticks == 10);
  CHECK(master.failure() == "planner did not answer the tick of 0.01 s for 1 s");
  CHECK_FALSE(master.advance(11 * kMs));
}

TEST_CASE("LockstepMaster: notices a process that closed its bus without answering") {
  Child child([] {
    {
      Bus bus(test::settings(ClockMode::kLockstep));
      Loop loop(bus, {c3rt_v2_PROCESS_PLANNER, kMs});
      std::int64_t now_ns = 0;
      while (loop.wait(now_ns) && now_ns < 3 * kMs) {
      }
    }
    sleep(30);
    return 0;
  });
  Bus bus(test::settings(ClockMode::kLockstep, draw_session()));
  LockstepMaster master(bus, {c3rt_v2_PROCESS_PLANNER}, 10 * kSecond, 3 * kSecond);
  int ticks = 0;
  while (master.advance(ticks * kMs)) ++ticks;
  CHECK(master.failure() == "planner left the run before answering the tick of 0.003 s");
}

TEST_CASE("Loop: without a plant it gives up with a sentence") {
  Bus bus(test::settings(ClockMode::kLockstep));
  Loop::Settings settings{c3rt_v2_PROCESS_VISION, kMs};
  settings.join_timeout_ns = 300 * kMs;
  Loop loop(bus, settings);
  std::int64_t now_ns = 0;
  CHECK_FALSE(loop.wait(now_ns));
  CHECK(loop.failure() == "no tick from the plant for 0.3 s");
}

TEST_CASE("Loop: when the plant leaves it gives up with a sentence that says when") {
  Bus bus(test::settings(ClockMode::kLockstep));
  Loop::Settings settings{c3rt_v2_PROCESS_VISION, kMs};
  settings.gone_timeout_ns = kSecond / 2;
  Loop loop(bus, settings);
  std::int64_t now_ns = 0;
  {
    Bus plant(test::settings(ClockMode::kLockstep, 1));
    Writer<Tick> ticks(plant);
    Tick tick{};
    tick.due = 1u << c3rt_v2_PROCESS_VISION;
    ticks.write(tick, 7 * kMs);
    REQUIRE(loop.wait(now_ns));
    CHECK(now_ns == 7 * kMs);
  }
  CHECK_FALSE(loop.wait(now_ns));
  CHECK(loop.failure() == "the plant has been gone for 0.5 s (last tick 0.007 s)");
}

TEST_CASE("Loop: names the topic whose promised sample does not come") {
  Bus plant(test::settings(ClockMode::kLockstep, 1)), bus(test::settings(ClockMode::kLockstep));
  Writer<Tick> ticks(plant);
  Reader<RobotState> states(bus);
  Reader<Scene> scenes(bus);
  Loop::Settings settings{c3rt_v2_PROCESS_VISION, kMs};
  settings.gone_timeout_ns = kSecond / 2;
  Loop loop(bus, settings);
  Tick tick{};
  tick.due = 1u << c3rt_v2_PROCESS_VISION;
  tick.newest_seq[topic<Scene>().stream] = 4;
  ticks.write(tick, 7 * kMs);
  std::int64_t now_ns = 0;
  CHECK_FALSE(loop.wait(now_ns));
  CHECK(loop.failure() ==
        "the tick of 0.007 s promises a sample of sim/scene that did not arrive for 0.5 s");
}

TEST_CASE("Loop: a signal ends the wait, and that is no failure") {
  for (const ClockMode clock : {ClockMode::kRealtime, ClockMode::kLockstep}) {
    int ready[2];
    REQUIRE(pipe(ready) == 0);
    Child child([clock, ready] {
      const StopFlag stop;
      Bus bus(test::settings(clock));
      Loop loop(bus, {c3rt_v2_PROCESS_VISION, 10 * kMs});
      if (write(ready[1], "r", 1) != 1) return 4;
      std::int64_t now_ns = 0;
      while (loop.wait(now_ns)) {
      }
      return loop.failure().empty() ? 0 : 1;
    });
    char byte = 0;
    REQUIRE(read(ready[0], &byte, 1) == 1);
    child.kill(SIGTERM);
    CHECK(child.wait() == 0);
    close(ready[0]);
    close(ready[1]);
  }
}

}  // namespace
