#include "controller/impedance/controller.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/panda.hpp"

using namespace c3rt;
using namespace c3rt::impedance;

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint64_t kSession = 42;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Quaterniond kDown(0, 1, 0, 0);

Parameters parameters() {
  Parameters p;
  p.period = 1e-3;
  p.reference = Reference::kHold;
  p.feed_forward = true;
  p.feed_forward_threshold = 0.01;
  p.gains.stiffness << 500, 500, 500, 900, 900, 900;
  p.gains.damping << 44.72, 44.72, 44.72, 42.43, 42.43, 42.43;
  p.gains.null_space_stiffness = 4;
  p.gains.null_space_damping = 4;
  p.gains.null_space_q << 0, 0.361, 0, -2.223, 0, 2.584, 0;
  p.limits.reference_speed = 0.5;
  p.limits.reference_angular_speed = 0.5;
  p.limits.plan_speed = 0.4;
  p.limits.plan_acceleration = 25.0;
  p.limits.lead_acceleration = 6.25;
  p.limits.lead_angular_acceleration = 15.0;
  p.limits.plan_force = 30.0;
  p.limits.workspace_min << 0.3, -0.3, 0.0;
  p.limits.workspace_max << 0.75, 0.3, 0.4;
  p.limits.tau_max << 82.65, 82.65, 82.65, 82.65, 11.4, 11.4, 11.4;
  p.limits.tau_rate_max = 1000;
  p.limits.q_min << -2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973;
  p.limits.q_max << 2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973;
  p.limits.dq_max << 2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61;
  p.limits.state_timeout = 0.1;
  p.limits.plan_timeout = 0.2;
  p.limits.stop_damping = 10;
  p.thread = {0, -1};
  return p;
}

Controller make(const Parameters& p) { return Controller(p, model::Arm(test::panda_arm())); }

/// A robot at the start posture, with a state stamped now and no plan.
Input at(std::int64_t now_ns) {
  Input input;
  input.now_ns = now_ns;
  input.has_state = true;
  input.session_id = kSession;
  input.state_stamp_ns = now_ns;
  input.q << 0, 0.275, 0, -2.222, 0, 2.497, 0;
  input.robot_moves = true;
  return input;
}

const Vector3d kStart(0.5499, 0, 0.1238);  // E at that posture

void give_plan(Input& input, const Vector3d& p_WE, std::int64_t stamp_ns) {
  input.has_plan = true;
  input.plan.session_id = kSession;
  input.plan.stamp_ns = stamp_ns;
  input.plan.valid_until_ns = stamp_ns + 100 * kMs;
  input.plan.status = PlanStatus::kOk;
  input.plan.knots[0].p_WE = p_WE;
  input.plan.knots[0].v_WE.setZero();
  input.plan.knots[0].q_WE = kDown;
  input.plan.knots[0].force_E.setZero();
  input.plan.knot_count = 1;
  input.plan.knots[0].time_ns = stamp_ns + 13'300'000;
}

Input with_plan(std::int64_t now_ns, const Vector3d& p_WE = kStart) {
  Input input = at(now_ns);
  give_plan(input, p_WE, now_ns);
  return input;
}

/// The exact arm under the controller's torque, 1 ms per step.
struct Loop {
  explicit Loop(const Parameters& p) : controller(make(p)), plant(test::panda_arm()) {
    q = at(0).q;
  }
  Output step(Input input) {
    states_on_their_way.emplace_back(q, dq);
    while (static_cast<int>(states_on_their_way.size()) > state_delay + 1)
      states_on_their_way.pop_front();
    input.q = states_on_their_way.front().first;
    input.dq = states_on_their_way.front().second;
    input.state_stamp_ns -= state_delay * kMs;
    if (delay >= 0) input.answered_ns = input.state_stamp_ns - (delay + 1) * kMs;
    const Output output = controller.step(input);
    on_their_way.push_back(output.tau);
    while (static_cast<int>(on_their_way.size()) > std::max(delay, 0) + 1) on_their_way.pop_front();
    for (int i = 0; i < 4; ++i) {
      plant.update(q, dq, state);
      dq += 0.25e-3 *
            support::solve_definite(state.M, on_their_way.front() + external - state.coriolis);
      q += 0.25e-3 * dq;
    }
    plant.update(q, dq, state);
    return output;
  }
  Controller controller;
  model::Arm plant;
  ArmState state;
  Vector7d q, dq = Vector7d::Zero(), external = Vector7d::Zero();
  int delay = -1;       // of torques [cycles]; negative: none, and the robot does not tell
  int state_delay = 0;  // [cycles]
  std::deque<Vector7d> on_their_way;
  std::deque<std::pair<Vector7d, Vector7d>> states_on_their_way;
};

