// The process c3rt-impedance on a real bus, with this test as its plant and planner.
#include "idl/process.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <unistd.h>

#include "controller/model/arm.hpp"
#include "tests/idl/bus_fixture.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/panda.hpp"

using namespace c3rt;

namespace {

using model::Vector7d;
using wire::test::eventually;
using wire::test::kDomain;
using wire::test::kMs;
using wire::test::kSecond;

const std::string kScenario = C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml";

struct Child : test::ChildProcess {
  explicit Child(const std::vector<std::string>& more)
      : ChildProcess(test::process_command("c3rt-impedance", kScenario, kDomain, more)) {}
};

/// The exact arm under the commands of a lockstep run, and a planner that leads it along a circle
/// of 0.05 m at 75 Hz.
class Run {
 public:
  explicit Run(const std::vector<std::string>& more)
      : child_(more),
        bus_(wire::test::settings(wire::ClockMode::kLockstep, wire::draw_session())),
        states_(bus_),
        plans_(bus_),
        commands_(bus_),
        master_(bus_, {c3rt_v2_PROCESS_IMPEDANCE}, 30 * kSecond),
        arm_(test::panda_arm()) {
    q_ << 0, 0.275, 0, -2.222, 0, 2.497, 0;
    arm_.update(q_, dq_, arm_state_);
    center_ = arm_state_.X_WE.translation() - Eigen::Vector3d(kRadius, 0, 0);
  }

  void step() {
    now_ns_ += kMs;
    wire::RobotState state{};
    Eigen::Map<Vector7d>{state.q_rad} = q_;
    Eigen::Map<Vector7d>{state.dq_rad_per_s} = dq_;
    state.mode = c3rt_v2_ROBOT_MOVE;
    states_.write(state, now_ns_);
    if (now_ns_ >= next_plan_ns_) {
      next_plan_ns_ = now_ns_ + kPlanPeriod;
      write_plan();
    }
    REQUIRE(master_.advance(now_ns_));
    while (commands_.take(command_)) {
      tau_ = Eigen::Map<Vector7d>{command_.tau_nm};
      torques_.push_back(tau_);
    }
    for (int i = 0; i < 4; ++i) {
      arm_.update(q_, dq_, arm_state_);
      dq_ += 0.25e-3 * support::solve_definite(arm_state_.M, tau_ - arm_state_.coriolis);
      q_ += 0.25e-3 * dq_;
    }
    arm_.update(q_, dq_, arm_state_);
  }

  double tracking_error() const {
    return (Eigen::Map<const Eigen::Vector3d>(command_.p_WE_desired_m) -
            arm_state_.X_WE.translation())
        .norm();
  }
  double distance_to_circle() const {
    const Eigen::Vector3d r = arm_state_.X_WE.translation() - center_;
    return std::hypot(std::hypot(r.x(), r.y()) - kRadius, r.z());
  }
  const wire::RobotCommand& command() const { return command_; }
  const std::vector<Vector7d>& torques() const { return torques_; }
  void stop_planning() { next_plan_ns_ = INT64_MAX; }
  int end() {
    child_.signal(SIGTERM);
    return child_.wait();
  }

 private:
  static constexpr std::int64_t kPlanPeriod = 13 * kMs;
  static constexpr double kRadius = 0.05, kRate = 2.0;  // 0.1 m/s

  void write_plan() {
    const double t = static_cast<double>(now_ns_ + kPlanPeriod) * 1e-9, angle = kRate * t;
    wire::Plan plan{};
    plan.valid_until_ns = now_ns_ + 100 * kMs;
    const Eigen::Vector3d p =
        center_ + kRadius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    plan.knot_count = 1;
    Eigen::Map<Eigen::Vector3d>{plan.knots[0].p_WE_m} = p;
    Eigen::Map<Eigen::Vector3d>{plan.knots[0].v_WE_m_per_s} =
        kRate * kRadius * Eigen::Vector3d(-std::sin(angle), std::cos(angle), 0);
    plan.knots[0].q_WE[1] = 1;  // pointing down
    plan.knots[0].time_ns = now_ns_ + kPlanPeriod;
    plans_.write(plan, now_ns_);
  }

