// The door to a real robot in simulated time, with the emulated arm behind it.
#include "examples/real_robot/door.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include <catch2/catch.hpp>

#include "tests/plant_emulator/parameters.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;

namespace {

using plant::Mode;
using real_robot::Door;
using real_robot::Vector7d;

// so that a constant torque turns joint 1 at a constant rate and no other one for long
const Vector7d kDamping = (Vector7d() << 10, 10, 10, 10, 2, 2, 0.5).finished();  // [N m s/rad]

/// panda_plant's loop with an arm that has no controller of its own but holds still.
class Robot {
 public:
  explicit Robot(const plant::Parameters& parameters) : door_(parameters), arm_(parameters) {}

  /// So many cycles, each with a torque that is damped, or with none.
  void run(int cycles, const std::optional<Vector7d>& tau) {
    for (int i = 0; i < cycles; ++i) {
      torque_before_ = door_.torque()[0];
      if (controlled_) arm_.set_command(door_.torque(), ++torques_, 0);
      arm_.step_1ms();
      wire::RobotCommand command{};
      if (tau) {
        command.header.seq = ++seq_;
        command.origin.state_ns = now_ns_;
        const Vector7d damped = *tau - kDamping.cwiseProduct(arm_.state().dq);
        for (int j = 0; j < plant::kJoints; ++j) command.tau_nm[j] = damped[j];
      }
      now_ns_ += plant::kCycleNs;
      plant::State state = arm_.state();
      if (fails_) state.mode = Mode::kReflex;
      if (fails_) state.errors = plant::bit(plant::Error::kCartesianReflex);
      if (pressed_) state.mode = Mode::kUserStopped;
      door_.see(state, controlled_);
      out_ = door_.step(now_ns_, tau ? &command : nullptr, nullptr);
      const bool before = controlled_;
      controlled_ = door_.wants_control();
      if (before && !controlled_) {
        arm_.request_stop();
        arm_.step_1ms();
        arm_.request_recovery();
      }
    }
  }
  void ask(plant::OrderKind kind) { door_.obey({kind, 0, 0.1, Eigen::Vector3d::Zero()}); }
  void fail(bool fails) { fails_ = fails; }
  void press(bool pressed) { pressed_ = pressed; }

  Door& door() { return door_; }
  const wire::RobotState& state() const { return out_.state; }
  bool controlled() const { return controlled_; }
  double torque_before() const { return torque_before_; }  // of joint 1, in the last cycle
  double speed() const { return arm_.state().dq.cwiseAbs().maxCoeff(); }

