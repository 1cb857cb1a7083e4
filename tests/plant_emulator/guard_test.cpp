#include "plant_emulator/guard.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "controller/base/random.hpp"
#include "plant_emulator/plant.hpp"
#include "tests/plant_emulator/parameters.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

/// A client that damps the arm and holds it by a spring where it was.
class Holder {
 public:
  explicit Holder(const Plant& plant) : home_(plant.state().q) {}
  void run(Plant& plant, int cycles) {
    const Vector7d scale = (Vector7d() << 1, 1, 1, 1, 0.1, 0.1, 0.03).finished();
    for (int i = 0; i < cycles; ++i) {
      const State& s = plant.state();
      const Vector7d tau = scale.cwiseProduct(400.0 * (home_ - s.q) - 40.0 * s.dq);
      plant.set_command(tau, ++seq_, 0);
      plant.step_1ms();
    }
  }

 private:
  Vector7d home_;
  std::uint64_t seq_ = 0;
};

Thresholds all(double contact, double collision) {
  return {Vector7d::Constant(contact), Vector7d::Constant(collision), Vector6d::Constant(contact),
          Vector6d::Constant(collision)};
}

TEST_CASE("the limits are those that Franka publishes for the Panda") {
  const Parameters panda = test_parameters();
  CHECK(panda.safety.velocity_max == 1.7);
  CHECK(panda.safety.angular_velocity_max == 2.5);
  CHECK(panda.limits.tau_rate_max == 1000.0);
  CHECK(panda.limits.dq_max.head<4>().isApproxToConstant(2.175));
  CHECK(panda.limits.dq_max.tail<3>().isApproxToConstant(2.61));
  CHECK(panda.limits.q_min[3] == -3.0718);
  CHECK(panda.limits.q_max[5] == 3.7525);
}

TEST_CASE("each limit that is passed has its name, with joint, value and limit") {
  Parameters panda = test_parameters();
  panda.walls = VirtualWalls{{0.2, -0.5, 0.0}, {0.8, 0.5, 0.6}};
  struct Row {
    const char* said;
    void (*change)(Measured&);
  };
  const Row rows[] = {
      {"joint_position_limits_violation joint 4: -3.1 rad, limit -3.072",
       [](Measured& m) { m.q[3] = -3.1; }},
      {"joint_velocity_violation joint 6: -2.62 rad/s, limit 2.61",
       [](Measured& m) { m.dq[5] = -2.62; }},
      {"tau_j_range_violation joint 2: 131 N m, limit 130",
       [](Measured& m) { m.tau_sensor[1] = 131; }},
      {"cartesian_velocity_violation 1.71 m/s, limit 1.7", [](Measured& m) { m.V_WE[1] = -1.71; }},
      {"cartesian_velocity_violation 2.51 rad/s, limit 2.5", [](Measured& m) { m.V_WE[5] = 2.51; }},
      {"power_limit_violation 360 W, limit 350",
       [](Measured& m) {
         m.tau.head<2>().setConstant(90);
         m.dq.head<2>().setConstant(2.0);
       }},
      {"self_collision_avoidance_violation -0.01 m, limit 0",
       [](Measured& m) { m.clearance = -0.01; }},
      {"cartesian_position_limits_violation z: -0.1 m, limit 0",
       [](Measured& m) { m.p_WE.z() = -0.1; }},
  };
  Measured home;
  home.q = panda.initial_q;
  home.p_WE = {0.5, 0.0, 0.3};
  Findings none;
  judge_limits(home, panda, none);
  CHECK(none.errors == 0);
  for (const Row& row : rows) {
    Measured measured = home;
    row.change(measured);
    Findings findings;
    judge_limits(measured, panda, findings);
    CHECK(name(findings.first.error) + (" " + text(findings.first)) == row.said);
    CHECK(findings.errors == bit(findings.first.error));
  }
}

TEST_CASE("the distance of two segments is that of their nearest points") {
  base::Random random(3);
  const auto point = [&random] {
    return Eigen::Vector3d(random.uniform(), random.uniform(), random.uniform());
  };
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d a = point(), b = point(), c = point(), d = point();
    double brute = kNoLimit;
    constexpr int kPieces = 100;
    for (int i = 0; i <= kPieces; ++i) {
      for (int j = 0; j <= kPieces; ++j) {
        const Eigen::Vector3d p = a + (b - a) * i / kPieces, q = c + (d - c) * j / kPieces;
        brute = std::min(brute, (p - q).norm());
      }
    }
    const double distance = segment_distance(a, b, c, d);
    CHECK(distance <= brute + 1e-12);
    CHECK(distance == Approx(brute).margin(0.01));
  }
  const Eigen::Vector3d o = Eigen::Vector3d::Zero(), x = Eigen::Vector3d::UnitX();
  CHECK(segment_distance(o, o, 2 * x, 2 * x) == Approx(2.0));
  CHECK(segment_distance(o, x, 3 * x, 4 * x) == Approx(2.0));
}

