// The process c3rt-plant on a real bus, with this test as its controller.
#include "idl/process.hpp"

#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "plant_emulator/plant.hpp"
#include "tests/support/child_process.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

const std::string kScenario =
    std::string(C3RT_SOURCE_DIRECTORY) + "/config/scenarios/circle_slow.yaml";
const std::string kProfile = std::string(C3RT_SOURCE_DIRECTORY) + "/config/dds/loopback.xml";
constexpr std::int64_t kSecond = 1'000'000'000;

std::uint32_t test_domain() { return 100 + static_cast<std::uint32_t>(getpid()) % 100; }

struct Child : test::ChildProcess {
  explicit Child(const std::string& scenario, const std::vector<std::string>& more = {})
      : ChildProcess(test::process_command("c3rt-plant", scenario, test_domain(), more)) {}
};

/// Turns the controller's cycle until `done`, at most 20 s.
bool until(const std::function<bool()>& done, const std::function<void()>& cycle) {
  rt::PeriodicClock clock(1'000'000);
  const std::int64_t end_ns = rt::now_ns() + 20 * kSecond;
  while (!done()) {
    if (rt::now_ns() > end_ns) return false;
    cycle();
    clock.wait();
  }
  return true;
}

TEST_CASE(
    "in realtime the plant moves while it is commanded, stops when it is not, and recovers on "
    "request") {
  Child child(kScenario, {"--clock", "realtime", "--set", "plant.objects.0.start_spread_m=0"});
  wire::Bus bus({test_domain(), kProfile, "client", wire::ClockMode::kRealtime, 0});
  wire::Reader<wire::RobotState> states(bus);
  wire::Reader<wire::Scene> scenes(bus);
  wire::Reader<wire::ServiceReply> replies(bus);
  wire::Reader<wire::ServiceStatus> statuses(bus);
  wire::Writer<wire::RobotCommand> commands(bus);
  wire::Writer<wire::ServiceRequest> requests(bus);

  wire::Writer<wire::FaultInject> faults(bus);

  wire::RobotState state{};
  wire::Scene scene{};
  int scenes_seen = 0;
  const auto listen = [&] {
    states.take_newest(state);
    while (scenes.take(scene)) ++scenes_seen;
  };
  const auto command = [&] {
    listen();
    if (state.header.time_ns == 0) return;
    wire::RobotCommand answer{};
    answer.origin.state_ns = state.header.time_ns;
    commands.write(answer, rt::now_ns());
  };
  REQUIRE(until([&] { return state.mode == c3rt_v2_ROBOT_MOVE; }, command));
  CHECK(state.header.session_id == bus.session_id());
  CHECK(state.command_seq > 0);
  CHECK(state.command_state_ns > 0);
  CHECK(std::abs(state.q_rad[3] + 2.222) < 0.01);
  REQUIRE(until([&] { return scenes_seen > 10; }, command));
  CHECK(scene.object_count == 1);
  CHECK(std::abs(scene.objects[0].p_WB_m[0] - 0.55) < 1e-3);

  REQUIRE(until([&] { return state.mode == c3rt_v2_ROBOT_REFLEX; }, listen));
  CHECK(state.errors == bit(Error::kCommunicationConstraintsViolation));
  wire::ServiceStatus status{};
  REQUIRE(until(
      [&] {
        return statuses.take_newest(status) &&
               std::strstr(status.text, "communication_constraints_violation") != nullptr;
      },
      listen));
  CHECK(status.state == c3rt_v2_SERVICE_DEGRADED);

  wire::ServiceRequest request{};
  request.request_id = 7;
  request.process = c3rt_v2_PROCESS_PLANT;
  request.verb = c3rt_v2_REQUEST_RECOVER;
  requests.write(request, rt::now_ns());
  wire::ServiceReply reply{};
  // the reflex ends, but the robot does not move while nobody commands it, and the answer says so
  REQUIRE(until([&] { return replies.take(reply); }, listen));
  CHECK(reply.request_id == 7);
  CHECK_FALSE(reply.ok);
  CHECK_THAT(reply.text, Catch::Contains("no commands arrive"));
  REQUIRE(until([&] { return state.mode == c3rt_v2_ROBOT_IDLE; }, listen));
  CHECK(state.errors == 0);
  request.request_id = 8;
  requests.write(request, rt::now_ns());
  REQUIRE(until([&] { return replies.take(reply); }, command));
  CHECK(reply.request_id == 8);
  CHECK(reply.ok);
  CHECK(state.mode == c3rt_v2_ROBOT_MOVE);

  wire::FaultInject fault{};
  fault.process = c3rt_v2_PROCESS_PLANT;
  fault.kind = c3rt_v2_FAULT_PUSH_OBJECT;
  fault.value[1] = -0.01;
  faults.write(fault, rt::now_ns());
  REQUIRE(until([&] { return scene.objects[0].v_WB_m_per_s[1] < -0.03; }, command));
  fault.kind = c3rt_v2_FAULT_NAN;
  fault.duration_s = 1000;
  faults.write(fault, rt::now_ns());
  const auto refused = [&] { return states.counters().refused_for(wire::Reason::kValue); };
  REQUIRE(until([&] { return refused() > 10; }, command));
  fault.kind = c3rt_v2_FAULT_NONE;
  faults.write(fault, rt::now_ns());
  std::uint64_t good_seq = 0;
  REQUIRE(until([&] { return std::exchange(good_seq, state.header.seq) != state.header.seq; },
                command));
  fault.kind = c3rt_v2_FAULT_DROP_COMMANDS;
  faults.write(fault, rt::now_ns());
  REQUIRE(until([&] { return state.mode == c3rt_v2_ROBOT_REFLEX; }, command));

  const auto counter = [&](const char* wanted) -> std::uint64_t {
    for (int i = 0; i < c3rt_v2_COUNTERS; ++i)
      if (std::strcmp(status.counter_names[i], wanted) == 0) return status.counters[i];
    return 0;
  };
  REQUIRE(until([&] { return statuses.take_newest(status) && counter("reflexes") >= 2; }, listen));
  CHECK(counter("faults") == 4);
  CHECK(counter("cycles") > 100);
  CHECK(counter("lost_commands") >= 2 * (kLostCommandsMax - 1));  // the last one ends the motion
  CHECK(counter("real_time_factor_1e3") > 0);

  child.signal(SIGTERM);
  CHECK(child.wait() == 0);
}

