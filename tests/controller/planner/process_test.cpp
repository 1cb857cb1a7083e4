// The process c3rt-planner on a real bus, with this test as its plant and its vision.
#include "idl/process.hpp"

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "idl/convert.hpp"
#include "tests/idl/bus_fixture.hpp"
#include "tests/support/child_process.hpp"

using namespace c3rt;
using wire::test::eventually;
using wire::test::kMs;
using wire::test::kSecond;

namespace {

const std::string kScenario = C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml";

std::vector<std::string> command(const std::string& clock, std::vector<std::string> more = {}) {
  more.insert(more.end(), {"--clock", clock});
  return test::process_command("c3rt-planner", kScenario, wire::test::kDomain, more);
}

/// The robot at rest in its start pose and the ball at the start of the circle, in lockstep.
class World {
 public:
  explicit World(const std::vector<std::string>& more = {})
      : child(command("lockstep", more)),
        bus(wire::test::settings(wire::ClockMode::kLockstep, wire::draw_session())),
        states(bus),
        estimates(bus),
        targets(bus),
        weights(bus),
        faults(bus),
        replies(bus),
        plans(bus),
        debugs(bus),
        master(bus, {c3rt_v2_PROCESS_PLANNER}, 30 * kSecond) {}

  /// One millisecond; @return whether a plan came
  bool step(wire::Plan& plan, bool ball_in_view = true) {
    now_ns += kMs;
    wire::RobotState state{};
    const double q[] = {0.0, 0.275, 0.0, -2.222, 0.0, 2.497, 0.0};
    std::copy(std::begin(q), std::end(q), state.q_rad);
    states.write(state, now_ns);
    if (now_ns % (12 * kMs) == 0) {
      wire::ObjectEstimate estimate{};
      estimate.exposure_ns = now_ns;
      estimate.valid = ball_in_view;
      const double p[] = {0.55, 0.1, 0.007};
      std::copy(std::begin(p), std::end(p), estimate.p_WB_m);
      estimate.q_WB[0] = 1.0;
      estimates.write(estimate, now_ns);
    }
    REQUIRE(master.advance(now_ns));
    debugs.take_newest(debug);
    return plans.take_newest(plan);
  }

  /// The answer to a request, while time goes on.
  wire::ServiceReply answer_to(std::uint64_t request_id) {
    wire::ServiceReply reply{};
    wire::Plan plan{};
    for (int i = 0; i < 2000; ++i) {
      while (replies.take(reply)) {
        if (reply.request_id == request_id) return reply;
      }
      usleep(500);
      step(plan);
    }
    return {};
  }

  test::ChildProcess child;
  wire::Bus bus;
  wire::Writer<wire::RobotState> states;
  wire::Writer<wire::ObjectEstimate> estimates;
  wire::Writer<wire::TaskTarget> targets;
  wire::Writer<wire::PlannerWeights> weights;
  wire::Writer<wire::FaultInject> faults;
  wire::Reader<wire::ServiceReply> replies;
  wire::Reader<wire::Plan> plans;
  wire::Reader<wire::PlannerDebug> debugs;
  wire::PlannerDebug debug{};  // of the newest plan
  wire::LockstepMaster master;
  std::int64_t now_ns = 0;
};

task::Request circle(double x, double y, double radius, double lead_deg) {
  return {"circle",
          {{"center_m", {x, y}, ""},
           {"radius_m", {radius}, ""},
           {"lead_rad", {lead_deg * M_PI / 180.0}, ""}}};
}

task::Request pose(double x, double y) {
  return {"pose",
          {{"goals_m", {x, y}, ""}, {"position_tolerance_m", {0.01}, ""}, {"hold_s", {1.0}, ""}}};
}

}  // namespace

TEST_CASE("c3rt-planner: plans come at the fixed rate, and carry what they were made from") {
  World world({"--set", "planner.rate_hz=75", "--set", "planner.publish_delay_s=0.02"});
  wire::Plan plan{};
  int count = 0;
  std::int64_t previous_ns = 0;
  for (int i = 0; i < 1000; ++i) {
    if (!world.step(plan)) continue;
    ++count;
    CHECK(plan.header.session_id == world.bus.session_id());
    CHECK(plan.origin.state_ns == world.now_ns);
    CHECK(plan.header.time_ns == plan.origin.state_ns + 20 * kMs);  // publish_delay_s
    CHECK(plan.valid_until_ns == plan.header.time_ns + 100 * kMs);
    if (previous_ns != 0) {
      const std::int64_t period_ns = plan.origin.state_ns - previous_ns;
      CHECK((period_ns == 13 * kMs || period_ns == 14 * kMs));
    }
    previous_ns = plan.origin.state_ns;
    if (world.now_ns > 100 * kMs) {
      CHECK(plan.origin.exposure_ns > 0);
      CHECK(plan.phase == std::string("approach"));
    }
  }
  CHECK((count >= 74 && count <= 76));
  world.child.signal(SIGTERM);
  CHECK(world.child.wait() == 0);
}

