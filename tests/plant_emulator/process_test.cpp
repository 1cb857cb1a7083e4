// The process c3rt-plant on a real bus, with this test as its controller.
#include "idl/process.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "plant_emulator/plant.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/own_domain.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

const std::string kScenario =
    std::string(C3RT_SOURCE_DIRECTORY) + "/config/scenarios/circle_slow.yaml";
const std::string kProfile = std::string(C3RT_SOURCE_DIRECTORY) + "/config/dds/loopback.xml";
constexpr std::int64_t kSecond = 1'000'000'000;

std::uint32_t test_domain() { return support::kOwnDomain; }

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

/// The plant in lockstep with this test as who moves it: orders, motions, and what comes back.
class Mover {
 public:
  /// One cycle. @param motion to be sent; nullptr: none
  void cycle(wire::RobotMotion* motion) {
    if (!loop_.wait(now_ns_)) FAIL(loop_.failure());
    REQUIRE(states_.take(state));
    wire::RobotContact sample{};
    while (contacts_.take(sample)) contact = sample;
    if (motion == nullptr) return;
    motion->origin.state_ns = now_ns_;
    REQUIRE(motions_.write(*motion, now_ns_));
  }
  void rest(int cycles) {
    for (int i = 0; i < cycles; ++i) cycle(nullptr);
  }
  /// Orders, and turns the cycle until it is answered. Empty: obeyed, else why not.
  std::string order(wire::RobotOrder order, wire::RobotMotion* meanwhile = nullptr) {
    order.request_id = ++asked_;
    orders_.write(order, 0);
    for (int i = 0; i < 5000; ++i) {
      cycle(meanwhile);
      wire::ServiceReply reply{};
      while (replies_.take(reply)) {
        if (reply.request_id == asked_) return reply.ok ? "" : reply.text;
      }
    }
    return "not answered";
  }
  /// Joint 7 by `way` within `cycles`, as 10 s^3 - 15 s^4 + 6 s^5; without the samples `lost`.
  void turn(double way, int cycles, const std::function<bool(int)>& lost = {}) {
    const wire::RobotState start = state;
    wire::RobotMotion motion{};
    motion.kind = c3rt_v2_MOTION_JOINT_POSITION;
    for (int k = 0; k <= cycles; ++k) {
      const double s = static_cast<double>(k) / cycles;
      std::copy(std::begin(start.q_rad), std::end(start.q_rad), motion.q_rad);
      motion.q_rad[6] += way * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
      motion.finished = k == cycles;
      const double led = motion.q_rad[6];
      cycle(lost && lost(k) ? nullptr : &motion);
      // the state that came is of where the sample before this one led
      if (k > 0) farthest = std::max(farthest, std::abs(state.q_rad[6] - led_));
      led_ = led;
    }
    cycle(nullptr);
  }
  /// Turns the cycle until it is so. @return false if it does not become so
  bool until(const std::function<bool()>& condition) {
    for (int i = 0; i < 5000 && !condition(); ++i) cycle(nullptr);
    return condition();
  }

  wire::RobotState state{};
  wire::RobotContact contact{};
  double farthest = 0.0;  // of joint 7 from where a motion led it [rad]

 private:
  Child child_{kScenario, {"--clock", "lockstep", "--expect", "impedance"}};
  wire::Bus bus_{{test_domain(), kProfile, "client", wire::ClockMode::kLockstep, 0}};
  wire::Reader<wire::RobotState> states_{bus_};
  wire::Reader<wire::RobotContact> contacts_{bus_};
  wire::Reader<wire::ServiceReply> replies_{bus_};
  wire::Writer<wire::RobotMotion> motions_{bus_};
  wire::Writer<wire::RobotOrder> orders_{bus_};
  wire::Loop loop_{bus_, {c3rt_v2_PROCESS_IMPEDANCE, 1'000'000}};
  std::int64_t now_ns_ = 0;
  std::uint64_t asked_ = 0;
  double led_ = 0.0;
};

