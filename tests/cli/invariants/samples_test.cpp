#include "cli/invariants/samples.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

#include "controller/task/circle.hpp"
#include "idl/text.hpp"
#include "plant_emulator/errors.hpp"

using namespace c3rt;
using cli::invariants::Limits;
using cli::invariants::Samples;
using cli::invariants::Violations;

namespace {

constexpr std::int64_t kMs = 1'000'000;

Limits limits() {
  Limits result;
  result.tau_max << 87, 87, 87, 87, 12, 12, 12;
  result.tau_rate_max = 1000.0;  // 1 N m a cycle
  result.workspace_min = Eigen::Vector3d(0.3, -0.3, 0.0);
  result.workspace_max = Eigen::Vector3d(0.8, 0.3, 0.4);
  result.object_error = 0.02;
  return result;
}

/// Streams that keep everything: an arm that follows plans of 5 ms, and a ball that goes round the
/// circle. A test spoils one sample.
struct Run {
  explicit Run(const Limits& with = limits()) : samples(with, circle(), violations) {}

  static task::Task circle() {
    task::Circle circle{};
    circle.center = {0.55, 0.0};
    circle.radius = 0.1;
    circle.lead = 0.349;
    return circle;
  }

  /// One cycle of everything.
  void cycle() {
    ++count;
    const std::int64_t now_ns = count * kMs;
    if (count % 5 == 1) tell_plan(now_ns);
    scene.header = {7, static_cast<std::uint64_t>(count), now_ns};
    // a circle of the ball in 1 s
    const double angle = -2.0 * M_PI * 0.001 * static_cast<double>(count);
    scene.object_count = 1;
    scene.objects[0].p_WB_m[0] = 0.55 + (0.1 + off) * std::cos(angle);
    scene.objects[0].p_WB_m[1] = (0.1 + off) * std::sin(angle);
    scene.objects[0].q_WB[0] = 1.0;
    samples.hear(scene);
    state.header = {7, static_cast<std::uint64_t>(count), now_ns};
    state.mode = mode;
    state.p_WE_m[0] = 0.55;
    state.p_WE_m[2] = height;
    state.tau_nm[0] = torque;
    state.command_seq = commands;
    samples.hear(state);
    if (!commanded) return;
    ++commands;
    command.header = {7, commands, now_ns};
    command.mode = c3rt_v2_IMPEDANCE_TRACK;
    command.origin.plan_ns = plan.header.time_ns;
    command.tau_nm[0] = asked;
    samples.hear(command);
  }
  void tell_plan(std::int64_t now_ns) {
    if (!planned) return;
    plan.header = {7, plan.header.seq + 1, now_ns};
    plan.origin.state_ns = now_ns;
    plan.valid_until_ns = now_ns + 100 * kMs;
    wire::set_text(plan.phase, "roll");
    samples.hear(plan);
  }
  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  std::uint64_t of(const char* name) const {
    const auto found = violations.counts().find(name);
    return found == violations.counts().end() ? 0 : found->second;
  }

  Violations violations;
  Samples samples;
  std::int64_t count = 0;
  std::uint64_t commands = 0;
  c3rt_v2_RobotMode mode = c3rt_v2_ROBOT_MOVE;
  double torque = 0.0, asked = 0.0, height = 0.02, off = 0.0;
  bool planned = true, commanded = true;
  wire::Scene scene{};
  wire::RobotState state{};
  wire::RobotCommand command{};
  wire::Plan plan{};
};

}  // namespace

TEST_CASE("samples: a run that keeps everything violates nothing") {
  Run run;
  run.cycles(100);
  for (int i = 0; i < 80; ++i) {  // the torque grows as fast as it may, up to its limit
    run.torque += 1.0;
    run.asked += 1.0;
    run.cycle();
  }
  run.cycles(2000);
  for (const auto& [name, count] : run.violations.counts()) UNSCOPED_INFO(name << " " << count);
  CHECK(run.violations.count() == 0);
  CHECK(run.samples.samples() > 6000);
  CHECK(run.samples.reflexes() == 0);
}

TEST_CASE("samples: a torque beyond the joint's limit is seen, applied and asked for") {
  Run run;
  run.cycles(10);
  SECTION("applied") {
    run.state.tau_nm[5] = 12.1;
    run.cycle();
    CHECK(run.of("torque") == 1);
    CHECK(run.violations.kept().front().limit == 12.0);
    CHECK(run.violations.kept().front().subject == "robot/state");
  }
  SECTION("asked for") {
    run.command.tau_nm[6] = -12.1;
    run.cycle();
    CHECK(run.of("torque") == 1);
    CHECK(run.violations.kept().front().subject == "robot/command");
  }
  SECTION("a brake is no motor") {
    run.mode = c3rt_v2_ROBOT_USER_STOPPED;
    run.state.tau_nm[5] = 30.0;
    run.cycle();
    CHECK(run.violations.count() == 0);
  }
}

