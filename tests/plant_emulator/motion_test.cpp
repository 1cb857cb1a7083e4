#include "plant_emulator/motion.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <catch2/catch.hpp>

#include "plant_emulator/plant.hpp"
#include "tests/plant_emulator/parameters.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

/// A way that grows with constant jerk until it has its acceleration, cycle by cycle.
struct Ramp {
  double jerk, acceleration_max;
  double acceleration = 0.0, v = 0.0, s = 0.0;
  void step() {
    acceleration = std::min(acceleration + kCycle * jerk, acceleration_max);
    v += kCycle * acceleration;
    s += kCycle * v;
  }
};

Vector6d about(int axis) { return Vector6d::Unit(axis); }

/// From where the arm is by `way` along or about one axis: of a joint, or of the end effector.
MotionCommand moved(MotionKind kind, const State& start, int axis, double way, double speed) {
  MotionCommand command;
  command.kind = kind;
  if (kind == MotionKind::kJointPosition) command.joints = start.q + way * Vector7d::Unit(axis);
  if (kind == MotionKind::kJointVelocity) command.joints = speed * Vector7d::Unit(axis);
  if (kind == MotionKind::kJointPosition || kind == MotionKind::kJointVelocity) return command;
  command.V_WE = speed * about(axis);
  command.p_WE = start.p_WE + way * about(axis).head<3>();
  Eigen::Quaterniond q = start.q_WE;
  if (axis >= 3) q = Eigen::AngleAxisd(way, about(axis).tail<3>()) * q;
  command.q_WE << q.w(), q.x(), q.y(), q.z();
  return command;
}

/// 10 s^3 - 15 s^4 + 6 s^5: from 0 to 1 at rest, without jumps of acceleration.
double smooth(double s) { return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s); }

struct Row {
  Error error;
  int axis;  // of the motion: a joint from 0, or x to yaw
  double jerk, acceleration;
  double value, limit;  // found
  int joint;            // that is named; 0: none
  void (*change)(Parameters&);
};

void free_joints(Parameters& parameters) {
  parameters.safety.motion.joint_acceleration.setConstant(kNoLimit);
  parameters.safety.motion.joint_jerk.setConstant(kNoLimit);
  parameters.limits.dq_max.setConstant(kNoLimit);
}

void free_effector(Parameters& parameters) {
  const MotionLimits& limits = parameters.safety.motion;
  parameters.safety.motion = {limits.joint_acceleration, limits.joint_jerk};
  parameters.safety.velocity_max = parameters.safety.angular_velocity_max = kNoLimit;
}

void as_published(Parameters&) {}

const Row kJointRows[] = {
    {Error::kJointMotionGeneratorAccelerationDiscontinuity, 1, 4000, 9, 4000, 3750, 2,
     as_published},
    {Error::kJointMotionGeneratorVelocityDiscontinuity, 1, 3000, 9, 9, 7.5, 2, as_published},
    {Error::kJointMotionGeneratorVelocityLimitsViolation, 0, 1000, 11, 2.178, 2.175, 1,
     as_published},
    {Error::kJointMotionGeneratorPositionLimitsViolation, 0, 1000, 1, 2.8973, 2.8973, 1,
     [](Parameters& p) { p.initial_q[0] = 2.8; }},
};

