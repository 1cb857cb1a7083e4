// The plant on the types of the wire, without a bus and a clock.
#include "plant_emulator/node.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include <catch2/catch.hpp>

#include "idl/validate.hpp"
#include "tests/plant_emulator/parameters.hpp"
#include "tests/support/allocation_counter.hpp"

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
  node.step(2 * kCycleNs, &command, nullptr);
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
    const Node::Output& out =
        ms == 1 ? node.start(kCycleNs) : node.step(ms * kCycleNs, nullptr, nullptr);
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
  for (int ms = 1; ms <= 100; ++ms)
    told += node.step(now_ns += kCycleNs, nullptr, nullptr).contact_due;
  CHECK(told == 11);
  wire::RobotCommand command{};
  command.header.seq = 1;
  command.tau_nm[3] = NAN;
  const Node::Output& out = node.step(now_ns += kCycleNs, &command, nullptr);
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
  CHECK(std::isnan(node.step(2 * kCycleNs, nullptr, nullptr).state.q_rad[0]));
  CHECK(std::isnan(node.step(3 * kCycleNs, nullptr, nullptr).state.q_rad[0]));
  CHECK(std::isfinite(node.step(4 * kCycleNs, nullptr, nullptr).state.q_rad[0]));
  node.obey({OrderKind::kPushObject, 0, 0.0, Eigen::Vector3d(0.132, 0.0, 0.0)});
  node.step(5 * kCycleNs, nullptr, nullptr);
  // 0.132 N s on a ball of 0.132 kg: 1 m/s where it slides, 5/7 of that where it rolls at once
  const double v = node.plant().state().objects[0].v_WB.x();
  CHECK(v < 1.0);
  CHECK(v > 5.0 / 7.0);
  CHECK(node.counters().faults == 2);
}

/// What the node has answered to an order, if it has.
std::optional<Outcome> obeyed(Node& node, const Order& order) {
  node.obey(order);
  Answered answered{};
  if (!node.answered().take(answered)) return std::nullopt;
  CHECK(answered.request_id == order.request_id);
  CHECK(answered.kind == order.kind);
  return answered.outcome;
}

Order order_of(OrderKind kind) {
  Order order{};
  order.kind = kind;
  order.request_id = 7;
  return order;
}

TEST_CASE("plant node: orders are answered with what has become of them, faults are not") {
  Node node(test_parameters(), kExposureRate, 1);
  CHECK(obeyed(node, order_of(OrderKind::kThresholds)) == Outcome::kObeyed);
  CHECK(obeyed(node, order_of(OrderKind::kGuide)) == Outcome::kObeyed);
  CHECK(node.step(2 * kCycleNs, nullptr, nullptr).contact.guided);
  CHECK(obeyed(node, order_of(OrderKind::kRelease)) == Outcome::kObeyed);
  CHECK_FALSE(node.step(3 * kCycleNs, nullptr, nullptr).contact.guided);
  CHECK(obeyed(node, order_of(OrderKind::kPressStop)) == Outcome::kObeyed);
  CHECK(node.step(4 * kCycleNs, nullptr, nullptr).state.mode == c3rt_v2_ROBOT_USER_STOPPED);
  CHECK(obeyed(node, order_of(OrderKind::kGuide)) == Outcome::kStopPressed);
  CHECK(obeyed(node, order_of(OrderKind::kReleaseStop)) == Outcome::kObeyed);
  node.obey({OrderKind::kRecover, 0, 0.0, Eigen::Vector3d::Zero()});
  node.step(5 * kCycleNs, nullptr, nullptr);
  CHECK_FALSE(obeyed(node, order_of(OrderKind::kDropCommands)));

  wire::RobotCommand command{};
  command.header.seq = 1;
  CHECK(node.step(6 * kCycleNs, &command, nullptr).state.mode == c3rt_v2_ROBOT_MOVE);
  CHECK(obeyed(node, order_of(OrderKind::kThresholds)) == Outcome::kMoves);
  CHECK(obeyed(node, order_of(OrderKind::kGuide)) == Outcome::kMoves);
}

