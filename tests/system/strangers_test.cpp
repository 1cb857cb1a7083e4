// The four processes started by hand, without a session, among strangers who write on their topics.
#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/dds.hpp"
#include "plant_emulator/errors.hpp"
#include "tests/idl/raw_writer.hpp"
#include "tests/idl/samples.hpp"
#include "tests/support/child_process.hpp"
#include "tests/system/loopback.hpp"

using namespace c3rt;

namespace {

using wire::test::plain;
using wire::test::RawWriter;

constexpr std::int64_t kSecond = 1'000'000'000;

using test::test_domain;

struct Hand : test::ChildProcess {
  explicit Hand(const char* program)
      : ChildProcess(test::process_command(
                         program, C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml",
                         test_domain(), {"--clock", "realtime"}),
                     std::string(C3RT_BINARY_DIRECTORY) + "/strangers_" + program + ".log") {}
};

/// Listens to what the processes say of themselves.
class Audience {
 public:
  void look() {
    wire::ServiceStatus status{};
    while (statuses_.take(status)) newest_[static_cast<std::size_t>(status.process)] = status;
    while (states_.take(state_)) {
    }
  }
  bool eventually(const std::function<bool()>& condition, const std::function<void()>& meanwhile) {
    const std::int64_t end_ns = rt::now_ns() + 30 * kSecond;
    rt::PeriodicClock clock(kSecond / 1000);
    while (rt::now_ns() < end_ns) {
      meanwhile();
      look();
      if (condition()) return true;
      clock.wait();
    }
    return false;
  }
  const std::optional<wire::ServiceStatus>& status(wire::Process process) const {
    return newest_[static_cast<std::size_t>(process)];
  }
  const wire::RobotState& state() const { return state_; }
  /// All four speak, of the plant's session, and the arm is commanded.
  bool all_well(std::uint64_t plants_session) const {
    for (int i = 0; i <= c3rt_v2_PROCESS_VISION; ++i) {
      const auto& newest = newest_[static_cast<std::size_t>(i)];
      if (!newest || newest->header.session_id != plants_session) return false;
    }
    return plants_session != 0 && state_.mode == c3rt_v2_ROBOT_MOVE;
  }
  std::uint64_t session() const { return state_.header.session_id; }
  std::uint64_t counter(wire::Process process, const char* name) const {
    const auto& newest = status(process);
    for (int i = 0; newest && i < c3rt_v2_COUNTERS; ++i) {
      if (std::string(newest->counter_names[i]) == name) return newest->counters[i];
    }
    return 0;
  }
  /// What a process has refused of a topic.
  std::optional<wire::RefusedSamples> refused(wire::Process process, const char* topic,
                                              const char* reason) const {
    const auto& newest = status(process);
    for (int i = 0; newest && i < wire::refused_kinds(*newest); ++i) {
      const wire::RefusedSamples& samples = newest->refused[i];
      if (std::string(samples.topic) == topic && std::string(samples.reason) == reason)
        return samples;
    }
    return std::nullopt;
  }