struct Trace {
  std::vector<double> numbers;
  int exposures = 0;
};

/// The states and scenes of 0.4 s in lockstep while a joint spring holds the arm.
Trace lockstep_trace() {
  std::vector<std::string> with_controller{"--clock", "lockstep"};
  with_controller.insert(with_controller.end(), {"--expect", "impedance"});
  Child child(kScenario, with_controller);
  wire::Bus bus({test_domain(), kProfile, "client", wire::ClockMode::kLockstep, 0});
  wire::Reader<wire::RobotState> states(bus);
  wire::Reader<wire::Scene> scenes(bus);
  wire::Writer<wire::RobotCommand> commands(bus);
  wire::Loop loop(bus, {c3rt_v2_PROCESS_IMPEDANCE, 1'000'000});
  Trace trace;
  wire::RobotState state{};
  wire::Scene scene{};
  std::int64_t now_ns = 0;
  for (int i = 0; i < 400; ++i) {
    if (!loop.wait(now_ns)) FAIL(loop.failure());
    REQUIRE(states.take(state));
    REQUIRE(state.header.time_ns == now_ns);
    CHECK(state.command_state_ns ==
          (i == 0 ? 0 : now_ns - 1'000'000));  // the last cycle's answer was applied
    for (const double q : state.q_rad) trace.numbers.push_back(q);
    while (scenes.take(scene)) {
      if (scene.exposure) ++trace.exposures;
      for (const double p : scene.objects[0].p_WB_m) trace.numbers.push_back(p);
    }
    wire::RobotCommand command{};
    command.origin.state_ns = now_ns;
    command.tau_nm[0] = 20 * (0.05 - state.q_rad[0]) - 2 * state.dq_rad_per_s[0];
    REQUIRE(commands.write(command, now_ns));
  }
  child.signal(SIGTERM);
  CHECK(child.wait() == 0);
  return trace;
}