TEST_CASE("plant node: a motion of the wire moves the joint as it says, and ends idle") {
  Node node(test_parameters(), kExposureRate, 1);
  const double start = node.start(kCycleNs).state.q_rad[6];
  wire::RobotMotion motion{};
  motion.kind = c3rt_v2_MOTION_JOINT_VELOCITY;
  constexpr int kCycles = 1000;
  for (int k = 1; k <= kCycles; ++k) {
    // 0.2 (1 - cos 2 pi t) rad/s for a second: 0.2 rad
    motion.header.seq = static_cast<std::uint64_t>(k);
    motion.origin.state_ns = k * kCycleNs;
    motion.dq_rad_per_s[6] = 0.2 * (1.0 - std::cos(2 * M_PI * k / kCycles));
    motion.finished = k == kCycles;
    const Node::Output& out = node.step((k + 1) * kCycleNs, nullptr, &motion);
    REQUIRE(out.state.errors == 0);
    if (motion.finished) continue;
    CHECK(out.state.mode == c3rt_v2_ROBOT_MOVE);
    CHECK(out.state.command_seq == motion.header.seq);
    CHECK(out.state.command_state_ns == motion.origin.state_ns);
  }
  CHECK(node.state().mode == Mode::kIdle);
  CHECK(node.state().q[6] - start == Approx(0.2).margin(1e-3));
  CHECK(node.counters().refused_motions == 0);
}

TEST_CASE("plant node: a pose with an elbow reaches the plant as it was sent") {
  Node node(test_parameters(), kExposureRate, 1);
  const wire::RobotState start = node.start(kCycleNs).state;
  wire::RobotMotion motion{};
  motion.kind = c3rt_v2_MOTION_CARTESIAN_POSE;
  std::copy(std::begin(start.p_WE_m), std::end(start.p_WE_m), motion.p_WE_m);
  std::copy(std::begin(start.q_WE), std::end(start.q_WE), motion.q_WE);
  motion.has_elbow = true;
  motion.elbow_q3_rad = start.q_rad[2];
  motion.elbow_sign = -1.0;
  motion.header.seq = 1;
  CHECK(node.step(2 * kCycleNs, nullptr, &motion).state.mode == c3rt_v2_ROBOT_MOVE);
  motion.elbow_sign = 1.0;
  motion.header.seq = 2;
  CHECK(node.step(3 * kCycleNs, nullptr, &motion).state.errors ==
        bit(Error::kCartesianMotionGeneratorElbowSignInconsistent));
}

TEST_CASE("plant node: while torques move the robot motions are counted and not followed") {
  Node node(test_parameters(), kExposureRate, 1);
  wire::RobotCommand command{};
  wire::RobotMotion motion{};
  for (int k = 1; k <= 10; ++k) {
    command.header.seq = motion.header.seq = static_cast<std::uint64_t>(k);
    CHECK(node.step((k + 1) * kCycleNs, &command, &motion).state.errors == 0);
  }
  CHECK(node.counters().refused_motions == 10);
  CHECK_FALSE(node.plant().moved_by_motion());
}

TEST_CASE("plant node: orders and motions do not allocate") {
  Node node(test_parameters(), kExposureRate, 1);
  Order thresholds = order_of(OrderKind::kThresholds), guide = order_of(OrderKind::kGuide);
  guide.axes = {3U, false};
  wire::RobotMotion motion{};
  motion.kind = c3rt_v2_MOTION_CARTESIAN_VELOCITY;
  std::int64_t heap_calls = 0;
  {
    const support::AllocationCounter heap;
    for (int k = 1; k <= 200; ++k) {
      motion.header.seq = static_cast<std::uint64_t>(k);
      if (k == 50) node.obey(thresholds);
      if (k == 60) node.obey(guide);
      if (k == 90) node.obey(order_of(OrderKind::kRelease));
      node.step((k + 1) * kCycleNs, nullptr, k < 100 ? nullptr : &motion);
    }
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
  CHECK(node.state().mode == Mode::kMove);
}

TEST_CASE("plant node: a reflex is counted once, and moving cycles in a row") {
  Node node(test_parameters(), kExposureRate, 1);
  wire::RobotCommand command{};
  std::int64_t now_ns = kCycleNs;
  for (int i = 0; i < 5; ++i) {
    ++command.header.seq;
    node.step(now_ns += kCycleNs, &command, nullptr);
  }
  CHECK(node.counters().moving_cycles == 5);
  for (int i = 0; i < 2 * kLostCommandsMax; ++i) node.step(now_ns += kCycleNs, nullptr, nullptr);
  CHECK(node.plant().state().mode == Mode::kReflex);
  CHECK(node.counters().reflexes == 1);
  CHECK(node.counters().moving_cycles == 0);
}

}  // namespace
