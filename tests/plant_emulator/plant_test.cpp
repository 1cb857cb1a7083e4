#include "plant_emulator/plant.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include <catch2/catch.hpp>

#include "controller/mjcf/object.hpp"
#include "tests/plant_emulator/parameters.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

void run(Plant& plant, int cycles) {
  for (int i = 0; i < cycles; ++i) plant.step_1ms();
}

/// The home pose held by a joint spring from outside, as a client of the interface would.
class Client {
 public:
  void step(Plant& plant) {
    const State& s = plant.state();
    const Vector7d tau = 100.0 * (home_ - s.q) - 20.0 * s.dq;
    ++seq_;
    plant.set_command(tau.cwiseProduct(scale_), seq_, static_cast<std::int64_t>(seq_) * 1000);
    plant.step_1ms();
  }
  std::uint64_t seq_ = 0;

 private:
  Vector7d home_ = test_parameters().initial_q;
  Vector7d scale_ = (Vector7d() << 1, 1, 1, 1, 0.1, 0.1, 0.01).finished();
};

TEST_CASE("the tool hangs above the table where the paper's start pose puts it") {
  const Plant plant(test_parameters());
  CHECK((plant.state().p_WE - Eigen::Vector3d(0.5499, 0, 0.1238)).norm() < 1e-4);
  const Eigen::Vector3d down = plant.state().q_WE * Eigen::Vector3d::UnitZ();
  CHECK((down + Eigen::Vector3d::UnitZ()).norm() < 1e-3);
}

TEST_CASE("a resting ball sinks less than 0.1 mm into the table") {
  Plant plant(test_parameters());
  run(plant, 2000);
  const scene::Body& ball = plant.state().objects[0];
  const double depth = 0.0315 - (ball.p_WB.z() + 0.0245);
  CAPTURE(depth);
  CHECK(depth > 0);
  CHECK(depth < 1e-4);
  CHECK(ball.v_WB.norm() < 1e-6);
  CHECK((ball.p_WB.head<2>() - Eigen::Vector2d(0.55, 0.1)).norm() < 1e-6);
}

TEST_CASE(
    "a ball pushed to 0.1 m/s keeps more than 90 % of its speed for 2 s and rolls without "
    "slipping") {
  Plant plant(test_parameters());
  run(plant, 200);
  // an impulse through the centre: friction turns part of it into spin, rolling starts at 5/7 of
  // the speed
  const double impulse = 0.132 * 0.1 * 7.0 / 5.0;
  plant.push(0, {0, -impulse, 0});
  run(plant, 200);
  const double start = -plant.state().objects[0].v_WB.y();
  CHECK(start == Approx(0.1).epsilon(0.02));
  run(plant, 2000);
  const scene::Body& ball = plant.state().objects[0];
  const double end = -ball.v_WB.y();
  CAPTURE(start, end);
  CHECK(end > 0.9 * start);
  CHECK(end < 1.001 * start);
  CHECK(ball.omega_WB.x() * 0.0315 == Approx(end).epsilon(0.01));
  CHECK(ball.p_WB.x() == Approx(0.55).margin(1e-4));
}

TEST_CASE("rolling friction stops a ball after the distance that its lever predicts") {
  Parameters parameters = test_parameters();
  parameters.world.rolling_friction = 1e-3;
  Plant plant(parameters);
  run(plant, 200);
  plant.push(0, {0, -0.132 * 0.1 * 1.4, 0});
  run(plant, 50);
  const double v = plant.state().objects[0].v_WB.norm();
  const double y = plant.state().objects[0].p_WB.y();
  run(plant, 3000);
  // energy 7/10 m v^2 against the torque lever m g along distance / r
  const double expected = 0.7 * v * v * 0.0315 / (1e-3 * 9.81);
  CHECK(plant.state().objects[0].v_WB.norm() < 1e-3);
  CHECK(y - plant.state().objects[0].p_WB.y() == Approx(expected).epsilon(0.1));
}

TEST_CASE("on a tilted table a ball accelerates as a rolling solid sphere does") {
  Parameters parameters = test_parameters();
  parameters.world.table_tilt = {0.0, 0.02};  // turned about y: downhill is +x
  parameters.world.objects[0].position = {0.55, 0.0};
  Plant plant(parameters);
  run(plant, 1000);
  CHECK(plant.state().objects[0].v_WB.x() ==
        Approx(5.0 / 7.0 * 9.81 * std::sin(0.02)).epsilon(0.01));
}

