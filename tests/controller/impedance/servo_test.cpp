#include "controller/impedance/servo.hpp"

#include <atomic>
#include <cmath>
#include <thread>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "controller/impedance/load_parameters.hpp"
#include "controller/impedance/service.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "tests/idl/bus_fixture.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/panda.hpp"

using namespace c3rt;
using namespace c3rt::impedance;

namespace {

using wire::test::eventually;
using wire::test::kMs;
using wire::test::kSecond;

constexpr std::uint64_t kSession = 7;
constexpr double kStartPosture[7] = {0, 0.275, 0, -2.222, 0, 2.497, 0};

constexpr char kScenario[] = C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml";

Parameters parameters() {
  config::Section scenario = config::Document::load(kScenario);
  return load_parameters(scenario.section("impedance"), config::load_robot(scenario));
}

wire::RobotState robot_state(std::int64_t now_ns) {
  wire::RobotState state{};
  state.header.time_ns = now_ns;
  std::copy(std::begin(kStartPosture), std::end(kStartPosture), state.q_rad);
  state.mode = c3rt_v2_ROBOT_MOVE;
  return state;
}

wire::Plan plan(std::int64_t now_ns) {
  wire::Plan plan{};
  plan.origin = {now_ns - 5, now_ns - 4, now_ns - 3, 0};
  plan.valid_until_ns = now_ns + 100 * kMs;
  plan.knot_count = 1;
  plan.knots[0].p_WE_m[0] = 0.55;
  plan.knots[0].p_WE_m[2] = 0.123;
  plan.knots[0].q_WE[1] = 1;
  plan.knots[0].time_ns = now_ns + 13 * kMs;
  return plan;
}

/// The robot and the planner of a session, as far as the impedance process sees them.
struct World {
  World()
      : bus(wire::test::settings(wire::ClockMode::kRealtime, kSession)),
        states(bus),
        plans(bus),
        commands(bus) {}
  void write_state() {
    const std::int64_t now_ns = rt::now_ns();
    wire::RobotState state = robot_state(now_ns);
    states.write(state, now_ns);
  }
  void write_plan() {
    const std::int64_t now_ns = rt::now_ns();
    wire::Plan sample = plan(now_ns);
    plans.write(sample, now_ns);
  }
  wire::Bus bus;
  wire::Writer<wire::RobotState> states;
  wire::Writer<wire::Plan> plans;
  wire::Reader<wire::RobotCommand> commands;
};

/// Everything of c3rt-impedance but its main.
struct Process {
  explicit Process(const wire::BusSettings& settings)
      : bus(settings),
        endpoint(bus, c3rt_v2_PROCESS_IMPEDANCE, {}, {}, wire::Wakes::kItself),
        servo(bus, parameters(), model::Arm(test::panda_arm()), endpoint.status().compute()),
        service(servo, endpoint) {}
  wire::Bus bus;
  wire::Endpoint endpoint;
  Servo servo;
  Service service;
};

TEST_CASE(
    "servo: from network to network a cycle does not allocate, and every command answers its "
    "state") {
  World world;
  Process process(wire::test::settings());
  std::atomic<bool> running{true};
  std::atomic<std::int64_t> heap_calls{-1}, cycles{0}, tracked{0};
  REQUIRE(eventually([&] {
    world.write_state();
    world.write_plan();
    process.servo.cycle(rt::now_ns());
    return process.servo.state_to_command().snapshot().count > 0;
  }));

  std::thread servo_thread([&] {
    rt::PeriodicClock clock(kMs);
    const support::AllocationCounter heap;
    Snapshot snapshot;
    while (running) {
      process.servo.cycle(clock.wait().woke_ns);
      if (process.servo.take_snapshot(snapshot) && snapshot.mode == Mode::kTrack) ++tracked;
      ++cycles;
    }
    heap_calls = heap.count();
  });
  int received = 0;
  wire::RobotCommand command{};
  const bool enough = eventually([&] {
    world.write_state();
    if (received % 10 == 0) world.write_plan();
    while (world.commands.take(command)) ++received;
    return received >= 300 && tracked >= 300;
  });
  running = false;
  servo_thread.join();
  CHECK(enough);
  CHECK(heap_calls == 0);
  CHECK(cycles > 300);
  CHECK(command.header.session_id == kSession);
  CHECK(command.origin.state_ns > 0);
  CHECK(command.header.time_ns >= command.origin.state_ns);
  CHECK(command.origin.plan_ns > 0);
  CHECK(command.origin.exposure_ns ==
        command.origin.plan_ns - 5);  // handed on from the plan's own origin
  CHECK(command.mode == c3rt_v2_IMPEDANCE_TRACK);
  CHECK(command.p_WE_desired_m[2] == Approx(0.123));
}

TEST_CASE("servo: it sends nothing before it has seen the robot") {
  World world;
  Process process(wire::test::settings());
  REQUIRE(eventually(
      [&] { return world.plans.matched_readers() > 0 && world.commands.matched_writers() > 0; }));
  for (int k = 0; k < 100; ++k) {
    world.write_plan();
    process.servo.cycle(rt::now_ns());
    usleep(1000);
  }
  wire::RobotCommand command{};
  CHECK_FALSE(world.commands.take(command));
  process.service.poll(rt::now_ns());
  CHECK(process.service.text() == "waits for the robot's state");
}

/// Drives a process by hand in realtime until the condition holds.
template <typename Condition>
bool drive(World& world, Process& process, const Condition& condition) {
  return eventually([&] {
    world.write_state();
    process.servo.cycle(rt::now_ns());
    process.service.poll(rt::now_ns());
    return condition();
  });
}

TEST_CASE(
    "service: a person's stop and recovery are obeyed and answered, with the reason in the "
    "status") {
  World world;
  Process process(wire::test::settings());
  wire::Writer<wire::ServiceRequest> requests(world.bus);
  wire::Reader<wire::ServiceReply> replies(world.bus);
  REQUIRE(drive(world, process, [&] {
    return process.service.text() == "holds its position: no plan has arrived";
  }));

  const auto ask = [&](std::uint64_t id, c3rt_v2_RequestVerb verb) {
    wire::ServiceRequest request{};
    request.request_id = id;
    request.process = c3rt_v2_PROCESS_IMPEDANCE;
    request.verb = verb;
    requests.write(request, rt::now_ns());
    wire::ServiceReply reply{};
    CHECK(drive(world, process, [&] { return replies.take(reply); }));
    CHECK(reply.request_id == id);
    CHECK(reply.process == c3rt_v2_PROCESS_IMPEDANCE);
    CHECK(reply.ok);
  };
  ask(1, c3rt_v2_REQUEST_STOP);
  CHECK(process.service.text() ==
        "stopped: a stop was requested; damps until a recovery is requested");
  ask(2, c3rt_v2_REQUEST_RECOVER);
  CHECK(process.service.text() == "holds its position: no plan has arrived");
}

TEST_CASE(
    "service: an injected NaN reaches the command and ends; a stalled process sends nothing") {
  World world;
  Process process(wire::test::settings());
  wire::Writer<wire::FaultInject> faults(world.bus);
  wire::RobotCommand command{};
  REQUIRE(drive(world, process, [&] { return world.commands.take(command); }));
  CHECK(std::isfinite(command.tau_nm[0]));

  wire::FaultInject fault{};
  fault.process = c3rt_v2_PROCESS_IMPEDANCE;
  fault.kind = c3rt_v2_FAULT_NAN;
  fault.duration_s = 1000;
  faults.write(fault, rt::now_ns());
  const auto refused = [&] { return world.commands.counters().refused_for(wire::Reason::kValue); };
  CHECK(drive(world, process, [&] {
    world.commands.take_newest(command);
    return refused() > 0;  // no reader lets it in
  }));
  fault.kind = c3rt_v2_FAULT_NONE;
  faults.write(fault, rt::now_ns());
  CHECK(drive(world, process, [&] {
    return world.commands.take_newest(command) && std::isfinite(command.tau_nm[0]);
  }));

  fault.kind = c3rt_v2_FAULT_STALL;
  faults.write(fault, rt::now_ns());
  int silent = 0;  // cycles in a row without a command
  CHECK(drive(world, process, [&] {
    usleep(1000);
    silent = world.commands.take_newest(command) ? 0 : silent + 1;
    return silent > 200;
  }));
}

TEST_CASE(
    "servo: in lockstep a plan counts from its stamp on and a cycle answers the tick's own state") {
  wire::Bus bus(wire::test::settings(wire::ClockMode::kLockstep, kSession));
  wire::Writer<wire::RobotState> states(bus);
  wire::Writer<wire::Plan> plans(bus);
  wire::Reader<wire::RobotCommand> commands(bus);
  Process process(wire::test::settings(wire::ClockMode::kLockstep, kSession));
  REQUIRE(eventually([&] {
    return states.matched_readers() > 0 && plans.matched_readers() > 0 &&
           commands.matched_writers() > 0;
  }));
  wire::Plan later = plan(5 * kMs);  // on its way: takes effect at 5 ms
  plans.write(later, 5 * kMs);
  for (int k = 1; k <= 8; ++k) {
    wire::RobotState state = robot_state(k * kMs);
    states.write(state, k * kMs);
    wire::Sequences promised{};
    promised[wire::topic<wire::RobotState>().stream] = states.seq();
    promised[wire::topic<wire::Plan>().stream] = plans.seq();
    std::string missing;
    REQUIRE(process.bus.wait_for(promised, 10 * kSecond, missing));
    process.servo.cycle(k * kMs);
    wire::RobotCommand command{};
    REQUIRE(eventually([&] { return commands.take(command); }));
    CHECK(command.header.time_ns == k * kMs);
    CHECK(command.origin.state_ns == k * kMs);
    CHECK(command.mode == (k < 5 ? c3rt_v2_IMPEDANCE_HOLD : c3rt_v2_IMPEDANCE_TRACK));
    CHECK(command.origin.plan_ns == (k < 5 ? 0 : 5 * kMs));
  }
}

TEST_CASE("service: every mode and verdict has its sentence") {
  Snapshot snapshot;
  snapshot.mode = Mode::kHold;
  snapshot.plan = PlanVerdict::kStale;
  CHECK(describe(snapshot) == "holds its position: the plan is too old");
  snapshot.plan = PlanVerdict::kOtherSession;
  CHECK(describe(snapshot) == "holds its position: the plan is of another session");
  snapshot.mode = Mode::kTrack;
  CHECK(describe(snapshot) == "tracks the plan");
  snapshot.mode = Mode::kStop;
  snapshot.stop_reason = StopReason::kStateStale;
  CHECK(describe(snapshot) ==
        "stopped: the robot state is stale; damps until a recovery is requested");
  snapshot.ends_alone = true;
  CHECK(describe(snapshot) ==
        "stopped: the robot state is stale; damps until it comes steadily again");
}

}  // namespace
