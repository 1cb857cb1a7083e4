#include "idl/process.hpp"

#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>
#include <sched.h>

#include "tests/idl/bus_fixture.hpp"
#include "tests/idl/samples.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::wire;
namespace test = c3rt::wire::test;

namespace {

using test::eventually;
using test::kMs;
using test::kSecond;
using test::plain;

TEST_CASE("Inlet and Outlet: the newest sample goes from servo thread to servo thread") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Outlet<RobotState> outlet(plant);
  Inlet<RobotState> inlet(bus);
  REQUIRE(eventually([&] { return outlet.matched_readers() == 1; }));
  auto state = plain<RobotState>();
  for (int i = 1; i <= 200; ++i) {
    state.q_rad[0] = 0.01 * i;
    outlet.put(state, i * kMs);
    if (i % 20 == 0) usleep(1000);
  }
  RobotState seen{};
  double previous = 0.0;
  bool ordered = true;
  // others may be skipped, the newest never is
  REQUIRE(eventually([&] {
    if (!inlet.take(seen)) return false;
    ordered = ordered && seen.q_rad[0] > previous;
    previous = seen.q_rad[0];
    return seen.q_rad[0] == 2.0;
  }));
  CHECK(ordered);
  CHECK(seen.header.time_ns == 200 * kMs);
  CHECK(seen.header.session_id == 1);
  CHECK(outlet.failed() == 0);
  CHECK(inlet.counters().lost == 0);
  CHECK_FALSE(inlet.take(seen));
}

TEST_CASE(
    "Inlet: a sample sent ahead of its time waits for it, also when the next one is there "
    "already") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  bus.adopt_session(1);
  Writer<Plan> writer(plant);
  Inlet<Plan> inlet(bus);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  auto plan = plain<Plan>(), seen = plan;
  for (int i = 1; i <= 2; ++i) {
    plan.knots[0].p_WE_m[0] = i;
    REQUIRE(writer.write(plan, i * 100 * kMs));
    // the servo thread asks often; each plan arrives while none is due
    REQUIRE(eventually([&] {
      CHECK_FALSE(inlet.take(99 * kMs, seen));
      return inlet.counters().received == static_cast<std::uint64_t>(i);
    }));
    usleep(20'000);
    CHECK_FALSE(inlet.take(99 * kMs, seen));
  }
  REQUIRE(inlet.take(100 * kMs, seen));
  CHECK(seen.knots[0].p_WE_m[0] == 1);
  CHECK_FALSE(inlet.take(199 * kMs, seen));
  REQUIRE(inlet.take(200 * kMs, seen));
  CHECK(seen.knots[0].p_WE_m[0] == 2);
  CHECK_FALSE(inlet.take(300 * kMs, seen));
}

TEST_CASE("Outlet: what was put last is written even when the outlet closes at once") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Reader<TaskTarget> targets(bus);
  TaskTarget target{};
  for (int i = 1; i <= 20; ++i) {
    {
      Outlet<TaskTarget> outlet(plant);
      REQUIRE(eventually([&] { return outlet.matched_readers() == 1; }));
      target.request_id = static_cast<std::uint64_t>(i);
      bus.adopt_session(1);
      outlet.put(target, kMs);
    }
    TaskTarget seen{};
    REQUIRE(eventually([&] { return targets.take(seen); }));
    CHECK(seen.request_id == static_cast<std::uint64_t>(i));
  }
}

TEST_CASE("Inlet: a sample of an older session is not given to the servo thread") {
  Bus old_plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Writer<Plan> writer(old_plant);
  Inlet<Plan> inlet(bus);
  bus.adopt_session(1);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  auto plan = plain<Plan>();
  writer.write(plan, kMs);
  REQUIRE(eventually([&] { return inlet.counters().received == 1; }));
  bus.adopt_session(2);
  CHECK_FALSE(inlet.take(plan));
}

TEST_CASE("Inlet and Outlet: the servo side does not allocate") {
  if (!support::AllocationCounter::counts()) return;
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Outlet<RobotCommand> outlet(plant);
  Inlet<RobotCommand> inlet(bus);
  bus.adopt_session(1);
  REQUIRE(eventually([&] { return outlet.matched_readers() == 1; }));
  RobotCommand command{}, seen{};
  std::int64_t heap_calls = -1;
  int taken = 0;
  {
    const support::AllocationCounter heap;
    for (int i = 1; i <= 300; ++i) {
      outlet.put(command, i * kMs);
      if (inlet.take(seen)) ++taken;
      usleep(200);
    }
    heap_calls = heap.count();
  }
  CHECK(taken > 0);
  CHECK(heap_calls == 0);
}

