// c3rt-vision: what the cameras see of the plant's scene in, the objects' states out, once per
// exposure.
#include <cstdio>
#include <exception>
#include <string>

#include <spdlog/spdlog.h>

#include "config/process_options.hpp"
#include "config/scenario.hpp"
#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "idl/bus_settings.hpp"
#include "idl/shutdown_listener.hpp"
#include "vision/scene_source.hpp"
#include "vision/service.hpp"

namespace c3rt::vision {
namespace {

constexpr int kPriority = 30;  // above ordinary programs, below all that closes the 1 kHz loop
constexpr std::int64_t kPollNs =
    50'000'000;  // realtime: a blocked wait looks at the stop flag this often

/// Where nothing but an exposure wakes it.
void run_realtime(wire::Bus& bus, Service& service) {
  const std::string refused = rt::setup_thread({kPriority, {}, false});
  if (!refused.empty()) spdlog::warn("not real-time: {}", refused);
  const wire::ShutdownListener shutdown(bus, c3rt_v2_PROCESS_VISION);
  while (!wire::StopFlag::requested()) {
    bus.wait_for_data(kPollNs);
    service.step(rt::now_ns());
  }
}

/// @return why it ended, empty for a requested stop
std::string run_lockstep(wire::Bus& bus, Service& service, double rate) {
  wire::Loop loop(bus, {c3rt_v2_PROCESS_VISION, base::nanoseconds(1.0 / rate)});
  std::int64_t now_ns = 0;
  while (loop.wait(now_ns)) service.step(now_ns);
  return loop.failure();
}

int run(int argc, char** argv) {
  int exit_status = 0;
  const auto options = config::parse_process_options(
      argc, argv, "c3rt-vision",
      "Three virtual cameras, or an emulated sensor: the objects' poses and velocities.",
      exit_status);
  if (!options) return exit_status;
  const wire::StopFlag stop;
  const config::Scenario scenario =
      config::load_scenario(options->scenario_path, options->overrides);
  const Parameters& parameters = scenario.vision;
  wire::Bus bus(wire::bus_settings(*options, c3rt_v2_PROCESS_VISION));
  wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_VISION, fault_scope(parameters),
                          [](bool attention, const std::string& said) {
                            spdlog::log(attention ? spdlog::level::warn : spdlog::level::info, "{}",
                                        said);
                          });
  const plant::World& world = scenario.plant.world;
  Service service(bus, endpoint, parameters, starts_of(world), scenario.timing.vision_latency_s,
                  make_scene_source(bus, endpoint, world, parameters, options->seed));
  spdlog::info("start scenario={} source={} rate_hz={} cameras={}", scenario.name,
               parameters.source == SourceKind::kCameras ? "cameras" : "emulated", parameters.rate,
               parameters.cameras.size());
  std::string failure;
  if (options->clock == config::Clock::kLockstep) {
    failure = run_lockstep(bus, service, parameters.rate);
  } else {
    run_realtime(bus, service);
  }
  if (!failure.empty()) {
    spdlog::error("stop: {}", failure);
    return config::kFailedWhileRunning;
  }
  spdlog::info("stop {}", service.summary());
  return config::kStopped;
}

}  // namespace
}  // namespace c3rt::vision

int main(int argc, char** argv) try {
  return c3rt::vision::run(argc, argv);
} catch (const std::exception& error) {
  std::fprintf(stderr, "c3rt-vision: %s\n", error.what());
  return c3rt::config::kCouldNotStart;
}