TEST_CASE("mode: every mode and every health has the successor that the rules say") {
  // written out once more from the rules, in another order than the code's
  for (const Mode mode : {Mode::kWait, Mode::kHold, Mode::kTrack, Mode::kStop}) {
    for (int bits = 0; bits < 64; ++bits) {
      const Health h{(bits & 1) != 0, (bits & 2) != 0,  (bits & 4) != 0,
                     (bits & 8) != 0, (bits & 16) != 0, (bits & 32) != 0};
      const Mode after = next(mode, h);
      CAPTURE(static_cast<int>(mode), bits, static_cast<int>(after));
      const bool waits_on = mode == Mode::kWait && !h.state_seen;
      CHECK((after == Mode::kWait) == waits_on);
      if (waits_on) continue;
      const bool must_stop = !h.state_good || h.stop || (mode == Mode::kStop && !h.recover);
      CHECK((after == Mode::kStop) == must_stop);
      if (must_stop) continue;
      CHECK((after == Mode::kTrack) == (h.plan_good && h.robot_moves));
    }
  }
}

TEST_CASE("controller: it waits until a robot state was seen, even with a plan at hand") {
  Controller controller = make(parameters());
  Input input = with_plan(kMs);
  input.has_state = false;
  const Output output = controller.step(input);
  CHECK(output.mode == Mode::kWait);
  CHECK(output.tau == Vector7d::Zero());
}

TEST_CASE(
    "controller: without any plan it holds the pose in which it found the arm, and comes back to "
    "it") {
  Loop loop(parameters());
  for (int k = 1; k <= 200; ++k) REQUIRE(loop.step(at(k * kMs)).mode == Mode::kHold);
  // a push of 8 N for 100 ms
  for (int k = 201; k <= 300; ++k) {
    loop.external = loop.state.J_WE.topRows<3>().transpose() * Vector3d(0, 8, 0);
    loop.step(at(k * kMs));
  }
  CHECK((loop.state.X_WE.translation() - kStart).norm() > 1e-3);
  loop.external.setZero();
  for (int k = 301; k <= 1300; ++k) loop.step(at(k * kMs));
  CHECK((loop.state.X_WE.translation() - kStart).norm() < 2e-4);
  CHECK(loop.state.V_WE.norm() < 1e-3);
}

TEST_CASE("controller: it reaches a plan's position and orientation") {
  Loop loop(parameters());
  const Vector3d goal(0.57, 0.05, 0.10);
  const Quaterniond tilted = Quaterniond(Eigen::AngleAxisd(0.1, Vector3d::UnitY())) * kDown;
  Output output{};
  for (int k = 1; k <= 1500; ++k) {
    Input input = with_plan(k * kMs, goal);
    input.plan.knots[0].q_WE = tilted;
    output = loop.step(input);
    REQUIRE(output.mode == Mode::kTrack);
  }
  CHECK((output.p_WE_desired - goal).norm() < 1e-12);
  CHECK((loop.state.X_WE.translation() - goal).norm() < 1e-4);
  CHECK(Quaterniond(loop.state.X_WE.linear()).angularDistance(tilted) < 1e-3);
}

TEST_CASE("controller: it follows a point that moves at 0.1 m/s to within half a millimetre") {
  // e settles where K e + B e' = acceleration of the reference - J' dq, here of the order of 0.05
  // m/s^2: 0.1 mm
  for (const Reference reference : {Reference::kHold, Reference::kInterpolate}) {
    Parameters p = parameters();
    p.reference = reference;
    Loop loop(p);
    const Vector3d velocity(0, 0.1, 0);
    double worst = 0;
    std::int64_t stamp = 0;
    for (int k = 1; k <= 1000; ++k) {
      Input input = at(k * kMs);
      if (k % 13 == 1) stamp = input.now_ns;  // a plan every 13 ms, for the point 13 ms ahead
      give_plan(input, kStart + velocity * (static_cast<double>(stamp) * 1e-9 + 0.013), stamp);
      input.plan.knots[0].v_WE = velocity;
      input.plan.knots[0].time_ns = stamp + 13 * kMs;
      loop.step(input);
      // the plan in `hold` is ahead by up to one period, on average by half
      const double ahead = reference == Reference::kHold ? 0.0065 : 0.0;
      const Vector3d point = kStart + velocity * (k * 1e-3 + ahead);
      if (k > 300) worst = std::max(worst, (loop.state.X_WE.translation() - point).norm());
    }
    CHECK(worst < 5e-4);
  }
}

TEST_CASE(
    "controller: interpolation moves with v_d to x_d at its knot's time and rests "
    "there") {
  Parameters p = parameters();
  p.reference = Reference::kInterpolate;
  p.limits.plan_acceleration = 1e4;  // v_d as it comes
  Controller controller = make(p);
  controller.step(with_plan(kMs));
  const std::int64_t plan_ns = 2 * kMs;
  for (int k = 0; k <= 30; ++k) {
    Input input = at(plan_ns + k * kMs);
    give_plan(input, kStart + Vector3d(0, 2e-3, 0), plan_ns);
    input.plan.knots[0].v_WE << 0, 0.1, 0;
    input.plan.knots[0].time_ns = plan_ns + 20 * kMs;  // so the way starts where the arm is
    const Output output = controller.step(input);
    const bool arrived = k >= 20;
    CHECK(output.p_WE_desired.y() == Approx(arrived ? 2e-3 : 1e-4 * k).margin(1e-6));
    CHECK(output.v_WE_desired.y() == (arrived ? 0.0 : 0.1));
  }
}

