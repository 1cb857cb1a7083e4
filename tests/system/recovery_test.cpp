// The whole loop in one process: whatever is stopped, late, away or wrong, the robot never ends in
// a reflex that its own controller has caused, and goes on afterwards.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "idl/convert.hpp"
#include "tests/support/random.hpp"
#include "tests/support/run.hpp"

using namespace c3rt;

namespace {

constexpr int kTimes = 20;
constexpr double kMoved = 0.004;  // of the arm, that shows that it goes on [m]

config::Scenario scenario(const std::string& name, const std::vector<std::string>& overrides = {}) {
  // as of a real table: without it a ball that nobody rolls is gone soon
  std::vector<std::string> all{"plant.rolling_friction_m=0.001"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  return config::load_scenario(
      std::string(C3RT_SOURCE_DIRECTORY "/config/scenarios/") + name + ".yaml", all);
}

bool stopped(test::Run& loop) {
  const plant::Mode mode = loop.plant().state().mode;
  return mode == plant::Mode::kReflex || mode == plant::Mode::kUserStopped;
}

/// @return false as soon as the robot has stopped
bool runs_on(test::Run& loop, double seconds) {
  const double end = loop.time() + seconds;
  while (loop.time() < end) {
    loop.step_1ms();
    if (!stopped(loop)) continue;
    const plant::State& state = loop.plant().state();
    UNSCOPED_INFO(plant::names(state.errors)
                  << " at " << loop.time() << " s, end effector " << state.p_WE.transpose()
                  << " m, joints " << state.dq.transpose() << " rad/s, reference "
                  << loop.control().p_WE_desired.transpose() << " m, "
                  << loop.control().v_WE_desired.transpose() << " m/s");
    return false;
  }
  return true;
}

void run(test::Run& loop, double seconds) {
  const double end = loop.time() + seconds;
  while (loop.time() < end) loop.step_1ms();
}

/// Runs until the arm has moved. @return false if it stops or rests
bool goes_on(test::Run& loop, double within = 3.0) {
  const Eigen::Vector3d here = loop.plant().state().p_WE;
  const double end = loop.time() + within;
  while ((loop.plant().state().p_WE - here).norm() < kMoved) {
    loop.step_1ms();
    if (stopped(loop) || loop.time() > end) return false;
  }
  return true;
}

/// Never near the limits that make a robot stop.
void check_within_limits(const test::Run& loop) { CHECK(loop.fastest_joint() < 0.9); }

}  // namespace

TEST_CASE("recovery: a stop by a person and a recovery, in the middle of whatever it does") {
  for (const char* name : {"circle_slow", "circle_fast", "two_balls"}) {
    CAPTURE(name);
    test::Run loop(scenario(name), 1);
    run(loop, 0.4);
    for (int i = 0; i < kTimes; ++i) {
      CAPTURE(i);
      loop.stop();
      run(loop, 0.1 + 0.03 * i);
      REQUIRE(loop.plant().state().mode == plant::Mode::kUserStopped);
      // what will be tracked waits where the arm is
      CHECK((loop.p_WE_planned() - loop.plant().state().p_WE).norm() < 1e-3);
      CHECK((loop.control().p_WE_desired - loop.plant().state().p_WE).norm() < 1e-3);
      loop.recover();
      run(loop, 0.01);
      REQUIRE(runs_on(loop, 0.3 + 0.09 * i));
    }
    CHECK(goes_on(loop));
    check_within_limits(loop);
  }
}

TEST_CASE("recovery: a planner that stalls and comes back, at any time") {
  test::Run loop(scenario("circle_slow"), 2);
  REQUIRE(runs_on(loop, 0.5));
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    loop.running.planner = false;
    REQUIRE(runs_on(loop, i % 2 == 0 ? 2.0 : 0.02 * i));
    loop.running.planner = true;
    REQUIRE(runs_on(loop, 0.35 + 0.07 * i));
  }
  CHECK(goes_on(loop, 5.0));
  check_within_limits(loop);
}

TEST_CASE("recovery: a planner, a vision or an impedance process that is started anew") {
  for (const int process : {0, 1, 2}) {
    CAPTURE(process);
    test::Run loop(scenario("circle_slow"), 3);
    REQUIRE(runs_on(loop, 0.6));
    for (int i = 0; i < kTimes; ++i) {
      CAPTURE(i);
      const double away = i % 2 == 0 ? 0.05 : 0.5;
      if (process == 0) loop.running.planner = false;
      if (process == 1) loop.running.vision = false;
      if (process == 2) loop.running.impedance = false;
      run(loop, away);
      loop.running = {};
      if (process == 0) loop.restart(c3rt_v2_PROCESS_PLANNER);
      if (process == 1) loop.restart(c3rt_v2_PROCESS_VISION);
      if (process == 2) loop.restart(c3rt_v2_PROCESS_IMPEDANCE);
      // commands that were lost are forgiven once they come steadily again
      run(loop, 0.3);
      REQUIRE(runs_on(loop, 0.5 + 0.05 * i));
    }
    CHECK(goes_on(loop, 5.0));
    check_within_limits(loop);
  }
}