TEST_CASE("a force on the end effector is estimated in the axes of the world and of the tool") {
  Plant plant(test_parameters());
  Holder holder(plant);
  holder.run(plant, 500);
  CHECK(plant.state().external.tau.norm() < 0.01);  // free: nothing acts
  const Eigen::Vector3d force(4.0, -3.0, 8.0);
  plant.pull(force, 10.0);
  holder.run(plant, 1500);
  REQUIRE(plant.state().mode == Mode::kMove);
  const External& external = plant.state().external;
  CHECK((external.wrench_W.head<3>() - force).norm() < 0.02 * force.norm());
  CHECK(external.wrench_W.tail<3>().norm() < 0.05);
  const Eigen::Vector3d of_tool = plant.state().q_WE.conjugate() * force;
  CHECK((external.wrench_E.head<3>() - of_tool).norm() < 0.02 * force.norm());
  // while the arm rests its own torques carry the force
  CHECK((external.tau + plant.state().tau).norm() < 0.05);
}

TEST_CASE("the estimate follows a step of force with a first-order lag of 10 ms") {
  Plant plant(test_parameters());
  Holder holder(plant);
  holder.run(plant, 500);
  plant.pull({0.0, 0.0, 10.0}, 1.0);
  holder.run(plant, 10);
  CHECK(plant.state().external.wrench_W.z() == Approx(10.0 * (1.0 - std::exp(-1.0))).margin(0.5));
}

TEST_CASE("an arm that moves freely feels next to nothing, however fast") {
  Plant plant(test_parameters());
  double most = 0.0, fastest = 0.0;
  for (std::uint64_t i = 1; i <= 800; ++i) {
    const double t = 1e-3 * static_cast<double>(i);
    const Vector7d tau =
        (Vector7d() << 4, 2, 0, 2, 0, 0, 0).finished() * std::sin(2 * M_PI * t / 0.8);
    const Vector7d damping = (Vector7d() << 2, 2, 2, 2, 0.5, 0.5, 0.1).finished();
    plant.set_command(tau - damping.cwiseProduct(plant.state().dq), i, 0);
    plant.step_1ms();
    most = std::max(most, plant.state().external.tau.cwiseAbs().maxCoeff());
    fastest = std::max(fastest, plant.state().dq.cwiseAbs().maxCoeff());
  }
  CAPTURE(most, fastest);
  REQUIRE(plant.state().mode == Mode::kMove);
  CHECK(fastest > 0.5);
  CHECK(most < 0.5);
}

TEST_CASE("a force above the lower threshold is a contact, above the upper one a reflex") {
  Parameters parameters = test_parameters();
  parameters.safety.collision = {all(4.0, 20.0), all(4.0, 20.0)};
  Plant plant(parameters);
  Holder holder(plant);
  holder.run(plant, 200);
  CHECK(plant.state().contacts.cartesian == 0);
  plant.pull({0.0, 0.0, 10.0}, 0.3);
  holder.run(plant, 200);
  CHECK(plant.state().mode == Mode::kMove);
  CHECK(plant.state().contacts.cartesian == 4U);  // the tool hangs down: z alone
  CHECK(plant.state().contacts.cartesian_collision == 0);
  holder.run(plant, 500);
  CHECK(plant.state().contacts.cartesian == 0);
  plant.pull({0.0, 0.0, 30.0}, 0.3);
  holder.run(plant, 200);
  CHECK(plant.state().mode == Mode::kReflex);
  CHECK((plant.state().errors & bit(Error::kCartesianReflex)) != 0);
  CHECK(std::abs(plant.state().cause.value) > 20.0);
  CHECK(plant.state().cause.limit == 20.0);
  holder.run(plant, 1000);
  CHECK((plant.state().contacts.cartesian_collision & 4U) != 0);  // until somebody recovers it
  plant.request_recovery();
  holder.run(plant, 2);
  CHECK(plant.state().mode == Mode::kMove);
  CHECK(plant.state().contacts.cartesian_collision == 0);
}

TEST_CASE("the thresholds of torque name the joint") {
  Parameters parameters = test_parameters();
  parameters.safety.collision.nominal.collision_torque[0] = 5.0;
  parameters.safety.collision.acceleration = parameters.safety.collision.nominal;
  Plant plant(parameters);
  Holder holder(plant);
  holder.run(plant, 200);
  plant.pull({0.0, 15.0, 0.0}, 0.5);  // 0.55 m from joint 1: 8 N m
  holder.run(plant, 200);
  CHECK(plant.state().errors == bit(Error::kJointReflex));
  CHECK(plant.state().cause.axis == 1);
}