TEST_CASE("controller: a plan of several knots is followed through all of them by one plan") {
  Parameters p = parameters();
  p.limits.plan_acceleration = 1e4;  // v_d as it comes
  Controller controller = make(p);
  controller.step(with_plan(kMs));
  // a slow planner: half a second of a straight line at constant speed, in five knots
  const std::int64_t plan_ns = 2 * kMs;
  const Vector3d velocity(0, 0.02, 0);
  for (int k = 0; k <= 120; ++k) {
    Input input = at(plan_ns + k * kMs);
    give_plan(input, kStart, plan_ns);
    input.plan.valid_until_ns = plan_ns + 500 * kMs;
    input.plan.knot_count = 5;
    for (int i = 0; i < 5; ++i) {
      Knot& knot = input.plan.knots[static_cast<std::size_t>(i)];
      knot = input.plan.knots[0];
      knot.time_ns = plan_ns + 25 * i * kMs;
      knot.v_WE = velocity;
      knot.p_WE = kStart + velocity * 0.025 * i;
    }
    const Output output = controller.step(input);
    REQUIRE(output.mode == Mode::kTrack);
    const bool over = k >= 100;  // then it holds the last position
    CHECK(output.p_WE_desired.y() == Approx(kStart.y() + (over ? 0.002 : 2e-5 * k)).margin(1e-6));
    CHECK(output.v_WE_desired.y() == Approx(over ? 0.0 : 0.02).margin(1e-9));
  }
}

TEST_CASE("controller: a stale plan makes it hold where it is and say so; a new plan takes it on") {
  Controller controller = make(parameters());
  const Vector3d goal = kStart + Vector3d(0, 0.05, 0);
  REQUIRE(controller.step(with_plan(1 * kMs, goal)).mode == Mode::kTrack);

  Input input = at(101 * kMs);
  give_plan(input, goal, 1 * kMs);  // valid until 101 ms
  REQUIRE(controller.step(input).mode == Mode::kTrack);
  input.now_ns = input.state_stamp_ns = 102 * kMs;
  Output output = controller.step(input);
  CHECK(output.mode == Mode::kHold);
  CHECK(output.counters.stale_plan_events == 1);
  CHECK(output.v_WE_desired == Vector3d::Zero());
  // the pose to hold is where the arm is, not where the plan wanted it
  for (int k = 103; k < 300; ++k) output = controller.step(at(k * kMs));
  CHECK((output.p_WE_desired - kStart).norm() < 1e-4);
  CHECK(output.counters.stale_plan_events == 1);

  CHECK(controller.step(with_plan(300 * kMs, goal)).mode == Mode::kTrack);
}

TEST_CASE(
    "controller: a plan older than the controller's own limit is stale, whatever its valid_until "
    "says") {
  Controller controller = make(parameters());
  Input input = at(301 * kMs);
  give_plan(input, kStart, 100 * kMs);
  input.plan.valid_until_ns = std::numeric_limits<std::int64_t>::max();
  CHECK(controller.step(input).mode == Mode::kHold);
}

TEST_CASE("controller: neither position nor torque jump when a far plan or a large force appears") {
  Parameters p = parameters();
  Controller controller = make(p);
  Output before = controller.step(at(kMs));
  for (int k = 2; k < 300; ++k) {
    Input input = with_plan(k * kMs, kStart + Vector3d(0, -0.2, 0.1));
    if (k > 150) input.plan.knots[0].force_E << 0, 0, 40;  // up to 20 N m at once
    const Output output = controller.step(input);
    CHECK((output.p_WE_desired - before.p_WE_desired).norm() <= 0.5e-3 + 1e-12);
    CHECK((output.tau - before.tau).cwiseAbs().maxCoeff() <= 1.0 + 1e-12);
    CHECK((output.tau.array().abs() <= p.limits.tau_max.array()).all());
    before = output;
  }
  CHECK(before.counters.plan_clamps > 0);
}

TEST_CASE("controller: the orientation to track turns at most at its limit") {
  Parameters p = parameters();
  p.limits.lead_angular_acceleration = 1e4;  // the arm does not follow here
  Controller controller = make(p);
  Quaterniond before = controller.step(at(kMs)).q_WE_desired;
  const Quaterniond tilted = Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitX())) * kDown;
  for (int k = 2; k < 700; ++k) {
    Input input = with_plan(k * kMs);
    input.plan.knots[0].q_WE = tilted;
    const Quaterniond now = controller.step(input).q_WE_desired;
    REQUIRE(now.angularDistance(before) <= 0.5e-3 + 1e-7);
    before = now;
  }
  CHECK(before.angularDistance(tilted) < 1e-7);
}

TEST_CASE(
    "controller: it never acts on a plan of another session or on one that was never received") {
  Controller controller = make(parameters());
  Input never = with_plan(kMs, kStart + Vector3d(0, 0.1, 0));
  never.has_plan = false;
  CHECK(controller.step(never).mode == Mode::kHold);

  for (const std::uint64_t session : {kSession - 1, kSession + 1, std::uint64_t{0}}) {
    Input input =
        with_plan(static_cast<std::int64_t>(2 + session) * kMs, kStart + Vector3d(0, 0.1, 0));
    input.plan.session_id = session;
    const Output output = controller.step(input);
    CHECK(output.mode == Mode::kHold);
    CHECK((output.p_WE_desired - kStart).norm() < 1e-4);
  }
  CHECK(controller.step(with_plan(100 * kMs)).counters.plans_other_session == 3);
  // positive control: the very same plan, of this session
  CHECK(controller.step(with_plan(101 * kMs)).mode == Mode::kTrack);
}