  Child child_;
  wire::Bus bus_;
  wire::Writer<wire::RobotState> states_;
  wire::Writer<wire::Plan> plans_;
  wire::Reader<wire::RobotCommand> commands_;
  wire::LockstepMaster master_;
  model::Arm arm_;
  model::ArmState arm_state_;
  Vector7d q_, dq_ = Vector7d::Zero(), tau_ = Vector7d::Zero();
  Eigen::Vector3d center_;
  std::int64_t now_ns_ = 0, next_plan_ns_ = 0;
  wire::RobotCommand command_{};
  std::vector<Vector7d> torques_;
};

TEST_CASE(
    "c3rt-impedance: in lockstep it leads the arm round a circle within 2 mm, and holds when plans "
    "end") {
  Run run({"--clock", "lockstep", "--set", "impedance.reference=interpolate"});
  double worst_error = 0, worst_distance = 0;
  for (int k = 0; k < 2000; ++k) {
    run.step();
    if (k < 500) continue;
    worst_error = std::max(worst_error, run.tracking_error());
    worst_distance = std::max(worst_distance, run.distance_to_circle());
  }
  // the law leaves out the reference's acceleration: e = a / K = 0.05 m * (2 rad/s)^2 / 500 = 0.4
  // mm
  CHECK(worst_error < 2e-3);
  CHECK(worst_distance < 2e-3);
  CHECK(run.command().mode == c3rt_v2_IMPEDANCE_TRACK);
  CHECK(run.torques().size() == 2000);

  run.stop_planning();
  for (int k = 0; k < 500; ++k) run.step();
  CHECK(run.command().mode == c3rt_v2_IMPEDANCE_HOLD);
  const Eigen::Vector3d rest = Eigen::Map<const Eigen::Vector3d>(run.command().p_WE_desired_m);
  for (int k = 0; k < 500; ++k) run.step();
  CHECK(Eigen::Map<const Eigen::Vector3d>(run.command().p_WE_desired_m) == rest);
  CHECK(run.tracking_error() < 1e-3);
  CHECK(run.end() == 0);
}

TEST_CASE("c3rt-impedance: two lockstep runs give the same torques to the bit") {
  const auto torques = [] {
    Run run({"--clock", "lockstep"});
    for (int k = 0; k < 300; ++k) run.step();
    CHECK(run.end() == 0);
    return run.torques();
  };
  const std::vector<Vector7d> first = torques();
  REQUIRE(first.size() == 300);
  CHECK(first.back().norm() > 0);
  CHECK(first == torques());
}

TEST_CASE(
    "c3rt-impedance: in realtime it commands the robot, says what it does and ends on SIGTERM with "
    "0") {
  Child child({"--clock", "realtime"});
  wire::Bus bus(wire::test::settings(wire::ClockMode::kRealtime, wire::draw_session()));
  wire::Writer<wire::RobotState> states(bus);
  wire::Reader<wire::RobotCommand> commands(bus);
  wire::Reader<wire::ServiceStatus> statuses(bus);
  wire::RobotCommand command{};
  wire::ServiceStatus status{};
  int received = 0;
  CHECK(wire::test::eventually([&] {
    wire::RobotState state{};
    const double q[7] = {0, 0.275, 0, -2.222, 0, 2.497, 0};
    std::copy(std::begin(q), std::end(q), state.q_rad);
    state.mode = c3rt_v2_ROBOT_MOVE;
    states.write(state, rt::now_ns());
    while (commands.take(command)) ++received;
    statuses.take_newest(status);
    return received > 200 && status.rate_hz > 0 && status.compute.count > 200;
  }));
  CHECK(command.mode == c3rt_v2_IMPEDANCE_HOLD);
  CHECK(command.header.time_ns >= command.origin.state_ns);
  CHECK(status.process == c3rt_v2_PROCESS_IMPEDANCE);
  CHECK(std::string(status.text) == "holds its position: no plan has arrived");
  CHECK(status.wakeup_latency.count > 0);
  child.signal(SIGTERM);
  CHECK(child.wait() == 0);
}

TEST_CASE("c3rt-impedance: a missing robot model ends it with 2 before it joins the bus") {
  setenv("C3RT_PANDA_URDF", "/nowhere/panda.urdf", 1);
  Child child({});
  unsetenv("C3RT_PANDA_URDF");
  CHECK(child.wait() == 2);
}

}  // namespace