TEST_CASE(
    "c3rt-planner: it holds while the ball is out of view, and approaches it when it is back") {
  World world;
  wire::Plan plan{};
  for (int i = 0; i < 300; ++i) world.step(plan);
  CHECK(plan.phase == std::string("approach"));
  for (int i = 0; i < 300; ++i) world.step(plan, false);
  CHECK(plan.phase == std::string("hold"));
  for (int i = 0; i < 100; ++i) world.step(plan);
  CHECK(plan.phase == std::string("approach"));
}

TEST_CASE("c3rt-planner: a client's target is checked, obeyed, and ended by the scenario's own") {
  World world;
  wire::Plan plan{};
  const auto send = [&](const task::Request& request) {
    wire::TaskTarget target = wire::task_target(request);
    world.targets.write(target, world.now_ns);
    const std::uint64_t before = plan.header.seq;
    // a client's sample is in no tick: give the network a moment
    for (int i = 0; i < 400 && plan.header.seq < before + 20; ++i) {
      usleep(500);
      world.step(plan);
    }
  };
  for (int i = 0; i < 100; ++i) world.step(plan);
  const double x_scenario = world.debug.p_WB_target_m[0];
  send({"hold", {}});
  CHECK(plan.phase == std::string("hold"));
  send(circle(0.5, 0, 0.1, 17));
  CHECK(plan.phase == std::string("approach"));
  const double x_circle = world.debug.p_WB_target_m[0];
  CHECK(std::abs(x_circle - x_scenario) > 0.005);
  send(circle(0.5, 0, std::nan(""), 17));
  CHECK(world.debug.p_WB_target_m[0] == x_circle);
  send({"scenario", {}});
  CHECK(world.debug.p_WB_target_m[0] == x_scenario);
}

TEST_CASE("c3rt-planner: every target is answered, a refused one with what can be reached") {
  World world;
  wire::Plan plan{};
  for (int i = 0; i < 100; ++i) world.step(plan);
  std::uint64_t id = 0;
  const auto ask = [&](const task::Request& request) {
    wire::TaskTarget target = wire::task_target(request);
    target.request_id = ++id;
    world.targets.write(target, world.now_ns);
    return world.answer_to(id);
  };
  struct Case {
    task::Request request;
    const char* expected;  // nothing: taken
  };
  for (const Case& c :
       {Case{circle(5, 5, 0.1, 20), "center_m: expected 2 numbers from -1 to 1, got 5"},
        Case{circle(0.9, 0, 0.1, 20), "expected a centre with x in [0.47, 0.63]"},
        Case{circle(0.55, 0, 0.5, 20), "expected a radius of"},
        Case{circle(0.55, 0, 0.011, 20), "expected a radius of"},
        Case{circle(0.55, 0, 5, 20), "radius_m: expected a number from 0.01 to 0.5, got 5"},
        Case{circle(0.55, 0, 0.1, -179), "expected a lead of"},
        Case{circle(0.55, 0, 0.1, 400), "lead_rad: expected a number from"},
        Case{circle(0.55, 0, std::nan(""), 20), "values[0] is nan"},
        Case{pose(0.9, 0), "expected a goal with x in [0.37, 0.73]"},
        Case{{"spiral", {}}, "expected one of scenario, hold, circle, path, line, pose, got"},
        Case{{"circle", {}}, "center_m: expected 2 numbers from -1 to 1, got nothing"},
        Case{{"hold", {{"x", {1.0}, ""}}}, "expected no parameters, got \"x\""},
        Case{pose(0.5, 0.05), nullptr}, Case{circle(0.55, 0, 0.1, -20), nullptr},
        Case{{"path",
              {{"points_m", {0.5, 0.0, 0.6, 0.0, 0.6, 0.1}, ""},
               {"interval_s", {2.0}, ""},
               {"between", {}, "interpolate"},
               {"lead_s", {0.2}, ""},
               {"preview", {1.0}, ""}}},
             nullptr},
        Case{{"line",
              {{"x_m", {0.55}, ""},
               {"step_m", {-0.02}, ""},
               {"y_end_m", {-0.1}, ""},
               {"spacing_m", {0.0}, ""}}},
             nullptr},
        Case{{"hold", {}}, nullptr}, Case{{"scenario", {}}, nullptr}}) {
    const wire::ServiceReply reply = ask(c.request);
    CAPTURE(c.request.kind, reply.text);
    REQUIRE(reply.request_id == id);
    CHECK(reply.process == c3rt_v2_PROCESS_PLANNER);
    CHECK(reply.ok == (c.expected == nullptr));
    if (c.expected != nullptr) CHECK_THAT(reply.text, Catch::Contains(c.expected));
  }
}