TEST_CASE(
    "controller: a plan with NaN, an unknown status or no orientation is refused and counted "
    "once") {
  const auto refused = [](auto&& spoil) {
    Controller controller = make(parameters());
    controller.step(with_plan(kMs));
    Input input = with_plan(2 * kMs);
    spoil(input.plan);
    Output output = controller.step(input);
    input.now_ns = input.state_stamp_ns = 3 * kMs;
    output = controller.step(input);  // the same plan again
    return output.mode == Mode::kHold && output.tau.allFinite() &&
           output.counters.plans_invalid == 1;
  };
  CHECK(refused([](Plan& plan) { plan.knots[0].p_WE.y() = kNan; }));
  CHECK(refused([](Plan& plan) { plan.knots[0].v_WE.z() = kNan; }));
  CHECK(refused([](Plan& plan) { plan.knots[0].q_WE.x() = kNan; }));
  CHECK(refused([](Plan& plan) { plan.knots[0].force_E.x() = kNan; }));
  CHECK(refused([](Plan& plan) { plan.knot_count = 0; }));
  CHECK(refused([](Plan& plan) { plan.knot_count = kMaxKnots + 1; }));
  CHECK(refused([](Plan& plan) { plan.knot_count = 2; }));  // at the same time
  CHECK(refused(
      [](Plan& plan) { plan.knots[0].p_WE.x() = std::numeric_limits<double>::infinity(); }));
  CHECK(refused([](Plan& plan) { plan.knots[0].q_WE.coeffs().setZero(); }));
  CHECK(refused([](Plan& plan) { plan.status = PlanStatus::kUnknown; }));
  CHECK_FALSE(refused([](Plan&) {}));
}

TEST_CASE("controller: a truncated plan is a plan; a fallback is tracked without its force") {
  const auto first_torque = [](PlanStatus status) {
    Controller controller = make(parameters());
    Input input = with_plan(kMs);
    input.plan.status = status;
    input.plan.knots[0].force_E << 0.2, 0, 0;
    const Output output = controller.step(input);
    CHECK(output.mode == Mode::kTrack);
    return output.tau;
  };
  const Vector7d ok = first_torque(PlanStatus::kOk);
  CHECK(ok == first_torque(PlanStatus::kTruncated));
  CHECK((ok - first_torque(PlanStatus::kFallback)).norm() > 0.01);
}

TEST_CASE(
    "controller: feed-forward is -J_v^T f, can be switched off, and ignores what is below the "
    "threshold") {
  const auto first_torque = [](bool on, const Vector3d& force) {
    Parameters p = parameters();
    p.feed_forward = on;
    p.limits.tau_rate_max = 1e6;  // the first cycle's torque, not the first step towards it
    Controller controller = make(p);
    Input input = with_plan(kMs);
    input.plan.knots[0].force_E = force;
    const Output output = controller.step(input);
    return std::make_pair(output.tau, controller.arm());
  };
  const Vector3d force(1, -2, 3);
  const auto [with, arm] = first_torque(true, force);
  const Vector7d without = first_torque(true, Vector3d::Zero()).first;
  CHECK((with - without + arm.J_WE.topRows<3>().transpose() * force).norm() < 1e-9);
  CHECK(first_torque(false, force).first == without);
  CHECK(first_torque(true, Vector3d(0.009, 0, 0)).first == without);
}

TEST_CASE("controller: a plan outside the workspace is tracked at the box's wall and counted") {
  Parameters p = parameters();
  p.limits.lead_acceleration = 1e4;  // the arm does not follow here
  Controller controller = make(p);
  Output output{};
  for (int k = 1; k <= 500; ++k) {
    Input input = with_plan(k * kMs, Vector3d(0.6, 0.05, -0.2));
    input.plan.knots[0].v_WE << 0.01, 0, -0.1;
    output = controller.step(input);
  }
  CHECK((output.p_WE_desired - Vector3d(0.6, 0.05, 0.0)).norm() < 1e-12);
  CHECK(output.v_WE_desired == Vector3d(0.01, 0, 0));  // not on into the wall
  CHECK(output.counters.workspace_clamps == 500);
}