TEST_CASE("samples: a torque that changes by more than a cycle's share is seen") {
  Run run;
  run.cycles(10);
  SECTION("of the robot") {
    run.torque = 1.01;
    run.cycle();
    CHECK(run.of("torque_rate") == 1);
    CHECK(run.violations.kept().front().value == Approx(1010.0));
  }
  SECTION("of the command") {
    run.asked = -1.01;
    run.cycle();
    CHECK(run.of("torque_rate") == 1);
  }
  SECTION("over samples that were not heard it may have changed for as long") {
    run.count += 2;
    run.commands += 2;
    run.torque = run.asked = 3.0;
    run.cycle();
    CHECK(run.violations.count() == 0);
    run.count += 2;
    run.commands += 2;
    run.torque = run.asked = 6.1;
    run.cycle();
    CHECK(run.of("torque_rate") == 2);
  }
}

TEST_CASE(
    "samples: in realtime a sample may have been replaced by the next one, so twice as much") {
  Limits realtime = limits();
  realtime.realtime = true;
  Run run(realtime);
  run.cycles(10);
  run.torque = run.asked = 2.0;
  run.cycle();
  CHECK(run.violations.count() == 0);
  run.torque = run.asked = 4.1;
  run.cycle();
  CHECK(run.of("torque_rate") == 2);
}

TEST_CASE("samples: numbers that are not finite are seen") {
  Run run;
  run.cycles(10);
  run.asked = std::numeric_limits<double>::quiet_NaN();
  run.cycle();
  CHECK(run.of("not_finite") == 1);
  run.state.p_WE_m[1] = std::numeric_limits<double>::quiet_NaN();
  run.cycle();
  CHECK(run.of("not_finite") == 2);
}

TEST_CASE("samples: an end effector more than 2 cm outside of its workspace is seen") {
  Run run;
  run.cycles(10);
  run.height = -0.015;
  run.cycle();
  CHECK(run.violations.count() == 0);
  run.height = -0.021;
  run.cycle();
  CHECK(run.of("workspace") == 1);
}

TEST_CASE("samples: a plan is followed for one cycle after its end, not for two") {
  Run run;
  run.cycles(11);  // the last plan is of 11 ms, valid until 111 ms
  run.planned = false;
  run.cycles(100);  // up to 111 ms
  CHECK(run.violations.count() == 0);
  run.cycle();  // 112 ms: decided when the plan had just ended
  CHECK(run.violations.count() == 0);
  run.cycle();  // 113 ms: the command before it came after the end
  CHECK(run.of("stale_plan") == 1);
  CHECK(run.violations.kept().front().value == Approx(0.002));
}

TEST_CASE("samples: sequence numbers and times that go back are seen") {
  Run run;
  run.cycles(10);
  SECTION("sequence") {
    run.samples.hear(run.command);
    CHECK(run.of("sequence") == 1);
    CHECK(run.of("time") == 0);
  }
  SECTION("time") {
    wire::Plan early = run.plan;
    ++early.header.seq;
    early.header.time_ns -= 1;
    run.samples.hear(early);
    CHECK(run.of("time") == 1);
    CHECK(run.of("sequence") == 0);
  }
  SECTION("of a process's status") {
    wire::ServiceStatus status{};
    status.process = c3rt_v2_PROCESS_VISION;
    status.header.seq = 5;
    run.samples.hear(status);
    status.process = c3rt_v2_PROCESS_PLANNER;  // each process counts for itself
    status.header.seq = 1;
    run.samples.hear(status);
    CHECK(run.violations.count() == 0);
    run.samples.hear(status);
    CHECK(run.of("sequence") == 1);
  }
}

TEST_CASE("samples: a process that was started again counts from 1") {
  Run run;
  run.cycles(10);
  run.commands = 0;
  run.asked = 30.0;
  run.samples.restarted(c3rt_v2_PROCESS_IMPEDANCE);
  run.cycle();
  CHECK(run.violations.count() == 0);
}

TEST_CASE(
    "samples: of a process that was killed the last samples may come before its successor's") {
  Run run;
  run.cycles(10);
  run.samples.restarted(c3rt_v2_PROCESS_IMPEDANCE);
  run.cycles(3);  // still its own
  for (int i = 0; i < 2; ++i) {
    run.commands = 0;
    run.cycle();
    CHECK(run.of("sequence") == (i == 0 ? 0u : 1u));  // it was killed once
  }
}

TEST_CASE("samples: a time that goes back is seen, but while clocks are made to jump") {
  const bool excused = GENERATE(true, false);
  Run run;
  run.cycles(10);
  if (excused) run.samples.excuse_time(11 * kMs);
  wire::ObjectEstimate estimate{};
  estimate.header = {7, 1, 11 * kMs};
  run.samples.hear(estimate);
  estimate.header = {7, 2, 10 * kMs};
  run.samples.hear(estimate);
  CHECK(run.of("time") == (excused ? 0u : 1u));
}