// what one joint would have to do is asked of a turn about the vertical, which joint 7 makes alone
// while the elbow stays
const Row kCartesianRows[] = {
    {Error::kCartesianMotionGeneratorAccelerationDiscontinuity, 1, 7000, 14, 7000, 6500, 0,
     free_joints},
    {Error::kCartesianMotionGeneratorVelocityDiscontinuity, 1, 5000, 15, 15, 13, 0, free_joints},
    {Error::kCartesianMotionGeneratorVelocityLimitsViolation, 1, 1000, 10, 1.705, 1.7, 0,
     free_joints},
    {Error::kCartesianMotionGeneratorAccelerationDiscontinuity, 5, 13000, 26, 13000, 12500, 0,
     free_joints},
    {Error::kCartesianMotionGeneratorVelocityDiscontinuity, 5, 10000, 30, 30, 25, 0, free_joints},
    {Error::kCartesianMotionGeneratorVelocityLimitsViolation, 5, 2000, 20, 2.51, 2.5, 0,
     free_joints},
    {Error::kCartesianMotionGeneratorJointAccelerationDiscontinuity, 5, 11000, 22, -11000, 10000, 7,
     free_effector},
    {Error::kCartesianMotionGeneratorJointVelocityDiscontinuity, 5, 9000, 27, -27, 20, 7,
     free_effector},
    {Error::kCartesianMotionGeneratorJointVelocityLimitsViolation, 5, 1000, 19, -2.61, 2.61, 7,
     free_effector},
    {Error::kCartesianMotionGeneratorJointPositionLimitsViolation, 5, 1000, 1, -2.8973, -2.8973, 7,
     [](Parameters& p) { p.initial_q[6] = -2.85; }},
};

/// Follows a row until the robot stops.
void check(const Row& row, MotionKind kind, bool elbow) {
  Parameters parameters = test_parameters();
  row.change(parameters);
  Plant plant(parameters);
  const State start = plant.state();
  Ramp ramp{row.jerk, row.acceleration};
  for (std::uint64_t k = 1; k <= 1000 && plant.state().errors == 0; ++k) {
    MotionCommand command = moved(kind, start, row.axis, ramp.s, ramp.v);
    if (elbow) command.elbow = Elbow{start.q[2], -1.0};
    REQUIRE(plant.set_motion(command, k));
    plant.step_1ms();
    ramp.step();
  }
  const Cause& cause = plant.state().cause;
  CAPTURE(name(row.error), names(plant.state().errors), text(cause), static_cast<int>(kind));
  CHECK(plant.state().mode == Mode::kReflex);
  CHECK(plant.state().errors == bit(row.error));
  CHECK(cause.error == row.error);
  CHECK(cause.axis == row.joint);
  CHECK(cause.value == Approx(row.value).epsilon(0.01));
  CHECK(std::abs(cause.value) > std::abs(cause.limit));
  CHECK(cause.limit == Approx(row.limit).epsilon(1e-5));
}

TEST_CASE("motion: the limits are those that Franka publishes for the Panda") {
  const MotionLimits limits = test_parameters().safety.motion;
  CHECK(limits.joint_acceleration == (Vector7d() << 15, 7.5, 10, 12.5, 15, 20, 20).finished());
  CHECK(limits.joint_jerk == (Vector7d() << 7500, 3750, 5000, 6250, 7500, 10000, 10000).finished());
  CHECK(limits.acceleration == 13.0);
  CHECK(limits.angular_acceleration == 25.0);
  CHECK(limits.jerk == 6500.0);
  CHECK(limits.angular_jerk == 12500.0);
}

TEST_CASE("motion: each limit of commanded joints that is passed has its name") {
  for (const Row& row : kJointRows) {
    check(row, MotionKind::kJointPosition, false);
    check(row, MotionKind::kJointVelocity, false);
  }
}

TEST_CASE("motion: each limit of commanded poses and of the joints that they take has its name") {
  for (const Row& row : kCartesianRows) {
    check(row, MotionKind::kCartesianPose, true);
    check(row, MotionKind::kCartesianVelocity, true);
  }
}