TEST_CASE("balls of any size start where the scenario puts them") {
  Parameters parameters = test_parameters();
  parameters.world.objects = {ball({0.5, 0.1}, 0.0315, 0.132, 0), ball({0.6, 0.1}, 0.02, 0.05, 1),
                              ball({0.5, -0.1}, 0.0315, 0.132, 2), ball({0.6, -0.1}, 0.04, 0.2, 3)};
  Plant plant(parameters);
  run(plant, 500);
  REQUIRE(plant.state().object_count == 4);
  for (int i = 0; i < 4; ++i) {
    const ObjectParameters& wanted = parameters.world.objects[static_cast<std::size_t>(i)];
    const Eigen::Vector3d p = plant.state().objects[static_cast<std::size_t>(i)].p_WB;
    CHECK((p.head<2>() - wanted.position).norm() < 1e-5);
    CHECK(p.z() == Approx(wanted.object.shape().radius - 0.0245).margin(1e-4));
  }
}

/// Presses the tool on a table just below it with 5 N and drags it with 3 N; gives the distance
/// that it slid. [m]
double drag(double friction) {
  Parameters parameters = test_parameters();
  const double bottom =
      Plant(parameters).state().p_WE.z() - test_world().end_effector.sphere_radius;
  parameters.world.table_height = bottom - 2e-4;
  parameters.world.friction.end_effector_table = friction;
  Plant plant(parameters);
  const int site = mj_name2id(&plant.model(), mjOBJ_SITE, "end_effector");
  const Vector7d damping = (Vector7d() << 5, 3, 5, 3, 1, 1, 0.3).finished();
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, plant.model().nv);
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  for (std::uint64_t i = 1; i <= 2000; ++i) {
    mj_jacSite(&plant.model(), &plant.data(), J.data(), nullptr, site);
    const Eigen::Vector3d force(i > 1000 ? 3.0 : 0.0, 0, -5.0);
    const Vector7d tau = J.leftCols<kJoints>().transpose() * force;
    plant.set_command(tau - damping.cwiseProduct(plant.state().dq), i, 0);
    plant.step_1ms();
    if (i == 1000) start = plant.state().p_WE;
  }
  CHECK(plant.state().errors == 0);
  CHECK(plant.state().p_WE.z() - test_world().end_effector.sphere_radius ==
        Approx(parameters.world.table_height).margin(1e-4));
  return plant.state().p_WE.x() - start.x();
}

TEST_CASE("a tool pressed on the table sticks inside its friction cone and slides outside") {
  CHECK(std::abs(drag(1.0)) < 5e-4);  // 3 N < 1.0 x 5 N
  CHECK(drag(0.4) > 0.01);            // 3 N > 0.4 x 5 N
}