TEST_CASE(
    "in lockstep the plant applies every answer in its own cycle, and twice gives the same bits") {
  const Trace first = lockstep_trace();
  const Trace second = lockstep_trace();
  CHECK(first.numbers.at(399 * 7) != first.numbers.front());
  CHECK(first.exposures == 33);  // 80 Hz: at 0, 12.5, .. 400 ms
  CHECK(first.numbers == second.numbers);
}

TEST_CASE(
    "in lockstep a recovery is answered when the robot moves for good, not at the next hole") {
  Child child(kScenario, {"--clock", "lockstep", "--expect", "impedance"});
  wire::Bus bus({test_domain(), kProfile, "client", wire::ClockMode::kLockstep, 0});
  wire::Reader<wire::RobotState> states(bus);
  wire::Writer<wire::RobotCommand> commands(bus);
  wire::Reader<wire::ServiceReply> replies(bus);
  wire::Writer<wire::ServiceRequest> requests(bus);
  wire::Loop loop(bus, {c3rt_v2_PROCESS_IMPEDANCE, 1'000'000});
  wire::RobotState state{};
  std::vector<wire::ServiceReply> answers;
  const auto cycle = [&](bool with_command) {
    std::int64_t now_ns = 0;
    if (!loop.wait(now_ns)) FAIL(loop.failure());
    REQUIRE(states.take(state));
    wire::RobotCommand command{};
    command.origin.state_ns = now_ns;
    command.tau_nm[0] = -2 * state.dq_rad_per_s[0];
    if (with_command) REQUIRE(commands.write(command, now_ns));
    wire::ServiceReply reply{};
    while (replies.take(reply)) answers.push_back(reply);
  };
  const auto cycles = [&](int count, bool with_command) {
    for (int i = 0; i < count; ++i) cycle(with_command);
  };
  cycles(100, true);
  REQUIRE(state.mode == c3rt_v2_ROBOT_MOVE);
  wire::ServiceRequest request{};
  request.process = c3rt_v2_PROCESS_PLANT;
  request.verb = c3rt_v2_REQUEST_STOP;
  requests.write(request, 0);
  for (int i = 0; i < 5000 && state.mode != c3rt_v2_ROBOT_USER_STOPPED; ++i) cycle(true);
  REQUIRE(state.mode == c3rt_v2_ROBOT_USER_STOPPED);
  request.verb = c3rt_v2_REQUEST_RECOVER;
  request.request_id = 5;
  requests.write(request, 0);
  for (int i = 0; i < 5000 && state.mode != c3rt_v2_ROBOT_MOVE; ++i) cycle(true);
  REQUIRE(state.mode == c3rt_v2_ROBOT_MOVE);
  // before it is known to have worked, as many are missing as stop the robot
  cycles(kLostCommandsMax + 5, false);
  REQUIRE(state.mode == c3rt_v2_ROBOT_REFLEX);
  cycles(150, true);
  CHECK(answers.empty());
  cycles(600, true);
  REQUIRE(until([&] { return !answers.empty(); }, [&] { cycle(true); }));
  CHECK(answers.front().request_id == 5);
  CHECK(answers.front().ok);
  CHECK(std::string(answers.front().text) == "follows commands");
  child.signal(SIGTERM);
  CHECK(child.wait() == 0);
}

TEST_CASE(
    "a scenario that is not there or a process that cannot be expected is refused with exit status "
    "2") {
  CHECK(Child("/nowhere.yaml").wait() == 2);
  std::vector<std::string> wrong{"--clock", "lockstep"};
  wrong.insert(wrong.end(), {"--expect", "nobody"});
  CHECK(Child(kScenario, wrong).wait() == 2);
}

}  // namespace
