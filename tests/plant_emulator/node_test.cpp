// The plant on the types of the wire, without a bus and a clock.
#include "plant_emulator/node.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "idl/validate.hpp"
#include "tests/plant_emulator/parameters.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

constexpr double kExposureRate = 80.0;  // [1/s]

TEST_CASE("plant node: what is told is the plant's state, and a command acts in the next cycle") {
  Node node(test_parameters(), kExposureRate, 1);
  const Node::Output& out = node.start(kCycleNs);
  CHECK(out.state.mode == c3rt_v2_ROBOT_IDLE);
  CHECK(out.scene_due);
  CHECK(out.scene.exposure);
  CHECK(out.scene.object_count == 1);

  wire::RobotCommand command{};
  command.header.seq = 1;
  command.origin.state_ns = kCycleNs;
  command.tau_nm[5] = 0.5;
  node.step(2 * kCycleNs, &command);
  CHECK(out.state.mode == c3rt_v2_ROBOT_MOVE);
  CHECK(out.state.command_seq == 1);
  CHECK(out.state.command_state_ns == kCycleNs);
  CHECK(out.state.tau_nm[5] == 0.5);
  const State& state = node.plant().state();
  for (int i = 0; i < kJoints; ++i) {
    CHECK(out.state.q_rad[i] == state.q[i]);
    CHECK(out.state.dq_rad_per_s[i] == state.dq[i]);
  }
  CHECK(out.state.q_WE[0] == state.q_WE.w());
  CHECK(out.state.q_WE[3] == state.q_WE.z());
}

TEST_CASE("plant node: the scene is told at every exposure and every 10 ms, and not between") {
  Node node(test_parameters(), kExposureRate, 1);
  int exposures = 0, scenes = 0;
  for (int ms = 1; ms <= 1000; ++ms) {
    const Node::Output& out = ms == 1 ? node.start(kCycleNs) : node.step(ms * kCycleNs, nullptr);
    exposures += out.scene_due && out.scene.exposure;
    scenes += out.scene_due;
  }
  // 81 and 101 instants from 0 to 1 s; every 50 ms both at once
  CHECK(exposures == 81);
  CHECK(scenes == 81 + 101 - 21);
  CHECK(node.counters().exposures == 81);
}

TEST_CASE("plant node: contact is told every 10 ms, and the cause of a stop at once") {
  Node node(test_parameters(), kExposureRate, 1);
  int told = 0;
  std::int64_t now_ns = kCycleNs;
  for (int ms = 1; ms <= 100; ++ms) told += node.step(now_ns += kCycleNs, nullptr).contact_due;
  CHECK(told == 11);
  wire::RobotCommand command{};
  command.header.seq = 1;
  command.tau_nm[3] = NAN;
  const Node::Output& out = node.step(now_ns += kCycleNs, &command);
  REQUIRE(out.contact_due);
  CHECK(out.contact.errors == bit(Error::kCommandNotFinite));
  CHECK(out.contact.error == static_cast<int>(Error::kCommandNotFinite));
  CHECK(out.contact.axis == 4);
  CHECK(out.contact.limit == 87.0);
  CHECK(wire::validate(out.contact).reason == wire::Reason::kNone);
}

TEST_CASE("plant node: faults act for as long as was asked, and are counted") {
  Node node(test_parameters(), kExposureRate, 1);
  node.obey({OrderKind::kNan, 0, 0.0025, Eigen::Vector3d::Zero()});
  CHECK(std::isnan(node.step(2 * kCycleNs, nullptr).state.q_rad[0]));
  CHECK(std::isnan(node.step(3 * kCycleNs, nullptr).state.q_rad[0]));
  CHECK(std::isfinite(node.step(4 * kCycleNs, nullptr).state.q_rad[0]));
  node.obey({OrderKind::kPushObject, 0, 0.0, Eigen::Vector3d(0.132, 0.0, 0.0)});
  node.step(5 * kCycleNs, nullptr);
  // 0.132 N s on a ball of 0.132 kg: 1 m/s where it slides, 5/7 of that where it rolls at once
  const double v = node.plant().state().objects[0].v_WB.x();
  CHECK(v < 1.0);
  CHECK(v > 5.0 / 7.0);
  CHECK(node.counters().faults == 2);
}

TEST_CASE("plant node: a reflex is counted once, and moving cycles in a row") {
  Node node(test_parameters(), kExposureRate, 1);
  wire::RobotCommand command{};
  std::int64_t now_ns = kCycleNs;
  for (int i = 0; i < 5; ++i) {
    ++command.header.seq;
    node.step(now_ns += kCycleNs, &command);
  }
  CHECK(node.counters().moving_cycles == 5);
  for (int i = 0; i < 2 * kLostCommandsMax; ++i) node.step(now_ns += kCycleNs, nullptr);
  CHECK(node.plant().state().mode == Mode::kReflex);
  CHECK(node.counters().reflexes == 1);
  CHECK(node.counters().moving_cycles == 0);
}

}  // namespace