TEST_CASE("c3rt-planner: other weights are taken where the scenario allows them, and answered") {
  const auto answers = [](const std::vector<std::string>& more,
                          const std::vector<std::map<std::string, double>>& asked) {
    World world(more);
    wire::Plan plan{};
    for (int i = 0; i < 50; ++i) world.step(plan);
    std::vector<std::string> texts;
    std::uint64_t id = 0;
    for (const auto& weights : asked) {
      wire::PlannerWeights sample = wire::planner_weights(weights);
      sample.request_id = ++id;
      world.weights.write(sample, world.now_ns);
      const wire::ServiceReply reply = world.answer_to(id);
      REQUIRE(reply.request_id == id);
      CHECK(reply.process == c3rt_v2_PROCESS_PLANNER);
      texts.push_back((reply.ok ? "ok: " : "no: ") + std::string(reply.text));
    }
    return texts;
  };
  CHECK(answers({"--set", "planner.weights.adjustable_by=100"},
                {{{"roll.Q.ball_xy", 2e5}, {"return.R", 0.02}},
                 {{"roll.R", 2.0}},
                 {{"roll.R", -1.0}},
                 {}}) ==
        std::vector<std::string>{"ok: return.R 0.02, roll.Q.ball_xy 200000",
                                 "no: refused: roll.R: expected a number in [0.0001, 1], got 2",
                                 "no: refused: weights.value[0] is -1, expected 0 to 1000000000000",
                                 "ok: the scenario's own"});
  const std::vector<std::string> none = answers({}, {{{"roll.Q.ball_xy", 2e5}}});
  CHECK_THAT(none[0], Catch::Contains("no: refused: expected a scenario with planner.weights."));
}

TEST_CASE("c3rt-planner: faults that it does not have, or that do not end, are refused by reply") {
  World world;
  wire::Plan plan{};
  for (int i = 0; i < 50; ++i) world.step(plan);
  std::uint64_t id = 100;
  const auto ask = [&](c3rt_v2_FaultKind kind, double duration) {
    wire::FaultInject fault{};
    fault.request_id = ++id;
    fault.process = c3rt_v2_PROCESS_PLANNER;
    fault.kind = kind;
    fault.duration_s = duration;
    world.faults.write(fault, world.now_ns);
    return world.answer_to(id);
  };
  const wire::ServiceReply push = ask(c3rt_v2_FAULT_PUSH_OBJECT, 1.0);
  CHECK_FALSE(push.ok);
  CHECK_THAT(push.text, Catch::Contains("expected none, stall or nan of planner, got push-object"));
  for (const double bad : {std::nan(""), 0.0, -1.0, 1e9}) {
    CAPTURE(bad);
    const wire::ServiceReply reply = ask(c3rt_v2_FAULT_STALL, bad);
    REQUIRE(reply.request_id == id);
    CHECK_FALSE(reply.ok);
    CHECK_THAT(reply.text, Catch::Contains("refused: "));
  }
  CHECK(ask(c3rt_v2_FAULT_STALL, 0.01).ok);
  CHECK(ask(c3rt_v2_FAULT_NONE, 0.0).ok);
}

TEST_CASE("c3rt-planner: a mistake in the scenario ends it with status 2 and names the key") {
  const std::string log = std::string(C3RT_BINARY_DIRECTORY) + "/planner_refused.log";
  test::ChildProcess child(command("realtime", {"--set", "planner.horizon=0"}), log);
  CHECK(child.wait() == 2);
  std::string text(4096, '\0');
  const int file = open(log.c_str(), O_RDONLY);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, read(file, text.data(), text.size()))));
  close(file);
  CHECK_THAT(text, Catch::Contains("planner.horizon: expected an integer in [1, 10], got \"0\""));
}
