// c3rt-planner: robot state and object estimates in, plan out, at a fixed rate.
#include <cstdio>
#include <exception>
#include <string>

#include <spdlog/spdlog.h>

#include "config/process_options.hpp"
#include "config/scenario.hpp"
#include "controller/base/time.hpp"
#include "controller/planner/service.hpp"
#include "controller/rt/thread_setup.hpp"
#include "idl/bus_settings.hpp"

namespace {

using namespace c3rt;

constexpr int kPriority = 40;  // below the 1 kHz loop and what carries its samples, above vision

int run(const config::ProcessOptions& options) {
  const config::Scenario scenario = config::load_scenario(options.scenario_path, options.overrides);
  wire::Bus bus(wire::bus_settings(options, c3rt_v2_PROCESS_PLANNER));
  wire::Endpoint endpoint(
      bus, c3rt_v2_PROCESS_PLANNER, {}, [](bool attention, const std::string& said) {
        spdlog::log(attention ? spdlog::level::warn : spdlog::level::info, "planner: {}", said);
      });
  // before the service: its threads take after this one
  if (options.clock == config::Clock::kRealtime) {
    const std::string refused = rt::setup_thread({kPriority, {}, false});
    if (!refused.empty()) spdlog::warn("NOT REAL-TIME: {}; plans will be late under load", refused);
  }
  planner::Service service(bus, endpoint, planner::seeded(scenario.planner, options.seed),
                           model::Arm(scenario.impedance.arm), scenario.timing.solve_time_s);
  wire::Loop loop(bus, {c3rt_v2_PROCESS_PLANNER, base::nanoseconds(1.0 / scenario.planner.rate)});
  spdlog::info("planner: start rate_hz={} N={} scenario={}", scenario.planner.rate,
               scenario.planner.N, scenario.name);
  std::int64_t now_ns = 0;
  while (loop.wait(now_ns)) service.step(now_ns);
  if (!loop.failure().empty()) {
    spdlog::error("planner: stop: {}", loop.failure());
    return config::kFailedWhileRunning;
  }
  spdlog::info("planner: stop {}", service.summary());
  return config::kStopped;
}

}  // namespace

int main(int argc, char** argv) {
  int exit_status = 0;
  const auto options = c3rt::config::parse_process_options(
      argc, argv, "c3rt-planner",
      "Consensus complementarity control at a fixed rate: plans contact-implicit motion",
      exit_status);
  if (!options) return exit_status;
  const c3rt::wire::StopFlag stop;
  try {
    return run(*options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "c3rt-planner: %s\n", error.what());
    return c3rt::config::kCouldNotStart;
  }
}
