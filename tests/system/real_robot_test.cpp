// The door to a real robot (examples/real_robot) in the plant's place, with the emulated arm behind
// it: c3rt up without plant and vision, whose estimates this test tells. In real time, without a
// claim about time.
#include <atomic>
#include <csignal>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/convert.hpp"
#include "idl/dds.hpp"
#include "tests/cli/folder.hpp"
#include "tests/idl/samples.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/outcome.hpp"
#include "tests/system/loopback.hpp"

using namespace c3rt;

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
const std::string kScenario = C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml";

using test::test_domain;

std::vector<std::string> door_command(const std::vector<std::string>& more) {
  std::vector<std::string> command = test::process_command("", kScenario, test_domain(), more);
  command[0] = C3RT_DOOR;
  return command;
}

struct DoorProcess : test::ChildProcess {
  DoorProcess()
      : ChildProcess(door_command({"--robot=stand-in"}),
                     std::string(C3RT_BINARY_DIRECTORY) + "/real_robot_door.log") {}
};

/// c3rt with a runtime folder of its own; what it started ends with it.
class Person {
 public:
  ~Person() { (void)c3rt("down"); }
  support::Outcome c3rt(const std::string& arguments) const {
    return support::outcome_of("XDG_RUNTIME_DIR='" + folder_.path().string() +
                               "' '" C3RT_BINARY_DIRECTORY "/bin/c3rt' " + arguments +
                               " --domain " + std::to_string(test_domain()));
  }
  /// Until it works: on a busy machine commands are lost again and again.
  bool recovers() const {
    for (int i = 0; i < 5; ++i) {
      if (c3rt("recover").status == 0) return true;
    }
    return false;
  }
  std::string out() const { return (folder_.path() / "out").string(); }

 private:
  cli::Folder folder_;
};

/// Sees a ball that rests where there is none, and listens to the others.
class Vision {
 public:
  Vision() : thread_([this] { tell(); }) {}
  ~Vision() {
    over_ = true;
    thread_.join();
  }
  bool eventually(const std::function<bool()>& condition) {
    const std::int64_t end_ns = rt::now_ns() + 60 * kSecond;
    while (rt::now_ns() < end_ns) {
      bus_.wait_for_data(20'000'000);
      wire::ServiceStatus status{};
      while (statuses_.take(status)) newest_[static_cast<std::size_t>(status.process)] = status;
      while (states_.take(state_)) {
      }
      while (commands_.take(command_)) {
      }
      if (condition()) return true;
    }
    return false;
  }
  /// The arm follows the plan, and so far.
  bool follows(double meters) {
    Eigen::Vector3d from = Eigen::Vector3d::Constant(1e3);
    return eventually([&] {
      const bool tracks =
          state_.mode == c3rt_v2_ROBOT_MOVE && command_.mode == c3rt_v2_IMPEDANCE_TRACK;
      if (!tracks) return false;
      const Eigen::Vector3d p = wire::vector(state_.p_WE_m);
      if (from.x() > 100.0) from = p;
      return (p - from).norm() > meters;
    });
  }
  /// Plant, impedance and planner speak of the session of the robot's state.
  bool one_session() {
    return eventually([this] {
      for (const auto process :
           {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER}) {
        if (newest_[process].header.session_id != session()) return false;
      }
      return session() != 0;
    });
  }
  std::uint64_t session() const { return state_.header.session_id; }
  const wire::RobotState& state() const { return state_; }

 private:
  void tell() {
    rt::PeriodicClock clock(kSecond / 100);
    while (!over_) {
      clock.wait();
      auto estimate = wire::test::plain<wire::ObjectEstimate>();
      estimate.valid = true;
      estimate.exposure_ns = rt::now_ns();
      const Eigen::Vector3d p(0.5, -0.1, 0.007);
      wire::fill(estimate.p_WB_m, p);
      wire::fill(estimate.p_measured_m, p);
      estimates_.write(estimate, estimate.exposure_ns);
    }
  }

  wire::Bus bus_{test::loopback_settings()};
  wire::Reader<wire::ServiceStatus> statuses_{bus_};
  wire::Reader<wire::RobotState> states_{bus_, 1024};
  wire::Reader<wire::RobotCommand> commands_{bus_, 1024};
  wire::Writer<wire::ObjectEstimate> estimates_{bus_};
  std::array<wire::ServiceStatus, wire::kProcessCount> newest_{};
  wire::RobotState state_{};
  wire::RobotCommand command_{};
  std::atomic<bool> over_{false};
  std::thread thread_;
};

TEST_CASE(
    "a door in the plant's place: the arm follows, stops, recovers, and the session is its own") {
  const Person person;
  // the others may be there first
  const support::Outcome up =
      person.c3rt("up circle_slow --without plant,vision --out " + person.out());
  INFO(up.output);
  REQUIRE(up.status == 0);
  CHECK_THAT(up.output, Catch::Contains("waits for plant, vision: yours"));
  Vision vision;
  auto door = std::make_unique<DoorProcess>();
  REQUIRE(vision.follows(0.02));
  REQUIRE(vision.one_session());
  CHECK_THAT(person.c3rt("status").output, Catch::Contains("follows commands"));

  const support::Outcome stop = person.c3rt("stop");
  INFO(stop.output);
  CHECK(stop.status == 0);
  CHECK(vision.eventually([&] { return vision.state().mode == c3rt_v2_ROBOT_USER_STOPPED; }));
  CHECK(wire::vector(vision.state().dq_rad_per_s).cwiseAbs().maxCoeff() < 0.05);
  CHECK_THAT(person.c3rt("status").output, Catch::Contains("stopped by a person"));
  CHECK(person.recovers());
  CHECK(vision.follows(0.0));

  const support::Outcome stall = person.c3rt("fault stall plant --for 1");
  CHECK(stall.status == 1);
  CHECK_THAT(stall.output, Catch::Contains("drop-commands"));

  // a door that is started again has another session, and the others take it
  const std::uint64_t before = vision.session();
  door->signal(SIGKILL);
  door = std::make_unique<DoorProcess>();
  CHECK(vision.eventually([&] { return vision.session() != before; }));
  CHECK(vision.one_session());
  CHECK(vision.follows(0.0));

  door->signal(SIGTERM);
  CHECK(door->wait() == 0);
}

TEST_CASE("a door or a service without a plant says what it cannot do") {
  const auto refused = [](const support::Outcome& outcome, const std::string& words) {
    INFO(outcome.output);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Catch::Contains(words));
  };
  const Person person;
  refused(person.c3rt("run circle_slow --without plant"), "c3rt up, and c3rt record");
  refused(person.c3rt("up circle_slow --without plant --clock lockstep"), "simulated time");
  const auto door = [](const std::string& options) {
    return support::outcome_of("'" C3RT_DOOR "' '" + kScenario + "' " + options);
  };
  refused(door(""), "--robot=ADDRESS is missing");
  refused(door("--robot=stand-in --clock lockstep"), "expected realtime");
  refused(door("--robot=172.16.0.2"), "without libfranka");
}

}  // namespace