TEST_CASE(
    "controller: a stale, not finite or forbidden robot state stops it until a person recovers") {
  const auto stops = [](auto&& spoil, StopReason reason) {
    Controller controller = make(parameters());
    controller.step(with_plan(kMs));
    Input input = with_plan(200 * kMs);
    spoil(input);
    Output output = controller.step(input);
    if (reason == StopReason::kStateStale) {
      for (int k = 1; k < kPatience; ++k) output = controller.step(input);
      CHECK(output.mode == Mode::kTrack);
      output = controller.step(input);
    }
    CHECK(output.mode == Mode::kStop);
    CHECK(output.stop_reason == reason);
    CHECK(output.tau.allFinite());
    CHECK(output.counters.stops == 1);
    // a good state and a good plan alone do not end it
    for (int k = 201; k < 220; ++k) output = controller.step(with_plan(k * kMs));
    CHECK(output.mode == Mode::kStop);
    CHECK(output.stop_reason == reason);
    // and a recovery with a bad state neither
    if (reason != StopReason::kStateStale) {
      input.recover = true;
      CHECK(controller.step(input).mode == Mode::kStop);
    }
    Input good = with_plan(220 * kMs);
    good.recover = true;
    output = controller.step(good);
    CHECK(output.mode == Mode::kTrack);
    CHECK(output.stop_reason == StopReason::kNone);
  };
  stops([](Input& input) { input.state_stamp_ns = 99 * kMs; }, StopReason::kStateStale);
  stops([](Input& input) { input.q[3] = kNan; }, StopReason::kStateNotFinite);
  stops([](Input& input) { input.dq[0] = kNan; }, StopReason::kStateNotFinite);
  stops([](Input& input) { input.q[1] = 1.77; }, StopReason::kJointPosition);
  stops([](Input& input) { input.q[3] = 0.0; }, StopReason::kJointPosition);
  stops([](Input& input) { input.dq[6] = -2.7; }, StopReason::kJointVelocity);
  stops([](Input& input) { input.stop = true; }, StopReason::kRequested);
}

TEST_CASE(
    "controller: a pause of the whole machine, after which one old state is at hand, is no reason "
    "to stop") {
  Controller controller = make(parameters());
  Input input = with_plan(kMs);
  controller.step(input);
  input.now_ns = 500 * kMs;  // woken before the robot's state of now has come
  CHECK(controller.step(input).mode == Mode::kHold);  // the plan is too old, too
  CHECK(controller.step(with_plan(501 * kMs)).mode == Mode::kTrack);
}

TEST_CASE("controller: a stop brakes the moving arm, with or without a plan") {
  Loop loop(parameters());
  for (int k = 1; k <= 200; ++k) {
    Input input = with_plan(k * kMs, kStart + Vector3d(0, 0.3 * k * 1e-3, 0));
    input.plan.knots[0].v_WE << 0, 0.3, 0;
    loop.step(input);
  }
  const double energy = loop.dq.dot(loop.state.M * loop.dq);
  REQUIRE(loop.state.V_WE.head<3>().norm() > 0.25);
  Input stop = with_plan(201 * kMs, kStart);
  stop.stop = true;
  REQUIRE(loop.step(stop).mode == Mode::kStop);
  for (int k = 202; k <= 700; ++k)
    REQUIRE(loop.step(with_plan(k * kMs, kStart)).mode == Mode::kStop);
  // 0.5 s at 10 / s: exp(-2 * 5) of the energy is left, plus what the torque's ramp cost
  CHECK(loop.dq.dot(loop.state.M * loop.dq) < 1e-3 * energy);
}

TEST_CASE(
    "controller: after states that were missing the arm is brought to rest before it goes on") {
  Loop loop(parameters());
  const auto plan = [](int k) {
    Input input = with_plan(k * kMs, kStart + Vector3d(0, 0.2 * k * 1e-3, 0));
    input.plan.knots[0].v_WE << 0, 0.2, 0;
    return input;
  };
  int k = 1;
  for (; k <= 200; ++k) loop.step(plan(k));
  const std::int64_t last = 200 * kMs;
  for (; k <= 260; ++k) {
    Input input = plan(k);
    input.state_stamp_ns = last;
    loop.step(input);
  }
  // it coasts; the reference begins where the arm is, and stays there
  REQUIRE(loop.state.V_WE.head<3>().norm() > 0.1);
  int braking = 0;
  const auto begins_at_the_arm = [&] {
    const Vector3d p_WE = loop.state.X_WE.translation();  // that the step begins with
    return loop.step(plan(k++)).p_WE_desired == p_WE;
  };
  while (begins_at_the_arm()) {
    ++braking;
    REQUIRE(braking < 1000);
  }
  CHECK(braking > 10);
  const Limits limits = parameters().limits;
  CHECK((loop.dq.array().abs() / limits.dq_max.array()).maxCoeff() < 0.11);
  for (int i = 0; i < 500; ++i) loop.step(plan(k++));
  CHECK(loop.state.V_WE.y() > 0.1);  // and goes on
}

TEST_CASE("controller: without a usable state the torque fades to zero") {
  Controller controller = make(parameters());
  Output output{};
  for (int k = 1; k <= 100; ++k)
    output = controller.step(with_plan(k * kMs, kStart + Vector3d(0.05, 0, 0.1)));
  REQUIRE(output.tau.norm() > 5);
  for (int k = 1; k <= 200; ++k) {
    const double before = output.tau.norm();
    Input old = with_plan((100 + k) * kMs);
    old.state_stamp_ns = 100 * kMs;
    output = controller.step(old);
    // at first it stays as it was; long before the controller stops it fades
    if (k > 2 && k <= kPatience) CHECK(output.tau.norm() == before);
    if (k > kPatience) CHECK(output.tau.norm() <= before);
    if (k == 3 * kPatience) CHECK(output.tau == Vector7d::Zero());
    CHECK((output.mode == Mode::kStop) == (k > 100 + kPatience));
    // and then the robot stops the arm by itself
    CHECK(output.commands == (output.mode != Mode::kStop));
  }
  CHECK(controller.step(with_plan(301 * kMs)).commands);
}

