// panda_plant: takes the plant's place for a real Panda or FR3, in real time.
#include <atomic>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "config/process_options.hpp"
#include "config/robot.hpp"
#include "config/service.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "examples/real_robot/door.hpp"
#include "examples/real_robot/stand_in_arm.hpp"
#include "idl/bus_settings.hpp"
#include "idl/process.hpp"
#include "idl/shutdown_listener.hpp"
#include "plant_emulator/load_parameters.hpp"
#include "plant_emulator/service.hpp"
#ifdef WITH_LIBFRANKA
#include "examples/real_robot/libfranka_arm.hpp"
#endif

namespace c3rt::real_robot {
namespace {

constexpr std::int64_t kPollNs = 50'000'000;  // of the thread that serves clients
constexpr int kPriority = 70;                 // below c3rt-impedance, whose answer is waited for
constexpr const char* kStandIn = "stand-in";

void say(bool attention, const std::string& sentence) {
  std::fprintf(stderr, "panda_plant: %s%s\n", attention ? "warning: " : "", sentence.c_str());
}

/// What the scenario says of the robot.
struct Robot {
  config::Robot description;
  plant::Parameters parameters;
};

Robot load(const config::ProcessOptions& options) {
  config::Section scenario = config::Document::load(options.scenario_path, options.overrides);
  Robot robot{config::load_robot(scenario), {}};
  robot.parameters = plant::load_parameters(scenario.section("plant"), robot.description);
  robot.parameters.recovers_alone =
      config::load_service(scenario).recovery == config::Recovery::kAutomatic;
  return robot;
}

std::unique_ptr<Arm> connect(const std::string& address, const Robot& robot) {
  if (address == kStandIn) return std::make_unique<StandInArm>(robot.parameters);
#ifdef WITH_LIBFRANKA
  return std::make_unique<LibfrankaArm>(address, robot.description,
                                        robot.parameters.safety.collision);
#else
  throw ArmError("--robot=" + address +
                 ": this program was built without libfranka (-DWITH_LIBFRANKA=ON); "
                 "--robot=stand-in is the emulated arm");
#endif
}

/// Serves clients from a thread of its own while the robot's loop steps.
class ClientThread {
 public:
  ClientThread(wire::Bus& bus, plant::Service& service)
      : bus_(bus), thread_([this, &service] {
          wire::become_helper_thread("clients");
          while (!stop_) {
            bus_.wait_for_data(kPollNs);
            service.serve(rt::now_ns());
          }
        }) {}
  ~ClientThread() {
    stop_ = true;
    bus_.wake();
    thread_.join();
  }
  ClientThread(const ClientThread&) = delete;
  ClientThread& operator=(const ClientThread&) = delete;

 private:
  wire::Bus& bus_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Until a stop is requested; then the arm is brought to rest first. @throws ArmError
void run(Arm& arm, Door& door, plant::Service& service, wire::StatusReporter& status) {
  const auto cycle = [&](const plant::State& state, bool commanded) noexcept {
    const std::int64_t now_ns = rt::now_ns();
    if (wire::StopFlag::requested()) door.obey({plant::OrderKind::kStop, 0, 0.0, {0, 0, 0}});
    door.see(state, commanded);
    service.step(now_ns, now_ns);
    status.compute().add(1e-9 * static_cast<double>(rt::now_ns() - now_ns));
  };
  const auto over = [&] { return wire::StopFlag::requested() && !door.wants_control(); };
  while (!over()) {
    arm.observe([&](const plant::State& state) {
      cycle(state, false);
      return !door.wants_control() && !door.wants_recovery() && door.wanted_behavior() == nullptr &&
             !over();
    });
    if (door.wanted_behavior() != nullptr) {
      const std::string why_not = arm.set_collision_behavior(*door.wanted_behavior());
      if (!why_not.empty()) say(true, "the robot does not take the thresholds: " + why_not);
      door.settled(why_not.empty());
    }
    if (door.wants_recovery()) {
      const std::string why_not = arm.recover();
      if (!why_not.empty()) say(true, "the robot does not recover: " + why_not);
      door.recovered(why_not.empty());
    }
    if (!door.wants_control()) continue;
    const Arm::End end = arm.control([&](const plant::State& state) -> std::optional<Vector7d> {
      cycle(state, true);
      if (!door.wants_control()) return std::nullopt;
      return door.torque();
    });
    if (!end.by_robot) continue;
    say(true, end.text);
    door.stopped_by_robot(end.errors);
  }
}

int run(const config::ProcessOptions& options, const std::string& address) {
  if (options.clock != config::Clock::kRealtime) {
    say(true, "--clock: expected realtime, got lockstep: a robot has no simulated time");
    return config::kCouldNotStart;
  }
  const wire::StopFlag stop;
  const Robot robot = load(options);
  const std::unique_ptr<Arm> arm = connect(address, robot);
  wire::BusSettings settings = wire::bus_settings(options, c3rt_v2_PROCESS_PLANT);
  if (settings.session_id == 0) settings.session_id = wire::draw_session();
  wire::Bus bus(settings);
  wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_PLANT, {}, say);
  const wire::ShutdownListener shutdown(bus, c3rt_v2_PROCESS_PLANT);
  Door door(robot.parameters);
  plant::Service service(bus, endpoint, door);
  say(false, "robot " + address + ", domain " + std::to_string(options.domain) + ", session " +
                 std::to_string(settings.session_id));
  try {
    const ClientThread clients(bus, service);
    // the last thing before the loop, so that no helper thread inherits it
    const std::string refused = rt::setup_thread({kPriority, {}, true});
    if (!refused.empty()) say(true, "NOT REAL-TIME: " + refused);
    run(*arm, door, service, endpoint.status());
  } catch (const ArmError& error) {
    say(true, error.what());
    endpoint.status().set_state(c3rt_v2_SERVICE_FAILED, error.what());
    return config::kFailedWhileRunning;
  }
  say(false, "stopped on request");
  return config::kStopped;
}

/// Takes --robot=ADDRESS out of the words, which the other processes have not.
std::string take_address(std::vector<char*>& words) {
  const std::string option = "--robot=";
  for (auto word = words.begin(); word != words.end(); ++word) {
    const std::string text = *word;
    if (text.rfind(option, 0) != 0) continue;
    words.erase(word);
    return text.substr(option.size());
  }
  return "";
}

}  // namespace
}  // namespace c3rt::real_robot

int main(int argc, char** argv) try {
  using namespace c3rt;
  std::vector<char*> words(argv, argv + argc);
  const std::string address = real_robot::take_address(words);
  int exit_status = 0;
  const auto options = config::parse_process_options(
      static_cast<int>(words.size()), words.data(), "panda_plant",
      "A real Panda or FR3 in the plant's place. Besides the options below it needs\n"
      "--robot=ADDRESS, the robot's host name or address, or --robot=stand-in, the emulated arm.",
      exit_status);
  if (!options) return exit_status;
  if (address.empty()) {
    real_robot::say(true, "--robot=ADDRESS is missing; --robot=stand-in is the emulated arm");
    return config::kCouldNotStart;
  }
  return real_robot::run(*options, address);
} catch (const std::exception& error) {
  c3rt::real_robot::say(true, error.what());
  return c3rt::config::kCouldNotStart;
}