TEST_CASE("while the arm accelerates the thresholds of acceleration hold") {
  External external;
  external.tau[2] = 8.0;
  const CollisionBehavior behavior{all(5.0, 10.0), all(2.0, 6.0)};
  for (const bool accelerates : {false, true}) {
    external.accelerates = accelerates;
    Contacts contacts;
    Findings findings;
    judge_contacts(external, behavior, contacts, findings);
    CHECK(contacts.joint == 4U);
    CHECK((findings.errors == 0) == accelerates);
  }
}

TEST_CASE("collision thresholds change only while the arm does not move") {
  Plant plant(test_parameters());
  const CollisionBehavior soft{all(1.0, 2.0), all(1.0, 2.0)};
  Holder holder(plant);
  holder.run(plant, 10);
  CHECK_FALSE(plant.set_collision_behavior(soft));
  plant.pull({0.0, 0.0, 10.0}, 0.2);
  holder.run(plant, 100);
  CHECK(plant.state().mode == Mode::kMove);
  plant.request_stop();
  holder.run(plant, 500);
  CHECK(plant.set_collision_behavior(soft));
  plant.request_recovery();
  plant.pull({0.0, 0.0, 10.0}, 0.2);
  holder.run(plant, 100);
  CHECK(plant.state().mode == Mode::kReflex);
}

TEST_CASE("a commanded torque that jumps is an error where the scenario says so") {
  for (const bool stops : {false, true}) {
    Parameters parameters = test_parameters();
    parameters.torque_jump_stops = stops;
    Plant plant(parameters);
    Vector7d tau = Vector7d::Zero();
    plant.set_command(tau, 1, 0);
    plant.step_1ms();
    tau[6] = 1.0;  // 1000 N m/s: allowed
    plant.set_command(tau, 2, 0);
    plant.step_1ms();
    CHECK(plant.state().mode == Mode::kMove);
    tau[6] = -0.1;
    plant.set_command(tau, 3, 0);
    plant.step_1ms();
    CHECK((plant.state().mode == Mode::kReflex) == stops);
    if (!stops) continue;
    CHECK(plant.state().errors == bit(Error::kControllerTorqueDiscontinuity));
    CHECK(text(plant.state().cause) == "joint 7: -1100 N m/s, limit 1000");
  }
}

TEST_CASE("an arm folded onto its own shoulder stops as soon as it is to move") {
  Parameters parameters = test_parameters();
  parameters.initial_q << 0.0, -1.5, 0.0, -3.05, 0.0, 0.5, 0.0;
  Plant plant(parameters);
  plant.set_command(Vector7d::Zero(), 1, 0);
  plant.step_1ms();
  plant.step_1ms();
  CHECK(plant.state().errors == bit(Error::kSelfCollisionAvoidanceViolation));
}

TEST_CASE("a wall stops the end effector") {
  Parameters parameters = test_parameters();
  parameters.walls = VirtualWalls{{0.3, -0.3, -0.1}, {0.56, 0.3, 0.5}};
  Plant plant(parameters);
  for (std::uint64_t i = 1; i <= 400; ++i) {
    plant.set_command((Vector7d() << 0, 6, 0, 0, 0, 0, 0).finished(), i, 0);
    plant.step_1ms();
  }
  REQUIRE(plant.state().mode == Mode::kReflex);
  CHECK(plant.state().errors == bit(Error::kCartesianPositionLimitsViolation));
  CHECK(plant.state().cause.axis == 1);
}

TEST_CASE("a person leads the arm by the hand, and commands do not move it meanwhile") {
  Plant plant(test_parameters());
  REQUIRE(plant.request_guiding());
  plant.step_1ms();
  REQUIRE(plant.state().mode == Mode::kGuiding);
  const Eigen::Vector3d start = plant.state().p_WE;
  for (std::uint64_t i = 1; i <= 500; ++i) {
    plant.set_command((Vector7d() << 20, 0, 0, 0, 0, 0, 0).finished(), i, 0);
    plant.step_1ms();
  }
  CHECK((plant.state().p_WE - start).norm() < 1e-4);
  plant.pull({0.0, 10.0, 0.0}, 0.5);
  for (int i = 0; i < 500; ++i) plant.step_1ms();
  CHECK(plant.state().p_WE.y() > start.y() + 0.01);
  plant.release();
  plant.step_1ms();
  CHECK(plant.state().mode == Mode::kIdle);
  for (int i = 0; i < 1000; ++i) plant.step_1ms();
  CHECK(plant.state().dq.norm() < 1e-3);
}