 private:
  Door door_;
  plant::Plant arm_;
  Door::Output out_;
  double torque_before_ = 0.0;
  bool controlled_ = false, fails_ = false, pressed_ = false;
  std::uint64_t seq_ = 0, torques_ = 0;
  std::int64_t now_ns_ = 0;
};

Vector7d turning() { return (Vector7d() << 4, 0, 0, 0, 0, 0, 0).finished(); }

constexpr std::uint64_t kLost = plant::bit(plant::Error::kCommunicationConstraintsViolation);

TEST_CASE("door: a command moves the robot, and what is told is the robot's state") {
  Robot robot(plant::test_parameters());
  robot.run(10, {});
  CHECK(robot.state().mode == c3rt_v2_ROBOT_IDLE);
  CHECK_FALSE(robot.controlled());
  robot.run(200, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_MOVE);
  CHECK(robot.state().command_seq == 200);
  CHECK(robot.state().command_state_ns == 209 * plant::kCycleNs);
  CHECK(robot.state().command_success_rate == 1.0);
  CHECK(robot.state().tau_nm[0] == robot.torque_before());
  CHECK(robot.state().dq_rad_per_s[0] > 0.1);
}

TEST_CASE("door: the twentieth lost command stops the robot, and no earlier one") {
  Robot robot(plant::test_parameters());
  robot.run(300, turning());
  REQUIRE(robot.speed() > 0.1);
  robot.run(19, {});
  CHECK(robot.state().mode == c3rt_v2_ROBOT_MOVE);
  robot.run(1, {});
  CHECK(robot.state().mode == c3rt_v2_ROBOT_REFLEX);
  CHECK(robot.state().errors == kLost);
  CHECK(robot.controlled());  // it is braked
  robot.run(1500, {});
  CHECK(robot.speed() < 0.02);
  CHECK_FALSE(robot.controlled());  // and then held by its own controller
}

TEST_CASE("door: commands that come again move it again only where the scenario says so") {
  for (const bool alone : {false, true}) {
    plant::Parameters parameters = plant::test_parameters();
    parameters.recovers_alone = alone;
    Robot robot(parameters);
    robot.run(300, turning());
    robot.run(1000, {});
    REQUIRE(robot.state().mode == c3rt_v2_ROBOT_REFLEX);
    robot.run(plant::kCommandsToRecover + 1, Vector7d::Zero());
    CHECK(robot.state().mode == (alone ? c3rt_v2_ROBOT_MOVE : c3rt_v2_ROBOT_REFLEX));
    if (alone) continue;
    robot.ask(plant::OrderKind::kRecover);
    robot.run(3, Vector7d::Zero());
    CHECK(robot.state().mode == c3rt_v2_ROBOT_MOVE);
  }
}

TEST_CASE("door: a person's stop brakes the arm whatever is commanded, until recovery") {
  Robot robot(plant::test_parameters());
  robot.run(300, turning());
  robot.ask(plant::OrderKind::kStop);
  robot.run(1500, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_USER_STOPPED);
  CHECK(robot.speed() < 0.02);
  CHECK_FALSE(robot.controlled());
  robot.ask(plant::OrderKind::kRecover);
  robot.run(300, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_MOVE);
  CHECK(robot.speed() > 0.1);
}

TEST_CASE("door: torques and their rate are within the robot's limits") {
  Robot robot(plant::test_parameters());
  robot.run(5, Vector7d::Zero());
  double before = 0.0;
  for (int i = 0; i < 60; ++i) {
    robot.run(1, Vector7d::Constant(1000.0));
    if (robot.state().mode != c3rt_v2_ROBOT_MOVE) break;  // a limit of velocity
    const double tau = robot.door().torque()[6];
    CHECK(tau <= 12.0);
    CHECK(tau - before <= 1.0 + 1e-12);
    before = tau;
  }
  CHECK(before > 3.0);  // it took several cycles
}

TEST_CASE("door: outside of the walls the arm is stopped with the cause") {
  plant::Parameters parameters = plant::test_parameters();
  parameters.walls = plant::VirtualWalls{{0.3, -0.01, -1.0}, {0.8, 0.01, 1.0}};
  Robot robot(parameters);
  robot.run(1500, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_REFLEX);
  CHECK(robot.state().errors == plant::bit(plant::Error::kCartesianPositionLimitsViolation));
  CHECK(robot.door().state().cause.axis == 2);
}

TEST_CASE("door: a robot that stops by itself is asked before it moves again") {
  Robot robot(plant::test_parameters());
  robot.run(300, turning());
  robot.fail(true);
  robot.run(5, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_REFLEX);
  CHECK(robot.state().errors == plant::bit(plant::Error::kCartesianReflex));
  CHECK_FALSE(robot.controlled());
  CHECK_FALSE(robot.door().wants_recovery());
  robot.ask(plant::OrderKind::kRecover);
  CHECK(robot.door().wants_recovery());
  robot.door().recovered(false);  // it would not
  robot.run(5, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_REFLEX);
  robot.ask(plant::OrderKind::kRecover);
  robot.fail(false);
  robot.door().recovered(true);
  robot.run(5, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_MOVE);
}

TEST_CASE("door: the robot's own stop button is a person's stop") {
  Robot robot(plant::test_parameters());
  robot.run(50, turning());
  robot.press(true);
  robot.run(5, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_USER_STOPPED);
  robot.ask(plant::OrderKind::kRecover);
  robot.run(5, turning());
  CHECK(robot.state().mode == c3rt_v2_ROBOT_USER_STOPPED);  // as long as it is pressed
}

TEST_CASE("door: of faults it has lost commands alone") {
  Robot robot(plant::test_parameters());
  CHECK(robot.door().refusal(plant::OrderKind::kDropCommands).empty());
  for (const auto kind :
       {plant::OrderKind::kStall, plant::OrderKind::kNan, plant::OrderKind::kPushObject})
    CHECK_THAT(robot.door().refusal(kind), Catch::Contains("drop-commands"));
  robot.run(300, turning());
  robot.ask(plant::OrderKind::kDropCommands);
  robot.run(30, turning());
  CHECK(robot.state().errors == kLost);
}

TEST_CASE("door: thresholds go to the robot between two loops, other orders are refused by name") {
  Robot robot(plant::test_parameters());
  plant::Order order{};
  order.kind = plant::OrderKind::kThresholds;
  order.request_id = 3;
  order.behavior.nominal.collision_torque.setConstant(20.0);
  plant::Answered answered{};
  robot.run(10, {});
  robot.door().obey(order);
  CHECK_FALSE(robot.door().answered().take(answered));  // the robot has not taken them yet
  REQUIRE(robot.door().wanted_behavior() != nullptr);
  CHECK(robot.door().wanted_behavior()->nominal.collision_torque[6] == 20.0);
  robot.door().settled(true);
  REQUIRE(robot.door().answered().take(answered));
  CHECK(answered.request_id == 3);
  CHECK(answered.outcome == plant::Outcome::kObeyed);
  CHECK(robot.door().wanted_behavior() == nullptr);
  robot.run(50, turning());
  robot.door().obey(order);
  REQUIRE(robot.door().answered().take(answered));
  CHECK(answered.outcome == plant::Outcome::kMoves);
  CHECK(robot.door().wanted_behavior() == nullptr);

  CHECK(robot.door().refusal(plant::OrderKind::kThresholds).empty());
  CHECK_THAT(robot.door().refusal(plant::OrderKind::kGuide), Catch::Contains("buttons"));
  CHECK_THAT(robot.door().refusal(plant::OrderKind::kPressStop), Catch::Contains("stop button"));
  CHECK_THAT(robot.door().refusal(plant::OrderKind::kPushArm), Catch::Contains("hand"));
  CHECK_THAT(robot.door().refusal_of_motions(), Catch::Contains("torques alone"));
}

TEST_CASE("door: a cycle does not allocate") {
  Door door(plant::test_parameters());
  const plant::Plant arm(plant::test_parameters());
  wire::RobotCommand command{};
  std::int64_t heap_calls = 0;
  {
    const support::AllocationCounter heap;
    for (int i = 1; i <= 200; ++i) {
      command.header.seq = static_cast<std::uint64_t>(i);
      door.see(arm.state(), i > 1);
      door.step(i * plant::kCycleNs, i < 100 ? &command : nullptr, nullptr);
    }
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
  CHECK(door.state().mode == Mode::kReflex);
}

}  // namespace
