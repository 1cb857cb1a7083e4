// c3rt-plant: the simulated robot, table and objects on the bus, paced by the clock (realtime) or
// pacing all (lockstep).
#include <atomic>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <spdlog/spdlog.h>

#include "config/process_options.hpp"
#include "config/scenario.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "idl/bus_settings.hpp"
#include "plant_emulator/service.hpp"

namespace c3rt::plant {
namespace {

constexpr std::int64_t kJoinTimeoutNs = 60'000'000'000;  // lockstep: the other processes' start
constexpr std::int64_t kPollNs = 50'000'000;             // of the thread that serves clients
constexpr int kStepPriority = 70;  // below the impedance process, for whose answer the robot waits

/// Simulated over elapsed time, in thousandths.
std::uint64_t real_time_factor(std::uint64_t cycles, std::int64_t elapsed_ns) noexcept {
  if (elapsed_ns <= 0) return 0;
  return static_cast<std::uint64_t>(1000.0 * static_cast<double>(cycles) * kCycleNs /
                                    static_cast<double>(elapsed_ns));
}

/// Serves clients from a thread of its own while the loop steps.
class DeskThread {
 public:
  DeskThread(wire::Bus& bus, Service& service)
      : bus_(bus), thread_([this, &service] {
          while (!stop_) {
            bus_.wait_for_data(kPollNs);
            service.serve(rt::now_ns());
          }
        }) {}
  ~DeskThread() {
    stop_ = true;
    bus_.wake();
    thread_.join();
  }

 private:
  wire::Bus& bus_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

std::string run_realtime(wire::Bus& bus, Service& service, wire::StatusReporter& status) {
  auto& missed = status.counter("missed_cycles");
  auto& factor = status.counter("real_time_factor_1e3");
  const DeskThread desk(bus, service);
  const std::string refused = rt::setup_thread({kStepPriority, {}, true});
  if (!refused.empty()) spdlog::warn("not real-time: {}", refused);

  wire::Loop::Settings pace{c3rt_v2_PROCESS_PLANT, kCycleNs};
  pace.wakeup_latency = &status.wakeup_latency();
  wire::Loop loop(bus, pace);
  std::int64_t now_ns = 0, first_ns = 0;
  std::uint64_t cycles = 0;
  while (loop.wait(now_ns)) {
    const std::int64_t begin_ns = rt::now_ns();
    if (first_ns == 0) first_ns = now_ns;
    service.step(now_ns, now_ns);
    ++cycles;
    missed.store(loop.missed_cycles(), std::memory_order_relaxed);
    factor.store(real_time_factor(cycles, now_ns - first_ns + kCycleNs), std::memory_order_relaxed);
    status.compute().add(1e-9 * static_cast<double>(rt::now_ns() - begin_ns));
  }
  return loop.failure();
}

std::vector<wire::Process> expected_processes(const std::vector<std::string>& names) {
  std::vector<wire::Process> processes;
  for (const std::string& name : names) {
    int i = 0;
    while (i < wire::kProcessCount && name != wire::process_name(static_cast<wire::Process>(i)))
      ++i;
    if (i == wire::kProcessCount || i == c3rt_v2_PROCESS_PLANT)
      throw std::invalid_argument("--expect: no process \"" + name + "\" to wait for");
    processes.push_back(static_cast<wire::Process>(i));
  }
  return processes;
}

std::string run_lockstep(wire::Bus& bus, Node& node, Service& service, wire::StatusReporter& status,
                         const std::vector<std::string>& expect) {
  auto& factor = status.counter("real_time_factor_1e3");
  wire::LockstepMaster master(bus, expected_processes(expect), kJoinTimeoutNs);
  const std::int64_t start_ns = rt::now_ns();
  std::uint64_t cycles = 0;
  service.send(node.start(kCycleNs),
               kCycleNs);  // time begins at one cycle: 0 means "none" in a stamp
  for (std::int64_t now_ns = kCycleNs; master.advance(now_ns); now_ns += kCycleNs) {
    const std::int64_t begin_ns = rt::now_ns();
    service.serve(now_ns);
    service.step(now_ns, now_ns + kCycleNs);
    const std::int64_t end_ns = rt::now_ns();
    factor.store(real_time_factor(++cycles, end_ns - start_ns), std::memory_order_relaxed);
    status.compute().add(1e-9 * static_cast<double>(end_ns - begin_ns));
  }
  return master.failure();
}

int run(int argc, char** argv) {
  int exit_status = 0;
  const auto options = config::parse_process_options(
      argc, argv, "c3rt-plant",
      "The simulated robot with its 1 kHz torque interface, the table and the objects.",
      exit_status);
  if (!options) return exit_status;
  const wire::StopFlag stop;
  const config::Scenario scenario =
      config::load_scenario(options->scenario_path, options->overrides);
  const bool lockstep = options->clock == config::Clock::kLockstep;
  wire::BusSettings settings = wire::bus_settings(*options, c3rt_v2_PROCESS_PLANT);
  if (settings.session_id == 0) settings.session_id = wire::draw_session();
  wire::Bus bus(settings);
  wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_PLANT, fault_scope(scenario.plant),
                          [](bool attention, const std::string& said) {
                            spdlog::log(attention ? spdlog::level::warn : spdlog::level::info, "{}",
                                        said);
                          });
  Node node(scenario.plant, scenario.vision.rate, options->seed);
  Service service(bus, endpoint, node);
  spdlog::info("start scenario={} clock={} session={} step_s={} objects={}", scenario.name,
               lockstep ? "lockstep" : "realtime", settings.session_id, scenario.plant.world.step,
               scenario.plant.world.objects.size());
  const std::string failure =
      lockstep ? run_lockstep(bus, node, service, endpoint.status(), options->expect)
               : run_realtime(bus, service, endpoint.status());
  if (!failure.empty()) {
    spdlog::error("stop: {}", failure);
    return config::kFailedWhileRunning;
  }
  spdlog::info("stop");
  return config::kStopped;
}

}  // namespace
}  // namespace c3rt::plant

int main(int argc, char** argv) try {
  return c3rt::plant::run(argc, argv);
} catch (const std::exception& error) {
  std::fprintf(stderr, "c3rt-plant: %s\n", error.what());
  return c3rt::config::kCouldNotStart;
}