TEST_CASE("in lockstep a client's motion turns a joint as it says, and a gap in it brakes") {
  Mover mover;
  mover.rest(5);
  const double start = mover.state.q_rad[6];
  mover.turn(0.3, 800);
  CHECK(mover.state.mode == c3rt_v2_ROBOT_IDLE);
  CHECK(mover.state.errors == 0);
  CHECK(mover.state.q_rad[6] - start == Approx(0.3).margin(1e-3));
  CHECK(mover.farthest < 1e-3);
  CHECK(mover.farthest > 0.0);
  mover.rest(200);

  mover.turn(-0.05, 800, [](int k) { return k >= 100 && k < 119; });
  CHECK(mover.state.mode == c3rt_v2_ROBOT_IDLE);  // nineteen are bridged
  CHECK(mover.state.errors == 0);
  mover.rest(200);
  mover.turn(0.05, 800, [](int k) { return k >= 100 && k < 120; });
  CHECK(mover.state.mode == c3rt_v2_ROBOT_REFLEX);
  CHECK(mover.state.errors == bit(Error::kCommunicationConstraintsViolation));
  mover.rest(500);
  CHECK(std::abs(mover.state.dq_rad_per_s[6]) < 0.01);
}

TEST_CASE("in lockstep a client leads the arm by the hand, and sets what a collision is") {
  Mover mover;
  mover.rest(5);
  wire::RobotOrder guide{}, release{}, push{}, thresholds{};
  guide.kind = release.kind = c3rt_v2_ORDER_GUIDING;
  guide.engaged = true;
  push.kind = c3rt_v2_ORDER_PUSH;
  push.force_W_n[1] = 15.0;
  push.duration_s = 0.5;
  thresholds.kind = c3rt_v2_ORDER_THRESHOLDS;
  CHECK(mover.order(guide) ==
        "refused: free_axes is 0, expected 1 to 63");  // and the arm is not led
  guide.free_axes = 63;
  guide.free_elbow = true;
  REQUIRE(mover.order(guide).empty());
  CHECK(mover.until([&] { return mover.contact.guided; }));
  const double start = mover.state.p_WE_m[1];
  REQUIRE(mover.order(push).empty());
  mover.rest(600);
  CHECK(mover.state.p_WE_m[1] > start + 0.02);
  REQUIRE(mover.order(release).empty());
  CHECK(mover.until([&] { return !mover.contact.guided; }));
  mover.rest(500);
  CHECK(mover.state.mode == c3rt_v2_ROBOT_IDLE);

  for (c3rt_v2_ContactThresholds* t : {&thresholds.acceleration, &thresholds.nominal}) {
    std::fill(std::begin(t->collision_torque_nm), std::end(t->collision_torque_nm), 50.0);
    std::fill(std::begin(t->collision_force_E_n), std::end(t->collision_force_E_n), 20.0);
    std::fill(std::begin(t->collision_torque_E_nm), std::end(t->collision_torque_E_nm), 50.0);
  }
  REQUIRE(mover.order(thresholds).empty());
  wire::RobotMotion hold{};
  hold.kind = c3rt_v2_MOTION_JOINT_VELOCITY;
  for (int i = 0; i < 100; ++i) mover.cycle(&hold);
  REQUIRE(mover.state.mode == c3rt_v2_ROBOT_MOVE);
  CHECK_THAT(mover.order(thresholds, &hold),
             Catch::Contains("expected a robot that nothing moves") &&
                 Catch::Contains("follows commands"));
  push.force_W_n[1] = 0.0;
  for (const double force : {14.0, 28.0}) {
    CAPTURE(force);
    push.force_W_n[2] = force;
    push.duration_s = 0.2;
    REQUIRE(mover.order(push, &hold).empty());
    for (int i = 0; i < 300; ++i) mover.cycle(&hold);
    CHECK(mover.state.mode == (force < 20.0 ? c3rt_v2_ROBOT_MOVE : c3rt_v2_ROBOT_REFLEX));
  }
  CHECK((mover.state.errors & bit(Error::kCartesianReflex)) != 0);
  CHECK(mover.until([&] { return mover.contact.error >= 0; }));
  CHECK(mover.contact.error == static_cast<int>(Error::kCartesianReflex));
  CHECK(mover.contact.limit == 20.0);
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