TEST_CASE(
    "controller: while the robot takes no commands the pose to hold goes where the robot is") {
  Controller controller = make(parameters());
  Input input = with_plan(kMs);
  input.robot_moves = false;
  CHECK(controller.step(input).mode == Mode::kHold);
  input.q[0] += 0.3;  // moved by hand
  input.now_ns = input.state_stamp_ns = 2 * kMs;
  controller.step(input);
  Input back = at(3 * kMs);
  back.q = input.q;
  const Output output = controller.step(back);
  CHECK(output.mode == Mode::kHold);
  CHECK((output.p_WE_desired - controller.arm().X_WE.translation()).norm() < 1e-12);
}

TEST_CASE(
    "controller: an arm that gets its torques late is braked, and goes on when they are in time") {
  const int delay = GENERATE(4, 5, 8, 17, 40);
  CAPTURE(delay);
  const Parameters p = parameters();
  Loop loop(p);
  std::int64_t now = 0;
  double fastest = 0.0;
  const auto run = [&](int cycles) {
    for (int i = 0; i < cycles; ++i) {
      now += kMs;
      // to and fro by 4 cm, at 0.13 m/s at most
      const double angle = 2e-9 * M_PI * 0.5 * static_cast<double>(now);
      loop.step(with_plan(now, kStart + Vector3d(0.04 * std::sin(angle), 0, 0)));
      fastest = std::max(fastest, (loop.dq.array().abs() / p.limits.dq_max.array()).maxCoeff());
    }
  };
  loop.delay = 0;
  run(1000);
  CHECK(fastest < 0.3);
  loop.delay = delay;
  run(2000);
  CHECK(fastest < 0.5);
  CHECK(loop.dq.cwiseAbs().maxCoeff() < 0.02);
  loop.delay = 0;
  run(1000);
  CHECK(fastest < 0.5);
  const double angle = 2e-9 * M_PI * 0.5 * static_cast<double>(now);
  CHECK((loop.state.X_WE.translation() - kStart - Vector3d(0.04 * std::sin(angle), 0, 0)).norm() <
        0.015);
}

TEST_CASE("controller: an arm whose states come late is braked, however late up to their timeout") {
  const int delay = GENERATE(4, 15, 19, 21, 24, 40, 70, 95);
  CAPTURE(delay);
  const Parameters p = parameters();
  REQUIRE(delay * 1e-3 < p.limits.state_timeout);
  Loop loop(p);
  loop.delay = 0;
  std::int64_t now = 0;
  const auto run = [&](int cycles) {
    for (int i = 0; i < cycles; ++i) {
      now += kMs;
      const double angle = 2e-9 * M_PI * 0.5 * static_cast<double>(now);
      loop.step(with_plan(now, kStart + Vector3d(0.04 * std::sin(angle), 0, 0)));
    }
  };
  run(2000);
  const Vector3d there = loop.state.X_WE.translation();
  REQUIRE(loop.dq.norm() > 0.1);
  loop.state_delay = delay;
  run(2000);
  CHECK(loop.dq.cwiseAbs().maxCoeff() < 0.02);
  // it coasts for as long as nobody knows better, and for as long as damping takes
  CHECK((loop.state.X_WE.translation() - there).norm() < 0.06);
  loop.state_delay = 0;
  run(1000);
  const double angle = 2e-9 * M_PI * 0.5 * static_cast<double>(now);
  CHECK((loop.state.X_WE.translation() - kStart - Vector3d(0.04 * std::sin(angle), 0, 0)).norm() <
        0.015);
}

TEST_CASE("controller: nineteen commands that are lost now and then do not make the loop late") {
  Loop loop(parameters());
  std::int64_t now = 0;
  Output output{};
  for (int i = 0; i < 3000; ++i) {
    now += kMs;
    // the robot goes on with the command that it has
    Input input = with_plan(now);
    const int since = i % 500;
    input.answered_ns = now - (since < 19 ? since + 2 : 1) * kMs;
    output = loop.step(input);
  }
  CHECK(output.counters.late_loops == 0);
}

TEST_CASE("controller: commands that begin to come late are known at the second one") {
  const int delay = GENERATE(3, 8, 12, 19);  // [cycles]
  CAPTURE(delay);
  Controller controller = make(parameters());
  std::int64_t now = 0, answered = 0;
  const auto late_loops = [&](std::int64_t behind) {
    now += kMs;
    Input input = with_plan(now);
    input.answered_ns = answered = std::max(answered, now - behind * kMs);
    return controller.step(input).counters.late_loops;
  };
  for (int i = 0; i < 500; ++i) REQUIRE(late_loops(1) == 0);
  int cycles = 0;
  while (late_loops(delay) == 0 && cycles < 500) ++cycles;
  // until the first one comes, and one more; a delay that the law bears never
  CHECK(cycles == (delay == 3 ? 500 : delay));
}

TEST_CASE("controller: where most commands are lost that is known within the second gap") {
  const int gap = GENERATE(4, 7, 12, 17);  // [cycles]
  CAPTURE(gap);
  Controller controller = make(parameters());
  std::int64_t now = 0, answered = 0;
  const auto late_loops = [&](int of) {
    now += kMs;
    Input input = with_plan(now);
    if (of == 0) answered = now - kMs;
    input.answered_ns = answered;
    return controller.step(input).counters.late_loops;
  };
  for (int i = 0; i < 500; ++i) REQUIRE(late_loops(0) == 0);
  for (int i = 1; i <= gap; ++i) CHECK(late_loops(i % gap) == 0);
  int cycles = 0;
  while (late_loops(++cycles % gap) == 0 && cycles < 500) continue;
  // gaps of 4 make the average tell, as before
  CHECK(cycles <= (gap == 4 ? 200 : 7));
}