 private:
  wire::Bus bus_{test::loopback_settings()};
  wire::Reader<wire::ServiceStatus> statuses_{bus_};
  wire::Reader<wire::RobotState> states_{bus_, 1024};
  std::array<std::optional<wire::ServiceStatus>, wire::kProcessCount> newest_{};
  wire::RobotState state_{};
};

TEST_CASE("a session comes from the plant alone, whatever strangers tell before or after") {
  const Hand impedance("c3rt-impedance"), planner("c3rt-planner"), vision("c3rt-vision");
  Audience audience;
  wire::Bus bus(test::loopback_settings());
  RawWriter estimates(bus, wire::topic<wire::ObjectEstimate>()),
      plans(bus, wire::topic<wire::Plan>()), scenes(bus, wire::topic<wire::Scene>()),
      states(bus, wire::topic<wire::RobotState>());
  std::uint64_t seq = 0;
  const auto lie = [&] {
    ++seq;
    const std::int64_t now_ns = rt::now_ns();
    auto plan = plain<wire::Plan>();
    plan.valid_until_ns = now_ns + kSecond;
    plan.knots[0].time_ns = now_ns;
    estimates.write(plain<wire::ObjectEstimate>(), ~0ull, seq, now_ns);
    plans.write(plan, 1'800'000'000'000'000'000, seq, now_ns);
    scenes.write(plain<wire::Scene>(), ~0ull, seq, now_ns);
  };
  REQUIRE(audience.eventually(
      [&] {
        return estimates.matched() && plans.matched() && scenes.matched() &&
               audience.status(c3rt_v2_PROCESS_IMPEDANCE) &&
               audience.status(c3rt_v2_PROCESS_PLANNER) && audience.status(c3rt_v2_PROCESS_VISION);
      },
      [] {}));
  lie();
  const Hand plant("c3rt-plant");
  REQUIRE(audience.eventually([&] { return audience.all_well(audience.session()); }, [] {}));
  for (int i = 0; i < 20; ++i) lie();
  states.write(plain<wire::RobotState>(), ~0ull, 1, rt::now_ns());
  REQUIRE(audience.eventually(
      [&] {
        return audience.refused(c3rt_v2_PROCESS_PLANNER, "object/estimate", "second writer") &&
               audience.refused(c3rt_v2_PROCESS_IMPEDANCE, "plan", "second writer") &&
               audience.refused(c3rt_v2_PROCESS_VISION, "sim/scene", "second writer") &&
               audience.refused(c3rt_v2_PROCESS_IMPEDANCE, "robot/state", "second writer");
      },
      [] {}));
  CHECK(audience.all_well(audience.session()));
  CHECK(audience.session() < 1'800'000'000'000'000'000);

  // and a plant that is started again is believed
  const std::uint64_t before = audience.session();
  plant.signal(SIGKILL);
  const Hand again("c3rt-plant");
  CHECK(audience.eventually(
      [&] { return audience.session() != before && audience.all_well(audience.session()); },
      [] {}));
}

TEST_CASE("a second writer of commands, plans and states moves nothing and is named") {
  const Hand plant("c3rt-plant"), impedance("c3rt-impedance"), planner("c3rt-planner"),
      vision("c3rt-vision");
  Audience audience;
  REQUIRE(audience.eventually([&] { return audience.all_well(audience.session()); }, [] {}));
  wire::Bus bus(test::loopback_settings());
  RawWriter commands(bus, wire::topic<wire::RobotCommand>()), plans(bus, wire::topic<wire::Plan>()),
      states(bus, wire::topic<wire::RobotState>());
  REQUIRE(audience.eventually(
      [&] { return commands.matched() && plans.matched() && states.matched(); }, [] {}));
  // far from the processes' own numbers: the state tells the number of the command that was obeyed
  constexpr std::uint64_t kFirst = 1'000'000'000;
  std::uint64_t seq = kFirst;
  std::uint64_t obeyed = 0;
  const auto push = [&] {
    ++seq;
    const std::int64_t now_ns = rt::now_ns();
    auto command = plain<wire::RobotCommand>();
    command.tau_nm[0] = 87.0;
    commands.write(command, seq % 2 == 0 ? 0 : audience.session(), seq, now_ns);
    auto plan = plain<wire::Plan>();
    plan.valid_until_ns = now_ns + kSecond;
    plan.knots[0].time_ns = now_ns;
    plan.knots[0].p_WE_m[0] = 0.4;
    plans.write(plan, audience.session(), seq, now_ns);
    auto state = plain<wire::RobotState>();
    state.mode = c3rt_v2_ROBOT_REFLEX;
    states.write(state, audience.session(), seq, now_ns + (seq % 2 == 0 ? 3600 * kSecond : 0));
    obeyed = std::max(obeyed, audience.state().command_seq);
  };
  const auto count = [](const std::optional<wire::RefusedSamples>& samples) {
    return samples ? samples->count : 0;
  };
  const bool all_refused = audience.eventually(
      [&] {
        return count(audience.refused(c3rt_v2_PROCESS_PLANT, "robot/command", "second writer")) >
                   500 &&
               count(audience.refused(c3rt_v2_PROCESS_IMPEDANCE, "plan", "second writer")) > 500 &&
               count(audience.refused(c3rt_v2_PROCESS_IMPEDANCE, "robot/state", "second writer")) >
                   200 &&
               count(audience.refused(c3rt_v2_PROCESS_IMPEDANCE, "robot/state", "header")) > 200;
      },
      push);
  CHECK(all_refused);
  CHECK(obeyed > 0);
  CHECK(obeyed < kFirst);
  const auto named = audience.refused(c3rt_v2_PROCESS_PLANT, "robot/command", "second writer");
  REQUIRE(named);
  CHECK_THAT(std::string(named->latest), Catch::Contains("(pid " + std::to_string(getpid()) + ")"));
}

/// Whether the robot was stopped by more than a machine that is busy elsewhere.
bool own_reflex(const wire::RobotState& state) {
  return state.mode == c3rt_v2_ROBOT_REFLEX &&
         state.errors != plant::bit(plant::Error::kCommunicationConstraintsViolation);
}

TEST_CASE("a stranger's states, ahead in time, elsewhere and in a reflex, move nothing") {
  const Hand plant("c3rt-plant"), impedance("c3rt-impedance"), planner("c3rt-planner"),
      vision("c3rt-vision");
  Audience audience;
  REQUIRE(audience.eventually([&] { return audience.all_well(audience.session()); }, [] {}));
  wire::Bus bus(test::loopback_settings());
  RawWriter states(bus, wire::topic<wire::RobotState>());
  REQUIRE(audience.eventually([&] { return states.matched(); }, [] {}));
  std::uint64_t seq = 1'000'000'000;
  bool stopped = false;
  const std::uint64_t stops_before = audience.counter(c3rt_v2_PROCESS_IMPEDANCE, "stops");
  const auto lie = [&] {
    ++seq;
    wire::RobotState state = audience.state();
    state.q_rad[seq % 7] += 0.05;
    if (seq % 3 == 0) state.mode = c3rt_v2_ROBOT_REFLEX;
    const bool ahead = seq % 2 == 0;
    states.write(state, audience.session(), seq, rt::now_ns() + (ahead ? 3600 * kSecond : 0));
    stopped = stopped || own_reflex(audience.state());
  };
  const auto count = [&](wire::Process process, const char* reason) {
    const auto samples = audience.refused(process, "robot/state", reason);
    return samples ? samples->count : 0;
  };
  CHECK(audience.eventually(
      [&] {
        return count(c3rt_v2_PROCESS_IMPEDANCE, "second writer") > 500 &&
               count(c3rt_v2_PROCESS_IMPEDANCE, "header") > 500 &&
               count(c3rt_v2_PROCESS_PLANNER, "second writer") > 500 &&
               count(c3rt_v2_PROCESS_PLANNER, "header") > 500;
      },
      lie));
  CHECK_FALSE(stopped);
  CHECK(audience.counter(c3rt_v2_PROCESS_IMPEDANCE, "stops") == stops_before);
  CHECK(audience.all_well(audience.session()));
}

TEST_CASE("estimates that cannot be do not move the arm, beside our vision and in its place") {
  const Hand plant("c3rt-plant"), impedance("c3rt-impedance"), planner("c3rt-planner");
  Audience audience;
  wire::Bus bus(test::loopback_settings());
  RawWriter estimates(bus, wire::topic<wire::ObjectEstimate>());
  std::uint64_t seq = 0;
  bool stopped = false;
  const auto see = [&](const std::function<void(wire::ObjectEstimate&)>& spoil) {
    // as many as vision sends, though this is asked each millisecond
    stopped = stopped || own_reflex(audience.state());
    if (audience.session() == 0 || ++seq % 10 != 0) return;
    auto estimate = plain<wire::ObjectEstimate>();
    estimate.valid = true;
    estimate.exposure_ns = rt::now_ns();
    estimate.p_WB_m[0] = estimate.p_measured_m[0] = 0.55;
    estimate.p_WB_m[1] = estimate.p_measured_m[1] = 0.1;
    estimate.p_WB_m[2] = estimate.p_measured_m[2] = 0.007;
    spoil(estimate);
    estimates.write(estimate, audience.session(), seq, estimate.exposure_ns);
  };
  const auto says = [&](const char* words) {
    const auto& status = audience.status(c3rt_v2_PROCESS_PLANNER);
    return status && std::string(status->text).find(words) != std::string::npos;
  };
  // in the place of vision: the arm goes to the ball that is told
  REQUIRE(audience.eventually(
      [&] { return says("approach") && audience.state().mode == c3rt_v2_ROBOT_MOVE; },
      [&] { see([](wire::ObjectEstimate&) {}); }));
  const auto refused = [&] {
    const auto samples = audience.refused(c3rt_v2_PROCESS_PLANNER, "object/estimate", "value");
    return samples ? samples->count : 0;
  };
  std::uint64_t before = 0;
  for (const auto& spoil : std::vector<std::function<void(wire::ObjectEstimate&)>>{
           [](wire::ObjectEstimate& e) { e.v_WB_m_per_s[0] = 1e6; },
           [](wire::ObjectEstimate& e) { e.v_WB_m_per_s[1] = 1e308; },
           [](wire::ObjectEstimate& e) { e.p_WB_m[2] = 1e300; },
           [](wire::ObjectEstimate& e) { e.omega_rad_per_s[0] = -1e9; },
           [](wire::ObjectEstimate& e) { e.q_WB[0] = 0.0; }}) {
    CHECK(audience.eventually([&] { return refused() > before + 20; }, [&] { see(spoil); }));
    before = refused();
  }
  // it knows of no ball and says so
  CHECK(audience.eventually([&] { return says("vision is silent"); }, [] {}));
  CHECK_FALSE(stopped);
  CHECK(audience.state().mode == c3rt_v2_ROBOT_MOVE);

  // beside our vision: what can be is refused, too
  const Hand vision("c3rt-vision");
  CHECK(audience.eventually(
      [&] {
        const auto second =
            audience.refused(c3rt_v2_PROCESS_PLANNER, "object/estimate", "second writer");
        return second && second->count > 20;
      },
      [&] { see([](wire::ObjectEstimate& e) { e.p_WB_m[0] = 0.4; }); }));
  CHECK(audience.eventually([&] { return audience.all_well(audience.session()); }, [] {}));
  CHECK_FALSE(stopped);
}

/// log_hash of two simulated seconds, with somebody who writes into the run as long as it lasts.
std::string lockstep_hash(const std::string& name, bool with_stranger) {
  const std::string folder = std::string(C3RT_BINARY_DIRECTORY) + "/strangers_" + name;
  test::ChildProcess run(
      {test::program("c3rt"), "run", "circle_slow", "--clock", "lockstep", "--duration", "2",
       "--no-pictures", "--domain", std::to_string(test_domain()), "--out", folder},
      folder + ".log");
  std::atomic<bool> over{false};
  std::thread stranger([&] {
    if (!with_stranger) return;
    wire::Bus bus(test::loopback_settings());
    wire::Reader<wire::RobotState> states(bus);
    wire::RobotState state{};
    // a run does not begin on a domain on which somebody commands a robot
    while (!over && !states.take_newest(state)) usleep(1000);
    RawWriter plans(bus, wire::topic<wire::Plan>()),
        commands(bus, wire::topic<wire::RobotCommand>()),
        estimates(bus, wire::topic<wire::ObjectEstimate>());
    for (std::uint64_t seq = 1; !over; ++seq) {
      (void)states.take_newest(state);
      auto plan = plain<wire::Plan>();
      plan.knots[0].p_WE_m[0] = 0.3;
      plan.valid_until_ns = 3 * kSecond;
      plan.knots[0].time_ns = state.header.time_ns;
      auto command = plain<wire::RobotCommand>();
      command.tau_nm[0] = 50.0;
      auto estimate = plain<wire::ObjectEstimate>();
      estimate.valid = true;
      plans.write(plan, state.header.session_id, seq, state.header.time_ns);
      commands.write(command, state.header.session_id, seq, state.header.time_ns);
      estimates.write(estimate, state.header.session_id, seq, state.header.time_ns);
      usleep(200);
    }
  });
  (void)run.wait();  // two seconds meet no criterion
  over = true;
  stranger.join();
  std::ifstream file(folder + "/report.json");
  const std::string report{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::size_t at = report.find("fnv1a64:");
  return at == std::string::npos ? "" : report.substr(at, 24);
}

TEST_CASE("a lockstep run has the same bits among strangers") {
  const std::string alone = lockstep_hash("alone", false);
  CHECK(alone.size() == 24);
  CHECK(lockstep_hash("among", true) == alone);
}

}  // namespace