TEST_CASE(
    "recovery: an impedance process that stalls, too short and long enough for the robot to stop") {
  test::Run loop(scenario("circle_slow"), 4);
  REQUIRE(runs_on(loop, 0.5));
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    loop.running.impedance = false;
    const double away = i % 2 == 0 ? 0.3 : 0.015;
    run(loop, away);
    CHECK(stopped(loop) == (away > 0.02));
    loop.running.impedance = true;
    run(loop, 0.3);
    REQUIRE(runs_on(loop, 0.3 + 0.09 * i));
  }
  CHECK(goes_on(loop, 5.0));
  check_within_limits(loop);
}

TEST_CASE("recovery: lost commands wait for a person where the scenario says so") {
  test::Run loop(scenario("circle_slow", {"service.recovery=by_person"}), 4);
  REQUIRE(runs_on(loop, 0.5));
  loop.running.impedance = false;
  run(loop, 0.3);
  loop.running.impedance = true;
  run(loop, 2.0);
  CHECK(stopped(loop));
  loop.recover();
  run(loop, 0.01);
  CHECK(runs_on(loop, 1.0));
}

TEST_CASE("recovery: a plant that stalls, and robot states that are not finite") {
  for (const bool nan : {false, true}) {
    CAPTURE(nan);
    test::Run loop(scenario("circle_slow"), 5);
    REQUIRE(runs_on(loop, 0.5));
    for (int i = 0; i < kTimes; ++i) {
      CAPTURE(i);
      loop.running.plant = nan;
      loop.nan_state = nan;
      run(loop, nan ? 0.05 : 0.3);
      loop.running.plant = true;
      loop.nan_state = false;
      run(loop, 0.25);
      REQUIRE_FALSE(stopped(loop));
      // what is not finite is refused at the edge: it is missing, no more
      CHECK(loop.control().mode != impedance::Mode::kStop);
      REQUIRE(runs_on(loop, 0.3 + 0.09 * i));
    }
    CHECK(goes_on(loop, 5.0));
    check_within_limits(loop);
  }
}

TEST_CASE(
    "recovery: robot states that do not arrive for a while, too short and long enough to stop") {
  for (const char* name : {"circle_slow", "circle_fast"}) {
    CAPTURE(name);
    test::Run loop(scenario(name), 5);
    REQUIRE(runs_on(loop, 0.5));
    for (int i = 0; i < kTimes; ++i) {
      CAPTURE(i);
      const double away = 0.01 * (1 << i % 8);  // 0.01 to 1.28 s
      const Eigen::Vector3d here = loop.plant().state().p_WE;
      loop.lost_state = true;
      // the arm coasts at 0.25 m/s at most, until the robot brakes as it gets no more commands
      run(loop, away);
      CHECK((loop.plant().state().p_WE - here).norm() < 0.25 * 0.14 + 0.015);
      CHECK((loop.control().mode == impedance::Mode::kStop) == (away > 0.12));
      CHECK(stopped(loop) == (away > 0.14));
      loop.lost_state = false;
      run(loop, away > 0.14 ? 0.45 : 0.0);
      REQUIRE(runs_on(loop, 0.5 + 0.09 * i));
    }
    CHECK(goes_on(loop, 5.0));
    check_within_limits(loop);
  }
}

TEST_CASE(
    "recovery: robot states that do not arrive for 0.1 s and more, whatever the arm does "
    "meanwhile") {
  for (const unsigned seed : {1u, 2u, 3u, 6u}) {
    CAPTURE(seed);
    const double away = seed % 3 == 0 ? 0.12 : 0.1;
    test::Run loop(scenario("circle_service"), seed);
    support::Random random(seed);
    REQUIRE(runs_on(loop, 6.0));
    for (int i = 0; i < 60; ++i) {
      CAPTURE(i);
      loop.lost_state = true;
      REQUIRE(runs_on(loop, away));
      loop.lost_state = false;
      REQUIRE(runs_on(loop, 0.3 + random.uniform(0.0, 0.3)));
    }
    CHECK(goes_on(loop, 5.0));
    // 1 in a reflex: where the law acted on an old state, and the reference went on before the arm
    // was at rest again
    CHECK(loop.fastest_joint() < 0.6);
  }
}