TEST_CASE("before the first command the arm holds its position") {
  Plant plant(test_parameters());
  run(plant, 2000);
  CHECK(plant.state().mode == Mode::kIdle);
  CHECK((plant.state().q - test_parameters().initial_q).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("gravity is carried inside: zero commanded torque leaves the arm where it is") {
  Plant plant(test_parameters());
  for (std::uint64_t i = 1; i <= 1000; ++i) {
    plant.set_command(Vector7d::Zero(), i, 0);
    plant.step_1ms();
  }
  CHECK(plant.state().mode == Mode::kMove);
  CHECK((plant.state().q - test_parameters().initial_q).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("torque is cut to its limits and to 1000 N m/s") {
  Plant plant(test_parameters());
  const Vector7d wanted = (Vector7d() << 0, 0, 0, 0, 0, 0, 100).finished();
  Vector7d previous = Vector7d::Zero();
  double largest = 0;
  for (std::uint64_t i = 1; i <= 12 && plant.state().errors == 0; ++i) {
    plant.set_command(wanted, i, 0);
    plant.step_1ms();
    if (plant.state().mode != Mode::kMove) break;
    CHECK((plant.state().tau - previous).cwiseAbs().maxCoeff() <= 1.0 + 1e-9);
    previous = plant.state().tau;
    largest = std::max(largest, previous[6]);
  }
  CHECK(largest > 1.5);
  CHECK(plant.state().saturated_cycles > 0);

  // against the ball-free joints 1..4 a long ramp ends at 87 N m
  Plant strong(test_parameters());
  Vector7d up = Vector7d::Zero();
  up[0] = 1e4;
  for (std::uint64_t i = 1; i <= 100; ++i) {
    up[0] =
        -up[0];  // alternating: the rate limit keeps it near zero, so the arm stays in its limits
    strong.set_command(up, i, 0);
    strong.step_1ms();
    CHECK(std::abs(strong.state().tau[0]) <= 1.0 + 1e-9);
  }
  CHECK(strong.state().mode == Mode::kMove);
}

TEST_CASE("twenty lost commands in a row stop the robot, nineteen do not") {
  Plant plant(test_parameters());
  Client client;
  for (int i = 0; i < 200; ++i) client.step(plant);
  CHECK(plant.state().command_success_rate == 1.0);
  run(plant, kLostCommandsMax - 1);
  CHECK(plant.state().mode == Mode::kMove);
  CHECK(plant.state().command_success_rate == Approx(0.81));
  client.step(plant);
  CHECK(plant.state().mode == Mode::kMove);
  run(plant, kLostCommandsMax);
  CHECK(plant.state().mode == Mode::kReflex);
  CHECK(plant.state().errors == bit(Error::kCommunicationConstraintsViolation));
  client.step(plant);
  CHECK(plant.state().mode == Mode::kReflex);  // commands alone do not end it
}

TEST_CASE("a repeated sequence number is not a new command") {
  Plant plant(test_parameters());
  for (int i = 0; i <= kLostCommandsMax; ++i) {
    plant.set_command(Vector7d::Zero(), 1, 0);
    plant.step_1ms();
  }
  CHECK(plant.state().errors == bit(Error::kCommunicationConstraintsViolation));
}

TEST_CASE(
    "after a reflex the robot brakes to rest, and recovery with a new command moves it again") {
  Plant plant(test_parameters());
  const Vector7d push = (Vector7d() << 2, 0, 0, 0, 0, 0, 0).finished();
  for (std::uint64_t i = 1; i <= 60; ++i) {
    plant.set_command(push, i, 0);
    plant.step_1ms();
  }
  REQUIRE(plant.state().mode == Mode::kMove);
  REQUIRE(plant.state().dq[0] > 0.2);
  run(plant, kLostCommandsMax + 500);
  REQUIRE(plant.state().mode == Mode::kReflex);
  const Vector7d rest = plant.state().q;
  run(plant, 500);
  CHECK(plant.state().dq.cwiseAbs().maxCoeff() < 1e-3);
  CHECK((plant.state().q - rest).cwiseAbs().maxCoeff() < 1e-3);

  plant.request_recovery();
  plant.step_1ms();
  CHECK(plant.state().mode == Mode::kIdle);
  CHECK(plant.state().errors == 0);
  plant.set_command(Vector7d::Zero(), 1000, 77);
  plant.step_1ms();
  CHECK(plant.state().mode == Mode::kMove);
  CHECK(plant.state().command_seq == 1000);
  CHECK(plant.state().command_state_ns == 77);
}

TEST_CASE("a hand holds a ball on a tilted table until the end effector touches it") {
  Parameters parameters = test_parameters();
  parameters.world.table_tilt = {0.0175, 0.0};
  const auto way_in_2_s = [&] {
    Plant plant(parameters);
    const Eigen::Vector3d start = plant.state().objects[0].p_WB;
    run(plant, 2000);
    return (plant.state().objects[0].p_WB - start).head<2>().norm();
  };
  // 5/7 g sin(1 degree) for 2 s
  CHECK(way_in_2_s() == Approx(0.24).epsilon(0.05));
  parameters.world.objects[0].held = true;
  CHECK(way_in_2_s() < 1e-4);
  // so large that it touches the tool from below
  parameters.world.objects[0].position = {0.55, 0.0};
  parameters.world.objects[0].object = ball({0.55, 0.0}, 0.0643, 0.132).object;
  CHECK(way_in_2_s() > 0.01);
}

TEST_CASE("a command that is not finite is refused with its own flag") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Plant plant(test_parameters());
    Client client;
    for (int i = 0; i < 10; ++i) client.step(plant);
    Vector7d tau = Vector7d::Zero();
    tau[3] = bad;
    plant.set_command(tau, 1000, 0);
    run(plant, 10);
    CHECK(plant.state().mode == Mode::kReflex);
    CHECK(plant.state().errors == bit(Error::kCommandNotFinite));
    CHECK(plant.state().q.allFinite());
    CHECK(plant.state().tau.allFinite());
  }
}

TEST_CASE("a joint that is too fast or out of its range stops the robot and names it") {
  Plant fast(test_parameters());
  const Vector7d spin = (Vector7d() << 30, 0, 0, 0, 0, 0, 0).finished();
  for (std::uint64_t i = 1; i <= 300; ++i) {
    fast.set_command(spin, i, 0);
    fast.step_1ms();
  }
  CHECK(fast.state().mode == Mode::kReflex);
  CHECK(fast.state().errors == bit(Error::kJointVelocityViolation));
  CHECK(fast.state().cause.axis == 1);
  CHECK(fast.state().cause.value > 2.175);
  CHECK(fast.state().cause.limit == 2.175);

  Parameters near_limit = test_parameters();
  near_limit.initial_q[6] = near_limit.limits.q_max[6] - 1e-3;
  Plant far(near_limit);
  const Vector7d turn = (Vector7d() << 0, 0, 0, 0, 0, 0, 0.05).finished();
  for (std::uint64_t i = 1; i <= 500; ++i) {
    far.set_command(turn, i, 0);
    far.step_1ms();
  }
  CHECK(far.state().mode == Mode::kReflex);
  CHECK(far.state().errors == bit(Error::kJointPositionLimitsViolation));
  CHECK(text(far.state().cause) == "joint 7: 2.897 rad, limit 2.897");
}

TEST_CASE("a person's stop holds the arm until a person recovers it") {
  Plant plant(test_parameters());
  Client client;
  for (int i = 0; i < 10; ++i) client.step(plant);
  plant.request_stop();
  for (int i = 0; i < 100; ++i) client.step(plant);
  CHECK(plant.state().mode == Mode::kUserStopped);
  plant.request_recovery();
  client.step(plant);
  CHECK(plant.state().mode == Mode::kIdle);
  client.step(plant);
  CHECK(plant.state().mode == Mode::kMove);
}

TEST_CASE("dropped commands stop the robot once they are too many") {
  Plant plant(test_parameters());
  Client client;
  for (int i = 0; i < 100; ++i) client.step(plant);
  plant.drop_commands(0.015);
  for (int i = 0; i < 100; ++i) client.step(plant);
  CHECK(plant.state().mode == Mode::kMove);
  CHECK(plant.state().lost_commands == 15);
  plant.drop_commands(0.1);
  for (int i = 0; i < 100; ++i) client.step(plant);
  CHECK(plant.state().errors == bit(Error::kCommunicationConstraintsViolation));
}

TEST_CASE("a robot that missed commands moves by itself once they are back, holes and all") {
  for (const bool alone : {false, true}) {
    CAPTURE(alone);
    Parameters parameters = test_parameters();
    parameters.recovers_alone = alone;
    Plant plant(parameters);
    Client client;
    for (int i = 0; i < 100; ++i) client.step(plant);
    run(plant, 500);
    REQUIRE(plant.state().errors == bit(Error::kCommunicationConstraintsViolation));
    CHECK(plant.waits_for_commands() == alone);
    // every second one is too few
    for (int i = 0; i < 1000; ++i) {
      client.step(plant);
      run(plant, 1);
    }
    CHECK(plant.state().mode == Mode::kReflex);
    run(plant, kLostCommandsMax);
    // one in four is missing: a machine with other things to do
    int cycles = 0;
    for (; cycles < 500 && plant.state().mode == Mode::kReflex; ++cycles) {
      if (cycles % 4 == 3) {
        run(plant, 1);
      } else {
        client.step(plant);
      }
    }
    CHECK((plant.state().mode != Mode::kReflex) == alone);
    if (alone) CHECK(cycles == Approx(kCommandsToRecover * 4.0 / 3.0).margin(2));
    CHECK_FALSE(plant.waits_for_commands());
  }
}

TEST_CASE("a robot that stopped for more than missing commands waits for a person") {
  Parameters parameters = test_parameters();
  parameters.recovers_alone = true;
  Plant plant(parameters);
  Client client;
  for (int i = 0; i < 100; ++i) client.step(plant);
  plant.set_command(Vector7d::Constant(std::nan("")), client.seq_ + 1, 0);
  ++client.seq_;
  run(plant, 1);
  REQUIRE(plant.state().mode == Mode::kReflex);
  CHECK_FALSE(plant.waits_for_commands());
  for (int i = 0; i < 1000; ++i) client.step(plant);
  CHECK(plant.state().mode == Mode::kReflex);
}

TEST_CASE("the same commands give the same bits") {
  Plant a(test_parameters());
  Plant b(test_parameters());
  Client client_a, client_b;
  for (int i = 0; i < 2000; ++i) {
    if (i == 300) {
      a.push(0, {0.004, -0.01, 0});
      b.push(0, {0.004, -0.01, 0});
    }
    client_a.step(a);
    client_b.step(b);
  }
  REQUIRE(a.state().objects[0].v_WB.norm() > 0.01);
  const auto bytes = [](const mjModel& m) {
    return static_cast<std::size_t>(m.nq) * sizeof(double);
  };
  CHECK(std::memcmp(a.data().qpos, b.data().qpos, bytes(a.model())) == 0);
  CHECK(std::memcmp(a.data().qvel, b.data().qvel,
                    static_cast<std::size_t>(a.model().nv) * sizeof(double)) == 0);
}

TEST_CASE("a cycle does not allocate") {
  Plant plant(test_parameters());
  Client client;
  std::int64_t heap_calls = 0;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 1000; ++i) {
      if (i == 200) plant.push(0, {0.01, 0, 0});
      if (i == 500) plant.request_stop();
      if (i == 700) plant.request_recovery();
      client.step(plant);
    }
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
  CHECK(plant.state().mode == Mode::kMove);
}

TEST_CASE("mode table") {
  struct Row {
    Mode from;
    Events events;
    Mode to;
    Errors errors;
  };
  const Errors e = bit(Error::kCommandNotFinite);
  const Row rows[] = {
      {Mode::kIdle, {false, 0, false, false}, Mode::kIdle, 0},
      {Mode::kIdle, {true, 0, false, false}, Mode::kMove, 0},
      {Mode::kIdle, {true, e, false, false}, Mode::kReflex, e},
      {Mode::kIdle, {true, 0, true, false}, Mode::kUserStopped, 0},
      {Mode::kIdle, {false, 0, false, true}, Mode::kIdle, 0},
      {Mode::kMove, {true, 0, false, false}, Mode::kMove, 0},
      {Mode::kMove, {false, 0, false, false}, Mode::kMove, 0},
      {Mode::kMove, {true, e, false, false}, Mode::kReflex, e},
      {Mode::kMove, {true, e, true, false}, Mode::kUserStopped, 0},
      {Mode::kMove, {true, 0, false, true}, Mode::kMove, 0},
      {Mode::kReflex, {true, 0, false, false}, Mode::kReflex, e},
      {Mode::kReflex, {true, 0, false, true}, Mode::kIdle, 0},
      {Mode::kReflex, {true, 0, true, true}, Mode::kUserStopped, e},
      {Mode::kUserStopped, {true, 0, false, false}, Mode::kUserStopped, 0},
      {Mode::kUserStopped, {true, e, false, false}, Mode::kUserStopped, e},
      {Mode::kUserStopped, {true, 0, false, true}, Mode::kIdle, 0},
      {Mode::kIdle, {true, 0, false, false, true}, Mode::kGuiding, 0},
      {Mode::kMove, {true, 0, false, false, true}, Mode::kMove, 0},
      {Mode::kReflex, {true, 0, false, false, true}, Mode::kGuiding, e},
      {Mode::kGuiding, {true, 0, false, true}, Mode::kGuiding, 0},
      {Mode::kGuiding, {true, 0, false, false, false, true}, Mode::kIdle, 0},
      {Mode::kGuiding, {true, e, false, false}, Mode::kReflex, e},
      {Mode::kGuiding, {true, 0, true, false}, Mode::kUserStopped, 0},
  };
  for (const Row& row : rows) {
    const ModeState before{row.from, row.from == Mode::kReflex ? e : 0};
    const ModeState after = next(before, row.events);
    CAPTURE(static_cast<int>(row.from), row.events.command, row.events.errors, row.events.stop,
            row.events.recover);
    CHECK(after.mode == row.to);
    CHECK(after.errors == row.errors);
  }
}

TEST_CASE(
    "a box lies on the table as the scenario says, and a push slides it as far as friction lets") {
  Parameters parameters = test_parameters();
  ObjectParameters box{};
  box.object = scene::solid("box", scene::Shape::box({0.05, 0.04, 0.03}), 0.5);
  box.position = {0.55, 0.1};
  box.yaw = 0.5;
  box.friction_table = 0.4;
  parameters.world.objects = {box};
  Plant plant(parameters);
  const scene::Body start = plant.state().objects[0];
  CHECK((start.p_WB - Eigen::Vector3d(0.55, 0.1, -0.0245 + 0.03)).norm() < 1e-12);
  CHECK(scene::yaw(start) == Approx(0.5));
  for (int i = 0; i < 500; ++i) plant.step_1ms();
  CHECK((plant.state().objects[0].p_WB - start.p_WB).norm() < 2e-4);
  CHECK(std::abs(scene::yaw(plant.state().objects[0]) - 0.5) < 1e-4);
  // v = 0.2 / 0.5, s = v^2 / (2 mu g)
  const Eigen::Vector3d rest = plant.state().objects[0].p_WB;
  plant.push(0, {0.2, 0.0, 0.0});
  for (int i = 0; i < 1000; ++i) plant.step_1ms();
  const Eigen::Vector3d moved = plant.state().objects[0].p_WB - rest;
  CHECK(moved.x() == Approx(0.4 * 0.4 / (2.0 * 0.4 * 9.81)).epsilon(0.05));
  CHECK(std::abs(moved.y()) < 1e-3);
  CHECK(plant.state().objects[0].v_WB.norm() < 1e-3);
}

TEST_CASE("eight objects of every shape rest on the table where they start") {
  Parameters parameters = test_parameters();
  using scene::Shape;
  const std::vector<scene::Object> objects{
      scene::solid("ball", Shape::sphere(0.03), 0.1),
      scene::solid("box", Shape::box({0.03, 0.02, 0.025}), 0.2),
      scene::solid("capsule", Shape::capsule(0.02, 0.03), 0.1),
      scene::solid("can", Shape::cylinder(0.02, 0.03), 0.1),
      mjcf::read_object(C3RT_SOURCE_DIRECTORY "/config/objects/t.xml").object,
      scene::solid("second", Shape::box({0.02, 0.02, 0.02}), 0.2),
      scene::solid("third", Shape::box({0.02, 0.02, 0.02}), 0.2),
      scene::solid("fourth", Shape::box({0.02, 0.02, 0.02}), 0.2)};
  parameters.world.objects.clear();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    ObjectParameters object{};
    object.object = objects[i];
    object.position = {0.3 + 0.15 * static_cast<double>(i % 4), i < 4 ? -0.3 : 0.3};
    object.yaw = 0.3 * static_cast<double>(i);
    if (i == 2) object.roll_pitch = {M_PI_2, 0.0};
    parameters.world.objects.push_back(object);
  }
  Plant plant(parameters);
  const State start = plant.state();
  REQUIRE(start.object_count == 8);
  CHECK(start.objects[2].p_WB.z() == Approx(-0.0245 + 0.02));
  CHECK(start.objects[3].p_WB.z() == Approx(-0.0245 + 0.03));
  CHECK(start.objects[4].p_WB.z() == Approx(-0.0245 + 0.02));
  run(plant, 300);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    CAPTURE(objects[i].name);
    CHECK((plant.state().objects[i].p_WB - start.objects[i].p_WB).norm() < 3e-4);
    CHECK(plant.state().objects[i].q_WB.angularDistance(Eigen::Quaterniond(start.objects[i].q_WB)) <
          2e-3);
  }
}