TEST_CASE("motion: one that begins away from the arm, or is none, has its name") {
  struct Wrong {
    Error error;
    MotionKind kind;
    void (*change)(MotionCommand&);
    const char* said;
  };
  const Wrong rows[] = {
      {Error::kJointPositionMotionGeneratorStartPoseInvalid, MotionKind::kJointPosition,
       [](MotionCommand& c) { c.joints[2] -= 0.02; }, "joint 3: -0.02 rad, limit 0.01"},
      {Error::kCartesianPositionMotionGeneratorStartPoseInvalid, MotionKind::kCartesianPose,
       [](MotionCommand& c) { c.p_WE.z() += 0.003; }, "0.003 m, limit 0.002"},
      {Error::kCartesianPositionMotionGeneratorStartPoseInvalid, MotionKind::kCartesianPose,
       [](MotionCommand& c) {
         const Eigen::Quaterniond q =
             Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()) *
             Eigen::Quaterniond(c.q_WE[0], c.q_WE[1], c.q_WE[2], c.q_WE[3]);
         c.q_WE << q.w(), q.x(), q.y(), q.z();
       },
       "0.02 rad, limit 0.01"},
      {Error::kCartesianPositionMotionGeneratorInvalidFrame, MotionKind::kCartesianPose,
       [](MotionCommand& c) { c.q_WE *= 1.01; }, "1.01 of a rotation, limit 1"},
      {Error::kCartesianMotionGeneratorStartElbowInvalid, MotionKind::kCartesianPose,
       [](MotionCommand& c) {
         c.elbow = Elbow{2.87, -1.0};
       },
       "joint 3: -0.025 rad, limit 0.01"},
      {Error::kCartesianMotionGeneratorElbowSignInconsistent, MotionKind::kCartesianVelocity,
       [](MotionCommand& c) {
         c.elbow = Elbow{2.895, 1.0};
       },
       "joint 4: 1 its sign, limit -1"},
      {Error::kCartesianMotionGeneratorElbowLimitViolation, MotionKind::kCartesianVelocity,
       [](MotionCommand& c) {
         c.elbow = Elbow{2.9, -1.0};
       },
       "joint 3: 2.9 rad, limit 2.897"},
      {Error::kCommandNotFinite, MotionKind::kCartesianVelocity,
       [](MotionCommand& c) { c.V_WE[4] = std::nan(""); }, "nan of a motion, limit 0"},
  };
  Parameters parameters = test_parameters();
  parameters.initial_q[2] = 2.895;
  for (const Wrong& row : rows) {
    Plant plant(parameters);
    MotionCommand command = moved(row.kind, plant.state(), 0, 0.0, 0.0);
    row.change(command);
    REQUIRE(plant.set_motion(command, 1));
    plant.step_1ms();
    CAPTURE(name(row.error), names(plant.state().errors));
    CHECK(plant.state().mode == Mode::kReflex);
    CHECK(plant.state().errors == bit(row.error));
    CHECK(text(plant.state().cause) == row.said);
  }
}

TEST_CASE(
    "motion: the arm follows joints and poses within the limits, and is idle after the last") {
  constexpr std::uint64_t kCycles = 1000;
  struct Way {
    MotionKind kind;
    int axis;
    double length;
  };
  for (const Way& way :
       {Way{MotionKind::kJointPosition, 3, -0.3}, Way{MotionKind::kCartesianPose, 1, 0.1},
        Way{MotionKind::kCartesianPose, 5, 0.4}}) {
    Plant plant(test_parameters());
    const State start = plant.state();
    double worst = 0.0, turned = 0.0;
    for (std::uint64_t k = 0; k <= kCycles; ++k) {
      const double s = smooth(static_cast<double>(k) / kCycles);
      MotionCommand command = moved(way.kind, start, way.axis, way.length * s, 0.0);
      command.last = k == kCycles;
      REQUIRE(plant.set_motion(command, k + 1));
      plant.step_1ms();
      if (way.kind == MotionKind::kJointPosition) {
        worst = std::max(worst, (plant.state().q - command.joints).cwiseAbs().maxCoeff());
      } else {
        worst = std::max(worst, (plant.state().p_WE - command.p_WE).norm());
        const Eigen::Quaterniond asked(command.q_WE[0], command.q_WE[1], command.q_WE[2],
                                       command.q_WE[3]);
        turned = std::max(turned, plant.state().q_WE.angularDistance(asked));
      }
    }
    CAPTURE(worst, turned, text(plant.state().cause));
    CHECK(plant.state().errors == 0);
    CHECK(plant.state().mode == Mode::kIdle);
    CHECK_FALSE(plant.moved_by_motion());
    CHECK(worst < 1e-4);  // [rad], [m]
    CHECK(turned < 1e-4);
    for (int i = 0; i < 200; ++i) plant.step_1ms();
    CHECK(plant.state().dq.cwiseAbs().maxCoeff() < 0.01);
  }
}