TEST_CASE("recovery: every process may start late, in any order") {
  for (int i = 0; i < kTimes; ++i) {
    CAPTURE(i);
    test::Run loop(scenario(i % 2 == 0 ? "circle_slow" : "circle_fast"),
                   100 + static_cast<std::uint64_t>(i));
    support::Random random(static_cast<unsigned>(i));
    double start[3];
    for (double& time : start) time = random.uniform(0.0, i % 4 == 0 ? 5.0 : 0.6);
    const double all = std::max({start[0], start[1], start[2]});
    while (loop.time() < all + 1.0) {
      loop.running.impedance = loop.time() >= start[0];
      loop.running.planner = loop.time() >= start[1];
      loop.running.vision = loop.time() >= start[2];
      loop.step_1ms();
      REQUIRE_FALSE(stopped(loop));
    }
    CHECK(goes_on(loop));
    check_within_limits(loop);
  }
}

namespace {

/// A planner that goes mad for a while, at several moments of a run.
template <typename Spoil>
void obeys_within_limits(const Spoil& spoil) {
  for (const char* name : {"circle_slow", "two_balls"}) {
    CAPTURE(name);
    test::Run loop(scenario(name), 6);
    REQUIRE(runs_on(loop, 0.7));
    for (int i = 0; i < 3; ++i) {
      CAPTURE(i);
      loop.spoil_plan = [&](wire::Plan& plan) { spoil(plan, loop); };
      REQUIRE(runs_on(loop, 1.0));
      loop.spoil_plan = nullptr;
      REQUIRE(runs_on(loop, 0.5 + 0.3 * i));
    }
    check_within_limits(loop);
  }
}

}  // namespace

TEST_CASE("recovery: a plan that jumps by 20 mm, forth and back, and farther") {
  for (const double jump : {0.02, 1.0}) {
    CAPTURE(jump);
    obeys_within_limits([&](wire::Plan& plan, const test::Run& loop) {
      const int half = static_cast<int>(loop.time() / 0.15);
      plan.knots[0].p_WE_m[1] += half % 2 == 0 ? jump : -jump;
    });
    // two planners at once
    obeys_within_limits([&](wire::Plan& plan, const test::Run& loop) {
      const int period = static_cast<int>(loop.time() / 0.005);
      if (period % 2 != 0) return;
      for (int axis : {0, 1}) plan.knots[0].p_WE_m[axis] += jump;
    });
  }
}

TEST_CASE("recovery: a plan with forces that no planner means") {
  for (const double force : {1e9, -500.0, -150.0, 30.0}) {
    CAPTURE(force);
    obeys_within_limits([&](wire::Plan& plan, const test::Run&) {
      wire::fill(plan.knots[0].force_E_n, Eigen::Vector3d(0.0, 0.0, force));
    });
  }
}

TEST_CASE("recovery: a plan that is a wave of 0.1 m, from slow to very fast") {
  for (const double frequency : {0.5, 2.0, 8.0}) {
    CAPTURE(frequency);
    obeys_within_limits([&](wire::Plan& plan, const test::Run& loop) {
      const double phase = 2.0 * M_PI * frequency * loop.time();
      wire::fill(plan.knots[0].p_WE_m, Eigen::Vector3d(0.55, 0.1 * std::sin(phase), 0.12));
      wire::fill(plan.knots[0].v_WE_m_per_s,
                 Eigen::Vector3d(0.0, 0.1 * 2.0 * M_PI * frequency * std::cos(phase), 0.0));
    });
  }
}

TEST_CASE("recovery: a plan that asks for 5 m/s") {
  obeys_within_limits([](wire::Plan& plan, const test::Run& loop) {
    const int half = static_cast<int>(loop.time() / 0.1);
    // clear of ball and table, which no law can soften when they are hit at speed
    wire::fill(plan.knots[0].p_WE_m, Eigen::Vector3d(0.55, 0.0, 0.15));
    wire::fill(plan.knots[0].v_WE_m_per_s,
               Eigen::Vector3d(half % 2 == 0 ? 5.0 : -5.0, 0.0, half % 3 == 0 ? 5.0 : -5.0));
  });
}

TEST_CASE("recovery: a plan that turns the tool over") {
  obeys_within_limits([](wire::Plan& plan, const test::Run& loop) {
    const int half = static_cast<int>(loop.time() / 0.25);
    const Eigen::Quaterniond turned =
        wire::quaternion(plan.knots[0].q_WE) *
        Eigen::Quaterniond(Eigen::AngleAxisd(half % 2 == 0 ? 1.0 : -1.0, Eigen::Vector3d::UnitX()));
    wire::fill(plan.knots[0].q_WE, turned);
  });
}
