// The planner on the types of the wire, without a bus; its clock is the test's.
#include "controller/planner/node.hpp"

#include <cmath>
#include <string>

#include <catch2/catch.hpp>

#include "config/scenario.hpp"
#include "idl/convert.hpp"

using namespace c3rt;
using namespace c3rt::planner;

namespace {

constexpr std::int64_t kMs = 1'000'000;

std::int64_t machine_ns = 0;       // the clock of the machine
std::int64_t machine_tick_ns = 0;  // goes on by this whenever it is read
std::int64_t read_clock() noexcept { return machine_ns += machine_tick_ns; }

config::Scenario scenario() {
  return config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml");
}

struct World {
  explicit World(bool realtime = false)
      : node(all.planner, model::Arm(all.impedance.arm),
             {&read_clock, realtime, all.timing.solve_time_s}) {
    in.has_state = true;
    in.state.mode = c3rt_v2_ROBOT_MOVE;
    wire::fill(in.state.q_rad, all.plant.initial_q);
    in.command.mode = c3rt_v2_IMPEDANCE_TRACK;
  }
  const Node::Output& step() {
    now_ns += std::llround(1e9 / all.planner.rate);
    in.state.header.time_ns = in.command.header.time_ns = now_ns;
    wire::ObjectEstimate estimate{};
    estimate.header.time_ns = now_ns - 2 * kMs;
    estimate.exposure_ns = now_ns - 10 * kMs;
    estimate.valid = true;
    wire::fill(estimate.p_WB_m, Eigen::Vector3d(0.55, 0.1, 0.007));
    estimate.q_WB[0] = 1.0;
    in.objects[0] = estimate;
    return node.step(now_ns, in);
  }
  const config::Scenario all = scenario();
  Node node;
  Node::Input in;
  std::int64_t now_ns = 0;
};

TEST_CASE("planner node: without the robot's state nothing is sent") {
  World world;
  world.in.has_state = false;
  CHECK_FALSE(world.step().plans);
  world.in.has_state = true;
  CHECK(world.step().plans);
}

TEST_CASE("planner node: a plan carries what it was made from, and when it takes effect") {
  World world;
  const Node::Output& out = world.step();
  REQUIRE(out.plans);
  CHECK(out.plan.origin.state_ns == world.now_ns);
  CHECK(out.plan.origin.exposure_ns == world.now_ns - 10 * kMs);
  CHECK(out.plan.origin.estimate_ns == world.now_ns - 2 * kMs);
  const double delay = std::max(world.all.planner.publish_delay, world.all.timing.solve_time_s);
  CHECK(out.effective_ns == world.now_ns + std::llround(1e9 * delay));
  CHECK(out.plan.valid_until_ns ==
        out.effective_ns + std::llround(1e9 * world.all.planner.valid_for));
  CHECK(out.plan.knot_count == 1);
  CHECK(out.plan.knots[0].time_ns >= out.effective_ns);
  CHECK(out.debug.horizon == world.all.planner.N);
  CHECK(out.debug.object_index == 0);
}

TEST_CASE(
    "planner node: in simulated time how long a solve took changes nothing but what is told") {
  World quick, slow;
  for (int i = 0; i < 40; ++i) {
    machine_tick_ns = 0;
    const Node::Output& one = quick.step();
    machine_tick_ns = 50 * kMs;
    const Node::Output& other = slow.step();
    CHECK(one.measured == 0.0);
    CHECK(other.measured >= 0.05);
    CHECK(one.effective_ns == other.effective_ns);
    CHECK(one.plan.status == other.plan.status);
    for (int axis = 0; axis < 3; ++axis)
      CHECK(one.plan.knots[0].p_WE_m[axis] == other.plan.knots[0].p_WE_m[axis]);
  }
  machine_tick_ns = 0;
}

TEST_CASE("planner node: in realtime a plan takes effect when it is there, if that is late") {
  World world(true);
  machine_ns = std::llround(1e9 / world.all.planner.rate);  // the first period begins
  machine_tick_ns = 0;
  const std::int64_t effective_ns = world.step().effective_ns;
  CHECK(effective_ns == world.now_ns + std::llround(1e9 * world.all.planner.publish_delay));
  machine_tick_ns = 20 * kMs;
  machine_ns = world.now_ns;
  const Node::Output& late = world.step();
  CHECK(late.effective_ns > world.now_ns + std::llround(1e9 * world.all.planner.publish_delay));
  machine_tick_ns = 0;
}

TEST_CASE("planner node: a fault makes the plan not finite, for the next reader to refuse") {
  World world;
  world.in.spoilt = true;
  CHECK(std::isnan(world.step().plan.knots[0].p_WE_m[0]));
  world.in.spoilt = false;
  CHECK(std::isfinite(world.step().plan.knots[0].p_WE_m[0]));
}

}  // namespace
