// c3rt-impedance: tracks the planner's pose and force with the arm at 1 kHz.
#include <cmath>
#include <exception>
#include <optional>
#include <thread>

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "config/process_options.hpp"
#include "controller/impedance/load_parameters.hpp"
#include "controller/impedance/service.hpp"
#include "controller/impedance/servo.hpp"
#include "controller/model/arm.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "idl/bus_settings.hpp"
#include "idl/process.hpp"

namespace {

using namespace c3rt;

constexpr std::int64_t kServicePeriod_ns = 20'000'000;

/// One loud warning for whatever the kernel refuses; the process runs all the same.
void set_up_thread(const rt::ThreadSettings& settings) {
  const std::string refused = rt::setup_thread(settings);
  if (!refused.empty())
    spdlog::warn("NOT REAL-TIME: {}; the 1 kHz loop will be late under load", refused);
}

void lock_memory() {
  rt::ThreadSettings settings;
  settings.lock_memory = true;
  set_up_thread(settings);
}

void become_servo_thread(const impedance::Thread& thread) {
  rt::ThreadSettings settings;
  settings.fifo_priority = thread.fifo_priority;
  if (thread.cpu >= 0) settings.cpus = {thread.cpu};
  set_up_thread(settings);
}

int run(const config::ProcessOptions& options) {
  config::Section scenario = config::Document::load(options.scenario_path, options.overrides);
  const impedance::Parameters parameters = impedance::load_from_scenario(scenario);
  model::Arm arm(parameters.arm);

  wire::Bus bus(wire::bus_settings(options, c3rt_v2_PROCESS_IMPEDANCE));
  const auto tell = [](bool attention, const std::string& said) {
    spdlog::log(attention ? spdlog::level::warn : spdlog::level::info, "{}", said);
  };
  wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_IMPEDANCE, {}, tell, wire::Wakes::kItself);
  wire::StatusReporter& status = endpoint.status();
  impedance::Servo servo(bus, parameters, std::move(arm), status.compute());
  impedance::Service service(servo, endpoint);
  // takes tens of milliseconds, so before the loop's grid starts
  if (bus.clock() == wire::ClockMode::kRealtime) lock_memory();
  wire::Loop::Settings pace{};
  pace.process = c3rt_v2_PROCESS_IMPEDANCE;
  pace.period_ns = std::llround(parameters.period * 1e9);
  pace.wakeup_latency = &status.wakeup_latency();
  pace.arrival = &servo.state_arrival();
  wire::Loop loop(bus, pace);
  spdlog::info("started clock={} rate_hz={:.0f} domain={}",
               bus.clock() == wire::ClockMode::kLockstep ? "lockstep" : "realtime",
               1.0 / parameters.period, options.domain);

  const auto serve = [&](std::int64_t at_ns) {
    service.count_missed_cycles(loop.missed_cycles());
    if (service.poll(at_ns)) spdlog::info("{}", service.text());
  };
  std::int64_t now_ns = 0;
  if (bus.clock() == wire::ClockMode::kLockstep) {
    while (loop.wait(now_ns)) {
      servo.cycle(now_ns);
      serve(now_ns);
    }
  } else {
    std::atomic<bool> running{true};
    std::thread servant([&] {
      wire::become_helper_thread("service");
      while (running) {
        serve(rt::now_ns());
        endpoint.wait(kServicePeriod_ns);
      }
    });
    // the last thing before the loop, so that no helper thread inherits it
    become_servo_thread(parameters.thread);
    while (loop.wait(now_ns)) servo.cycle(now_ns);
    running = false;
    servant.join();
  }
  if (loop.failure().empty()) {
    spdlog::info("stopped on request missed_cycles={}", loop.missed_cycles());
    return config::kStopped;
  }
  spdlog::error("{}", loop.failure());
  status.set_state(c3rt_v2_SERVICE_FAILED, loop.failure());
  return config::kFailedWhileRunning;
}

}  // namespace

int main(int argc, char** argv) {
  const wire::StopFlag stop;
  spdlog::set_default_logger(spdlog::stderr_logger_mt("impedance"));
  try {
    int exit_status = config::kStopped;
    const std::optional<config::ProcessOptions> options = config::parse_process_options(
        argc, argv, "c3rt-impedance", "tracks the planner's plan with the arm at 1 kHz",
        exit_status);
    return options ? run(*options) : exit_status;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return config::kCouldNotStart;
  }
}