TEST_CASE("samples: a reflex without a cause is seen, with its errors' names") {
  Run run;
  run.cycles(10);
  run.mode = c3rt_v2_ROBOT_REFLEX;
  run.state.errors = plant::bit(plant::Error::kJointVelocityViolation);
  SECTION("none") {
    run.cycles(20);
    CHECK(run.of("reflex") == 1);
    CHECK(run.violations.kept().front().subject == "robot/state: joint_velocity_violation");
    CHECK(run.samples.reflexes() == 1);
  }
  SECTION("something was done that explains it") {
    run.samples.excuse(11 * kMs);
    run.cycles(20);
    CHECK(run.of("reflex") == 0);
    CHECK(run.samples.reflexes() == 1);
  }
  SECTION("that was too long ago") {
    run.samples.excuse(10 * kMs);
    run.cycles(20);
    CHECK(run.of("reflex") == 1);
  }
}

TEST_CASE("samples: a reflex of lost commands has its cause where commands were lost") {
  Run run;
  run.cycles(10);
  run.state.errors = plant::bit(plant::Error::kCommunicationConstraintsViolation);
  const int lost = GENERATE(5, 19);
  run.commanded = false;
  run.cycle();  // the last command arrives
  run.cycles(lost);
  run.mode = c3rt_v2_ROBOT_REFLEX;
  run.cycles(5);
  CHECK(run.of("reflex") == (lost < 19 ? 1u : 0u));
}

TEST_CASE(
    "samples: when the newest command came is known where the first state of it was replaced") {
  const int lost = GENERATE(17, 20);
  Run run;
  run.cycles(10);
  run.commanded = false;
  run.state.command_state_ns = run.count * kMs;
  ++run.commands;
  run.count += 3;  // of which three states tell that were not sent
  run.cycles(lost - 3);
  run.state.errors = plant::bit(plant::Error::kCommunicationConstraintsViolation);
  run.mode = c3rt_v2_ROBOT_REFLEX;
  run.cycles(5);
  CHECK(run.of("reflex") == (lost < 20 ? 1u : 0u));
}

TEST_CASE("samples: cycles that come closer together after a pause count as cycles") {
  const int lost = GENERATE(17, 19);
  Run run;
  run.cycles(10);
  run.commanded = false;
  run.cycle();  // the last command arrives
  const std::int64_t from_ns = run.count * kMs;
  for (int i = 1; i <= lost + 1; ++i) {
    wire::RobotState state = run.state;
    state.header.seq += static_cast<std::uint64_t>(i);
    state.header.time_ns = from_ns + i * kMs * 9 / 10;
    state.command_seq = run.commands;
    if (i > lost) {
      state.mode = c3rt_v2_ROBOT_REFLEX;
      state.errors = plant::bit(plant::Error::kCommunicationConstraintsViolation);
    }
    run.samples.hear(state);
  }
  CHECK(run.of("reflex") == (lost < 19 ? 1u : 0u));
}

TEST_CASE("samples: a robot that moves on without commands is seen after 20 cycles") {
  Run run;
  run.cycles(10);
  run.commanded = false;
  run.cycle();  // the last command arrives
  run.cycles(20);
  CHECK(run.of("brake") == 0);
  SECTION("it stops itself") {
    run.mode = c3rt_v2_ROBOT_REFLEX;
    run.state.errors = plant::bit(plant::Error::kCommunicationConstraintsViolation);
    run.cycles(100);
    CHECK(run.violations.count() == 0);
  }
  SECTION("it does not") {
    run.cycles(2);
    CHECK(run.of("brake") == 1);
  }
}

TEST_CASE("samples: an object off its path is seen once the task judges it") {
  Run run;
  run.off = 0.021;
  run.cycles(240);  // the first quarter of the circle
  CHECK(run.violations.count() == 0);
  run.cycles(100);
  CHECK(run.of("object") == 1);
  CHECK(run.violations.kept().front().value == Approx(0.021));
}

TEST_CASE("samples: while the task has ended an object may be anywhere within reach") {
  Run run;
  run.cycles(500);
  run.samples.end_task();
  run.off = 0.05;
  run.cycles(500);
  CHECK(run.violations.count() == 0);
  run.off = 0.45;
  run.cycles(1);
  CHECK(run.of("object_lost") == 1);
  run.off = 0.05;
  run.samples.begin_task();
  run.cycles(240);  // judged anew from a quarter of the circle on
  CHECK(run.of("object") == 0);
  run.cycles(100);
  CHECK(run.of("object") == 1);
}

TEST_CASE("samples: a process that says it has failed is seen") {
  Run run;
  wire::ServiceStatus status{};
  status.process = c3rt_v2_PROCESS_PLANNER;
  status.header.seq = 1;
  status.state = c3rt_v2_SERVICE_DEGRADED;
  run.samples.hear(status);
  CHECK(run.violations.count() == 0);
  ++status.header.seq;
  status.state = c3rt_v2_SERVICE_FAILED;
  run.samples.hear(status);
  CHECK(run.of("failed") == 1);
  CHECK(run.violations.kept().front().subject == "planner");
}