TEST_CASE("the T of a file moves as the rigid body that the file describes") {
  Parameters parameters = test_parameters();
  ObjectParameters t{};
  t.object = mjcf::read_object(C3RT_SOURCE_DIRECTORY "/config/objects/t.xml").object;
  t.position = {0.55, 0.1};
  t.yaw = 0.7;
  parameters.world.objects = {t};
  const Plant plant(parameters);
  // mass matrix of MuJoCo's free joint: mass, then the inertia in the body's axes
  const int nv = plant.model().nv;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(nv, nv);
  mj_fullM(&plant.model(), M.data(), plant.data().qM);
  CHECK(M.block<3, 3>(kJoints, kJoints).isApprox(0.56 * Eigen::Matrix3d::Identity(), 1e-9));
  CHECK(M.block<3, 3>(kJoints + 3, kJoints + 3).isApprox(t.object.inertia, 1e-6));
  CHECK(M.block<3, 3>(kJoints, kJoints + 3).norm() < 1e-12);
  CHECK(scene::yaw(plant.state().objects[0]) == Approx(0.7));
  CHECK(std::string(plant.state().objects[0].name.c_str()) == "t");
}

TEST_CASE("every error has its own name") {
  CHECK(names(0).empty());
  CHECK(names(bit(Error::kJointVelocityViolation) | bit(Error::kCommandNotFinite)) ==
        "joint_velocity_violation, command_not_finite");
  CHECK(std::string(name(Error::kInstabilityDetected)) == "instability_detected");
}

}  // namespace