TEST_CASE(
    "motion: a lost command is extrapolated with constant acceleration, the twentieth stops") {
  Plant plant(test_parameters());
  const State start = plant.state();
  Ramp ramp{1000.0, 2.0};
  std::uint64_t seq = 0;
  for (int k = 0; k < 100; ++k) {
    // the acceleration is constant since cycle 2: what is extrapolated is what would have come
    const bool lost = k > 50 && k < 60;
    if (!lost)
      REQUIRE(plant.set_motion(moved(MotionKind::kJointPosition, start, 0, ramp.s, 0.0), ++seq));
    plant.step_1ms();
    CHECK(plant.motion().q()[0] == Approx(start.q[0] + ramp.s).margin(1e-12));
    ramp.step();
  }
  REQUIRE(plant.state().mode == Mode::kMove);
  CHECK(plant.state().lost_commands == 9);
  for (int k = 0; k < kLostCommandsMax; ++k) plant.step_1ms();
  CHECK(plant.state().errors == bit(Error::kCommunicationConstraintsViolation));
}

TEST_CASE("motion: torques do not move the arm while a motion does, nor the other way") {
  const Vector7d twist = (Vector7d() << 0, 0, 0, 2, 0, 0, 0).finished();
  Plant plant(test_parameters());
  const State start = plant.state();
  const MotionCommand rest = moved(MotionKind::kJointPosition, start, 0, 0.0, 0.0);
  std::uint64_t seq = 0;
  for (int k = 0; k < 100; ++k) {
    plant.set_command(twist, ++seq, 0);
    if (k == 0) {
      CHECK_FALSE(plant.set_motion(rest, seq));  // torques were first
      Plant other(test_parameters());
      REQUIRE(other.set_motion(rest, 1));
      for (std::uint64_t i = 1; i <= 100; ++i) {
        other.set_command(twist, i, 0);
        REQUIRE(other.set_motion(rest, i + 1));
        other.step_1ms();
      }
      CHECK(other.state().mode == Mode::kMove);
      CHECK(other.state().dq.norm() < 1e-3);
      // another kind is another motion
      CHECK_FALSE(other.set_motion(moved(MotionKind::kJointVelocity, start, 0, 0, 0), 200));
    }
    plant.step_1ms();
  }
  CHECK(plant.state().mode == Mode::kMove);
  CHECK(plant.state().dq.norm() > 0.05);
  CHECK_FALSE(plant.set_motion(rest, 1000));
  plant.request_stop();
  plant.step_1ms();
  CHECK_FALSE(plant.set_motion(rest, 1001));
}

TEST_CASE("motion: a cycle allocates nothing") {
  Plant plant(test_parameters());
  const State start = plant.state();
  std::int64_t allocations = 0;
  bool taken = true;
  for (std::uint64_t k = 1; k <= 20; ++k) {
    MotionCommand command = moved(MotionKind::kCartesianPose, start, 0, 0.0, 0.0);
    if (k % 3 != 0) command.elbow = Elbow{start.q[2], -1.0};
    const support::AllocationCounter heap;
    taken = plant.set_motion(command, k) && taken;
    plant.step_1ms();
    allocations += heap.count();
  }
  CHECK(taken);
  CHECK(plant.state().errors == 0);
  CHECK(allocations == 0);
}

TEST_CASE("errors: every name is there once, and as long as a name is") {
  std::set<std::string> unique;
  for (const char* each : kErrorNames) {
    REQUIRE(each != nullptr);
    unique.insert(each);
  }
  CHECK(unique.size() == kErrorCount);
  CHECK(std::string(name(Error::kCartesianMotionGeneratorJointAccelerationDiscontinuity)) ==
        "cartesian_motion_generator_joint_acceleration_discontinuity");
  CHECK(std::string(name(Error::kCartesianPositionMotionGeneratorStartPoseInvalid)) ==
        "cartesian_position_motion_generator_start_pose_invalid");
}

}  // namespace