TEST_CASE("Inlet and Outlet: in lockstep they hold to what a tick promises, and make no thread") {
  Bus plant(test::settings(ClockMode::kLockstep, 1)), bus(test::settings(ClockMode::kLockstep));
  Outlet<RobotState> outlet(plant);
  Inlet<RobotState> inlet(bus);
  bus.hold_until_promised();
  auto state = plain<RobotState>();
  for (int i = 1; i <= 3; ++i) outlet.put(state, i * kMs);
  Sequences promised{};
  plant.newest_written(promised);
  std::string missing;
  REQUIRE(bus.wait_for(promised, 10 * kSecond, missing));
  REQUIRE(inlet.take(2 * kMs, state));
  CHECK(state.header.seq == 2);
  CHECK_FALSE(inlet.take(2 * kMs, state));
  REQUIRE(inlet.take(3 * kMs, state));
  CHECK(state.header.seq == 3);
}

TEST_CASE("become_helper_thread: a helper of a real-time thread is ordinary") {
  int policy = -1;
  std::thread([&] {
    sched_param fifo{};
    fifo.sched_priority = 5;
    // where this is refused the thread is ordinary already
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo);
    become_helper_thread("helper");
    sched_param parameter{};
    pthread_getschedparam(pthread_self(), &policy, &parameter);
  }).join();
  CHECK(policy == SCHED_OTHER);
}

TEST_CASE("Signal: raised before the wait is not lost, and is used up by it") {
  Signal signal;
  signal.raise();
  signal.raise();
  signal.wait(60 * kSecond);
  const std::int64_t begin_ns = rt::now_ns();
  signal.wait(20 * kMs);
  CHECK(rt::now_ns() - begin_ns >= 19 * kMs);
}

TEST_CASE("Loop: in realtime it is woken on its grid and measures how late") {
  StopFlag::clear();
  Bus bus(test::settings());
  Loop loop(bus, {c3rt_v2_PROCESS_IMPEDANCE, kMs});
  std::int64_t now_ns = 0, previous_ns = 0;
  for (int i = 0; i < 50; ++i) {
    REQUIRE(loop.wait(now_ns));
    CHECK(now_ns > previous_ns);
    previous_ns = now_ns;
  }
  CHECK(loop.wakeup_latency().snapshot().count == 50);
  CHECK(loop.failure().empty());
}

TEST_CASE("Loop: waiting in realtime does not allocate") {
  if (!support::AllocationCounter::counts()) return;
  StopFlag::clear();
  Bus bus(test::settings());
  Loop loop(bus, {c3rt_v2_PROCESS_IMPEDANCE, kMs});
  std::int64_t now_ns = 0, heap_calls = -1;
  bool all = true;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 20; ++i) all = loop.wait(now_ns) && all;
    heap_calls = heap.count();
  }
  CHECK(all);
  CHECK(heap_calls == 0);
}

TEST_CASE("Loop: in realtime a cycle answers what arrives, and a timer only its absence") {
  StopFlag::clear();
  Bus bus(test::settings());
  Signal arrival;
  Loop::Settings settings{c3rt_v2_PROCESS_IMPEDANCE, 200 * kMs};
  settings.arrival = &arrival;
  Loop loop(bus, settings);
  std::int64_t now_ns = 0;
  REQUIRE(loop.wait(now_ns));  // nothing has arrived
  const std::int64_t first_ns = now_ns;
  // an arrival wakes it long before the timer, though not sooner than half a period after a cycle
  arrival.raise();
  arrival.raise();
  REQUIRE(loop.wait(now_ns));
  const std::int64_t answered_ns = now_ns;
  CHECK(answered_ns - first_ns >= 100 * kMs);
  CHECK(answered_ns - first_ns < 200 * kMs);
  // its absence is noticed after two periods, and then each period has its cycle
  REQUIRE(loop.wait(now_ns));
  CHECK(now_ns - answered_ns >= 400 * kMs);
  const std::int64_t guarded_ns = now_ns;
  REQUIRE(loop.wait(now_ns));
  CHECK(now_ns - guarded_ns >= 200 * kMs);
  CHECK(now_ns - guarded_ns < 400 * kMs);
  CHECK(loop.missed_cycles() == 0);
  CHECK(loop.wakeup_latency().snapshot().count == 4);
}