TEST_CASE("controller: of an arm that swings, a delay that a calm arm bears is too late") {
  const int age = GENERATE(1, 3);  // of the newest command that the robot has [cycles]
  CAPTURE(age);
  Controller controller = make(parameters());
  std::int64_t now = 0;
  Output output{};
  const auto run = [&](int cycles, double wrist) {
    for (int i = 0; i < cycles; ++i) {
      now += kMs;
      Input input = with_plan(now);
      input.answered_ns = now - age * kMs;
      input.dq[5] = wrist;
      output = controller.step(input);
    }
    return output.counters.late_loops;
  };
  CHECK(run(500, 0.5) == 0);  // rad/s, of 2.61
  CHECK(run(50, 1.0) == (age == 1 ? 0 : 1));
  if (age == 1) return;
  // braked, by damping alone
  Input input = at(now);
  input.dq[5] = 1.0;
  model::Arm arm(test::panda_arm());
  ArmState state;
  arm.update(input.q, input.dq, state);
  CHECK((output.tau + parameters().limits.stop_damping * (state.M * input.dq)).norm() < 1e-9);
}

TEST_CASE("controller: a robot of a new session is met from scratch") {
  Controller controller = make(parameters());
  Input input = with_plan(kMs);
  input.stop = true;
  REQUIRE(controller.step(input).mode == Mode::kStop);
  Input fresh = at(2 * kMs);
  fresh.session_id = kSession + 1;
  fresh.q[0] = 0.5;
  give_plan(fresh, kStart, 2 * kMs);  // still of the old session
  const Output output = controller.step(fresh);
  CHECK(output.mode == Mode::kHold);
  CHECK((output.p_WE_desired - controller.arm().X_WE.translation()).norm() < 1e-12);
}

TEST_CASE("controller: whatever numbers arrive, the torque is finite and within the limits") {
  const Parameters p = parameters();
  Controller controller = make(p);
  const double bad[] = {kNan, std::numeric_limits<double>::infinity(), 1e300, -1e300, 0.0};
  std::int64_t now = kMs;
  Vector7d before = Vector7d::Zero();
  for (const double a : bad) {
    for (const double b : bad) {
      for (int field = 0; field < 5; ++field) {
        Input input = with_plan(now += kMs);
        input.recover = true;
        input.plan.knots[0].p_WE.x() = a;
        if (field == 0) input.q[2] = b;
        if (field == 1) input.dq[2] = b;
        if (field == 2) input.plan.knots[0].v_WE.z() = b;
        if (field == 3) input.plan.knots[0].force_E.y() = b;
        if (field == 4) input.plan.knots[0].q_WE.x() = b;
        const Output output = controller.step(input);
        REQUIRE(output.tau.allFinite());
        REQUIRE((output.tau.array().abs() <= p.limits.tau_max.array()).all());
        REQUIRE((output.tau - before).cwiseAbs().maxCoeff() <= 1.0 + 1e-12);
        before = output.tau;
      }
    }
  }
}

TEST_CASE(
    "controller: whatever a plan asks, the reference never leads the arm by more than its limit") {
  const Parameters p = parameters();
  const double farthest = p.limits.lead_acceleration / p.gains.stiffness[0];
  const double jumps[] = {0.005, 0.02, 0.1, 1.0};
  for (const double jump : jumps) {
    CAPTURE(jump);
    Loop loop(p);
    Vector3d v_before = Vector3d::Zero();
    for (int k = 1; k <= 1500; ++k) {
      const int half = k / 150;
      Input input = with_plan(k * kMs, kStart + Vector3d(0, half % 2 == 0 ? jump : -jump, 0));
      input.plan.knots[0].v_WE << 0, half % 2 == 0 ? 5.0 : -5.0, 0;
      const Vector3d here = loop.state.X_WE.translation();
      const Output output = loop.step(input);
      if (k == 1) v_before = output.v_WE_desired;  // before it the loop has no state
      if (k == 1) continue;
      REQUIRE((output.p_WE_desired - here).norm() <= farthest + 1e-12);
      REQUIRE(output.v_WE_desired.norm() <= p.limits.plan_speed + 1e-12);
      REQUIRE((output.v_WE_desired - v_before).norm() <=
              p.limits.plan_acceleration * p.period + 1e-12);
      REQUIRE((loop.dq.array().abs() < 0.9 * p.limits.dq_max.array()).all());
      v_before = output.v_WE_desired;
    }
  }
}