TEST_CASE("a hand leads the arm along the axes that are free, and is held along the others") {
  constexpr double kForce = 15.0;  // [N]
  for (const int axis : {0, 1, 2}) {
    Plant plant(test_parameters());
    REQUIRE(plant.request_guiding({1U << axis, true}));
    plant.step_1ms();
    REQUIRE(plant.state().mode == Mode::kGuiding);
    const Eigen::Vector3d start = plant.state().p_WE;
    const Eigen::Quaterniond turned = plant.state().q_WE;
    plant.pull(Eigen::Vector3d::Constant(kForce), 1.0);
    for (int i = 0; i < 1000; ++i) plant.step_1ms();
    const Eigen::Vector3d way = plant.state().p_WE - start;
    CAPTURE(axis, way.transpose());
    for (int i = 0; i < 3; ++i) {
      // 15 N against 3000 N/m are 5 mm, and the hand pushes on along the free axis
      if (i != axis) CHECK(std::abs(way[i]) < 1.5 * kForce / 3000.0);
    }
    CHECK(way[axis] > 0.03);
    CHECK(turned.angularDistance(plant.state().q_WE) < 0.1);
  }
}

TEST_CASE("an axis that is locked holds a hand's force as a spring of 3000 N/m") {
  Plant plant(test_parameters());
  REQUIRE(plant.request_guiding({1U, false}));  // along x alone
  plant.step_1ms();
  const Eigen::Vector3d start = plant.state().p_WE;
  plant.pull({0.0, 12.0, 0.0}, 3.0);
  for (int i = 0; i < 2500; ++i) plant.step_1ms();
  CHECK(plant.state().p_WE.y() - start.y() == Approx(12.0 / 3000.0).epsilon(0.05));
  CHECK(plant.state().dq.norm() < 1e-2);
}

TEST_CASE("a locked elbow stays while the hand leads the end effector") {
  double moved[2] = {};
  for (const bool elbow : {false, true}) {
    Plant plant(test_parameters());
    REQUIRE(plant.request_guiding({63U, elbow}));
    plant.step_1ms();
    const double start = plant.state().q[2];
    plant.pull({0.0, 15.0, 0.0}, 1.0);
    for (int i = 0; i < 1000; ++i) plant.step_1ms();
    moved[elbow] = std::abs(plant.state().q[2] - start);
  }
  CAPTURE(moved[0], moved[1]);
  CHECK(moved[1] > 3.0 * moved[0]);
}

TEST_CASE("while the stop button is pressed nothing moves the arm, and nothing recovers it") {
  Plant plant(test_parameters());
  Holder holder(plant);
  holder.run(plant, 100);
  plant.press_stop(true);
  holder.run(plant, 500);
  CHECK(plant.state().mode == Mode::kUserStopped);
  CHECK_FALSE(plant.request_guiding());
  plant.request_recovery();
  holder.run(plant, 100);
  CHECK(plant.state().mode == Mode::kUserStopped);
  plant.press_stop(false);
  holder.run(plant, 100);
  CHECK(plant.state().mode == Mode::kUserStopped);  // until a person recovers it
  plant.request_recovery();
  holder.run(plant, 2);
  CHECK(plant.state().mode == Mode::kMove);
  CHECK_FALSE(plant.request_guiding());  // commands move it
}

TEST_CASE("a joint out of its range may be led back, and not farther out") {
  Parameters parameters = test_parameters();
  parameters.initial_q[0] = parameters.limits.q_max[0] - 1e-4;
  for (const double way : {-1.0, 1.0}) {
    Plant plant(parameters);
    for (std::uint64_t i = 1; i <= 500 && plant.state().errors == 0; ++i) {
      plant.set_command((Vector7d() << 1, 0, 0, 0, 0, 0, 0).finished(), i, 0);
      plant.step_1ms();
    }
    REQUIRE(plant.state().errors == bit(Error::kJointPositionLimitsViolation));
    for (int i = 0; i < 500; ++i) plant.step_1ms();
    REQUIRE(plant.request_guiding());
    plant.step_1ms();
    // joint 1 turns about z: the tangent at the end effector
    const Eigen::Vector3d p = plant.state().p_WE;
    plant.pull(5.0 * way * Eigen::Vector3d(-p.y(), p.x(), 0.0).normalized(), 2.0);
    for (int i = 0; i < 200; ++i) plant.step_1ms();
    CAPTURE(way, text(plant.state().cause));
    const bool back = plant.state().q[0] < parameters.limits.q_max[0];
    CHECK(back == (way < 0));
    CHECK((plant.state().mode == Mode::kGuiding) == back);
    CHECK(((plant.state().errors & bit(Error::kJointMoveInWrongDirection)) != 0) == !back);
  }
}

}  // namespace