TEST_CASE("Loop: cycles that this thread slept through are missed, with arrivals or without") {
  StopFlag::clear();
  Bus bus(test::settings());
  Signal arrival;
  Loop::Settings settings{c3rt_v2_PROCESS_IMPEDANCE, 20 * kMs};
  settings.arrival = &arrival;
  Loop loop(bus, settings);
  std::int64_t now_ns = 0;
  arrival.raise();
  REQUIRE(loop.wait(now_ns));
  usleep(210'000);  // due again after 40 ms, so 8 periods too late
  arrival.raise();
  REQUIRE(loop.wait(now_ns));
  CHECK(loop.missed_cycles() >= 8);
}

TEST_CASE("Inlet: an arrival is raised for what a reader lets in, and for nothing else") {
  Bus bus(test::settings(ClockMode::kRealtime, 7)), other(test::settings(ClockMode::kRealtime, 7));
  Signal arrival;
  Inlet<RobotState> inlet(bus, &arrival);
  Writer<RobotState> writer(other);
  REQUIRE(eventually([&] { return writer.matched_readers() > 0; }));
  auto state = test::plain<RobotState>();
  writer.write(state, rt::now_ns());
  CHECK(arrival.wait(10 * kSecond));
  CHECK(inlet.take(state));
  state.q_rad[0] = std::nan("");
  writer.write(state, rt::now_ns());
  CHECK_FALSE(arrival.wait(100 * kMs));
}

TEST_CASE("Loop: waiting for an arrival does not allocate") {
  if (!support::AllocationCounter::counts()) return;
  StopFlag::clear();
  Bus bus(test::settings());
  Signal arrival;
  Loop::Settings settings{c3rt_v2_PROCESS_IMPEDANCE, kMs};
  settings.arrival = &arrival;
  Loop loop(bus, settings);
  std::int64_t now_ns = 0, heap_calls = -1;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 20; ++i) {
      if (i % 2 == 0) arrival.raise();
      (void)loop.wait(now_ns);
    }
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
}

TEST_CASE(
    "Loop: REQUEST_SHUTDOWN to this process stops it and is answered; one to another process is "
    "not ours") {
  test::Child child([] {
    Bus bus(test::settings());
    Loop loop(bus, {c3rt_v2_PROCESS_VISION, 10 * kMs});
    std::int64_t now_ns = 0;
    while (loop.wait(now_ns)) {
    }
    return loop.failure().empty() ? 0 : 1;
  });
  Bus client(test::settings());
  Writer<ServiceRequest> requests(client);
  Reader<ServiceReply> replies(client);
  ServiceRequest request{};
  request.verb = c3rt_v2_REQUEST_SHUTDOWN;
  request.request_id = 1;
  request.process = c3rt_v2_PROCESS_PLANNER;
  // what was asked before it was there was not for it
  REQUIRE(eventually([&] { return requests.matched_readers() > 0; }));
  requests.write(request, 1);
  request.request_id = 2;
  request.process = c3rt_v2_PROCESS_VISION;
  requests.write(request, 2);
  ServiceReply reply{};
  REQUIRE(eventually([&] { return replies.take(reply); }));
  CHECK(reply.request_id == 2);
  CHECK(reply.ok);
  CHECK(reply.process == c3rt_v2_PROCESS_VISION);
  CHECK(std::string(reply.text) == "vision is shutting down");
  CHECK(child.wait() == 0);
}

TEST_CASE("StatusReporter: tells state, counters, quantiles and rate, and says when it stops") {
  Bus bus(test::settings(ClockMode::kRealtime, 9)), client(test::settings());
  Reader<ServiceStatus> reader(client);
  ServiceStatus status{};
  {
    StatusReporter reporter(bus, c3rt_v2_PROCESS_PLANNER);
    REQUIRE(eventually([&] { return reader.take(status); }));
    CHECK(status.state == c3rt_v2_SERVICE_STARTING);
    CHECK(status.header.session_id == 9);
    CHECK(status.pid == getpid());
    std::atomic<std::uint64_t>& overruns = reporter.counter("overruns");
    CHECK(&reporter.counter("overruns") == &overruns);
    overruns += 3;
    reporter.set_state(c3rt_v2_SERVICE_RUNNING, "rolling");
    REQUIRE(eventually([&] {
      reporter.compute().add(2e-3);
      usleep(1000);
      (void)reader.take_newest(status);
      return status.rate_hz > 0.0;
    }));
    CHECK(status.process == c3rt_v2_PROCESS_PLANNER);
    CHECK(status.state == c3rt_v2_SERVICE_RUNNING);
    CHECK(std::string(status.text) == "rolling");
    CHECK(std::string(status.counter_names[0]) == "overruns");
    CHECK(status.counters[0] == 3);
    CHECK(status.compute.count > 0);
    CHECK(status.compute.p50_s == Approx(2e-3).epsilon(0.01));
  }
  REQUIRE(eventually([&] {
    (void)reader.take_newest(status);
    return status.state == c3rt_v2_SERVICE_STOPPING;
  }));
}