TEST_CASE("controller: ordinary plans are tracked as they are") {
  // a point that moves at 0.15 m/s, of which a plan every 5 ms tells the next place and velocity
  Loop loop(parameters());
  Output output{};
  Input input = with_plan(kMs);
  for (int k = 1; k <= 500; ++k) {
    if (k % 5 == 1) {
      const Vector3d v(0, 0.15 * std::min(1.0, k / 50.0), 0);
      give_plan(input, (k > 1 ? Vector3d(loop.state.X_WE.translation()) : kStart) + 0.005 * v,
                k * kMs);
      input.plan.knots[0].v_WE = v;
      input.plan.knots[0].force_E << 0, 0.3, -0.5;
    }
    input.now_ns = input.state_stamp_ns = k * kMs;
    output = loop.step(input);
  }
  CHECK(output.counters.plan_clamps == 0);
  CHECK(loop.state.V_WE[1] == Approx(0.15).margin(0.02));
}

TEST_CASE(
    "controller: after cycles or states that were missing the reference begins where the arm is") {
  for (const bool state : {false, true}) {
    CAPTURE(state);
    Controller controller = make(parameters());
    Output output{};
    for (int k = 1; k <= 100; ++k)
      output = controller.step(with_plan(k * kMs, kStart + Vector3d(0, 0.05, 0)));
    REQUIRE((output.p_WE_desired - kStart).norm() > 5e-3);
    if (state) {
      Input old = with_plan(300 * kMs, kStart);
      old.state_stamp_ns = 100 * kMs;
      output = controller.step(old);
    }
    Input back = with_plan(301 * kMs, kStart + Vector3d(0, 0.05, 0));
    back.q[0] = 0.1;
    output = controller.step(back);
    CHECK(output.mode == Mode::kTrack);
    // one cycle's step from it
    CHECK((output.p_WE_desired - controller.arm().X_WE.translation()).norm() < 0.6e-3);
    CHECK(output.v_WE_desired.norm() < 0.03);
  }
}

TEST_CASE(
    "controller: a state that was missing is forgiven once it comes steadily, if the scenario says "
    "so") {
  for (const bool alone : {false, true}) {
    CAPTURE(alone);
    Parameters p = parameters();
    p.recovers_alone = alone;
    Controller controller = make(p);
    controller.step(with_plan(kMs));
    Input missing = with_plan(200 * kMs);
    missing.state_stamp_ns = kMs;
    for (int k = 0; k <= kPatience; ++k)
      REQUIRE(controller.step(missing).counters.stops == (k == kPatience));
    Output output{};
    for (int k = 1; k < kGoodStates; ++k) output = controller.step(with_plan((200 + k) * kMs));
    CHECK(output.mode == Mode::kStop);
    for (int k = 0; k < 2; ++k) output = controller.step(with_plan((200 + kGoodStates + k) * kMs));
    CHECK((output.mode == Mode::kTrack) == alone);
    // but not a person's stop
    Input stop = with_plan(500 * kMs);
    stop.stop = true;
    controller.step(stop);
    for (int k = 1; k < 2 * kGoodStates; ++k) output = controller.step(with_plan((500 + k) * kMs));
    CHECK(output.mode == Mode::kStop);
  }
}

TEST_CASE("controller: a plan that no planner can mean is refused, one that asks too much is cut") {
  const auto verdict = [](auto&& spoil) {
    Controller controller = make(parameters());
    Input input = with_plan(kMs);
    spoil(input.plan);
    return controller.step(input).plan;
  };
  CHECK(verdict([](Plan& plan) { plan.knots[0].force_E << 0, 0, 1e9; }) == PlanVerdict::kInvalid);
  CHECK(verdict([](Plan& plan) { plan.knots[0].force_E << 0, 0, -500; }) == PlanVerdict::kInvalid);
  CHECK(verdict([](Plan& plan) { plan.knots[0].v_WE << 1e6, 0, 0; }) == PlanVerdict::kInvalid);
  CHECK(verdict([](Plan& plan) { plan.knots[0].p_WE << 1e300, 0, 0; }) == PlanVerdict::kInvalid);
  CHECK(verdict([](Plan& plan) { plan.knots[0].time_ns += 100'000 * kMs; }) ==
        PlanVerdict::kInvalid);
  CHECK(verdict([](Plan& plan) { plan.knots[0].force_E << 0, 0, -100; }) == PlanVerdict::kGood);
  CHECK(verdict([](Plan& plan) { plan.knots[0].v_WE << 5, 0, 0; }) == PlanVerdict::kGood);
}

TEST_CASE("controller: the same inputs give the same bits") {
  Controller first = make(parameters()), second = make(parameters());
  for (int k = 1; k < 200; ++k) {
    const Input input =
        with_plan(k * kMs, kStart + Vector3d(0.01 * std::sin(0.1 * k), 0.001 * k, 0));
    REQUIRE(first.step(input).tau == second.step(input).tau);
  }
}

TEST_CASE("controller: step does not allocate, in any mode") {
  Controller controller = make(parameters());
  std::int64_t heap_calls = 0;
  int modes[4] = {};
  {
    const support::AllocationCounter heap;
    for (int k = 0; k < 400; ++k) {
      Input input = k < 200 ? with_plan(k * kMs, kStart + Vector3d(0.1, 0.1, -0.5)) : at(k * kMs);
      if (k < 10) input.has_state = false;
      if (k > 300) input.q[0] = kNan;
      if (k == 350) input.stop = true;
      ++modes[static_cast<int>(controller.step(input).mode)];
    }
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
  for (const int cycles : modes) CHECK(cycles > 0);
}

}  // namespace