TEST_CASE("StatusReporter: a peer that can never be served is told in the text") {
  Bus bus(test::settings(ClockMode::kRealtime, 9));
  Bus lockstep(test::settings(ClockMode::kLockstep)), client(test::settings());
  Writer<RobotState> writer(bus);
  Reader<RobotState> wrong_clock(lockstep);
  Reader<ServiceStatus> reader(client);
  StatusReporter reporter(bus, c3rt_v2_PROCESS_PLANT);
  reporter.set_state(c3rt_v2_SERVICE_RUNNING, "stepping");
  ServiceStatus status{};
  REQUIRE(eventually([&] {
    (void)reader.take_newest(status);
    return std::string(status.text).find("stepping; ") == 0;
  }));
  CHECK_THAT(std::string(status.text),
             Catch::StartsWith("stepping; robot/state: reader of ") &&
                 Catch::Contains("requests RELIABLE, this writer offers BEST_EFFORT"));
}

TEST_CASE(
    "StatusReporter: what its process refuses is in the status, and told once for each kind") {
  Bus bus(test::settings(ClockMode::kRealtime, 9)), other(test::settings(ClockMode::kRealtime, 8)),
      client(test::settings());
  Reader<Plan> plans(bus);
  Writer<Plan> wrong_session(other);
  Reader<ServiceStatus> reader(client);
  std::mutex mutex;
  std::vector<std::string> told;
  StatusReporter reporter(bus, c3rt_v2_PROCESS_IMPEDANCE, [&](const std::string& said) {
    const std::lock_guard lock(mutex);
    told.push_back(said);
  });
  REQUIRE(eventually([&] { return wrong_session.matched_readers() == 1; }));
  auto plan = plain<Plan>();
  ServiceStatus status{};
  Plan taken{};
  REQUIRE(eventually([&] {
    wrong_session.write(plan, kMs);
    CHECK_FALSE(plans.take(taken));
    (void)reader.take_newest(status);
    return refused_kinds(status) == 1 && status.refused[0].count > 20;
  }));
  CHECK(std::string(status.refused[0].topic) == "plan");
  CHECK(std::string(status.refused[0].reason) == "other session");
  CHECK_THAT(std::string(status.refused[0].latest),
             Catch::StartsWith("session 8, expected 9; from ") &&
                 Catch::Contains("(pid " + std::to_string(getpid()) + ")"));
  const std::lock_guard lock(mutex);
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Catch::StartsWith("refused plan (other session) from "));
}

TEST_CASE("StatusReporter: a text from elsewhere reaches no terminal as a command to it") {
  Bus bus(test::settings()), client(test::settings());
  StatusReporter reporter(bus, c3rt_v2_PROCESS_PLANT);
  reporter.set_state(c3rt_v2_SERVICE_FAILED, "a\nb\x1b[2J");
  Reader<ServiceStatus> reader(client);
  ServiceStatus status{};
  REQUIRE(eventually(
      [&] { return reader.take_newest(status) && status.state == c3rt_v2_SERVICE_FAILED; }));
  CHECK(std::string(status.text) == "a b [2J");
}

TEST_CASE("StatusReporter: a counter too many and a name too long are refused") {
  Bus bus(test::settings());
  StatusReporter reporter(bus, c3rt_v2_PROCESS_VISION);
  CHECK_THROWS_AS(reporter.counter(std::string(32, 'n')), WireError);
  for (int i = 0; i < c3rt_v2_COUNTERS; ++i)
    CHECK_NOTHROW(reporter.counter("counter " + std::to_string(i)));
  CHECK_THROWS_AS(reporter.counter("one more"), WireError);
}

TEST_CASE("draw_session: a later one is larger") {
  const std::uint64_t first = draw_session();
  usleep(10);
  CHECK(draw_session() > first);
}

}  // namespace
