#include "cli/watch.hpp"

#include <chrono>
#include <cstdint>
#include <thread>

#include <fmt/format.h>

#include "cli/in_process.hpp"
#include "cli/launch.hpp"

namespace c3rt::cli {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);
constexpr double kLongestSilence =
    60.0;  // of the plant, while the others start or a tick is worked on [s]
constexpr int kCyclesPerLook = 200;  // of nodes in this process

}  // namespace

Ending watch(Supervisor& supervisor, const Recorder& recorder,
             const std::function<void(const Live&)>& show) {
  return watch_until([&recorder] { return recorder.done(); }, supervisor, recorder, show);
}

Ending watch_until(const std::function<bool()>& over, Supervisor& supervisor,
                   const Recorder& recorder, const std::function<void(const Live&)>& show) {
  Ending ending;
  std::uint64_t last_steps = 0;
  double heard_at = wall_time();
  while (!over()) {
    if (wire::StopFlag::requested()) {
      ending.interrupted = true;
      break;
    }
    if (const auto end = supervisor.poll()) {
      ending.failed = end->name + " " + end->reason;
      ending.details = failure_text(*end);
      break;
    }
    if (const std::string failure = recorder.failure(); !failure.empty()) {
      ending.failed = ending.details = "recorder: " + failure;
      break;
    }
    const Live live = recorder.live();
    if (live.steps != last_steps) {
      last_steps = live.steps;
      heard_at = wall_time();
    } else if (wall_time() - heard_at > kLongestSilence) {
      ending.failed = ending.details =
          fmt::format("plant: nothing was heard for {:.0f} s", kLongestSilence);
      break;
    }
    show(live);
    std::this_thread::sleep_for(kLook);
  }
  return ending;
}

Ending watch_in_process(
    const config::Scenario& scenario, std::uint64_t seed, const wire::BusSettings& bus,
    Recorder& recorder,
    const std::function<void(wire::Process, bool attention, const std::string&)>& tell,
    const std::function<void(const Live&)>& show) {
  Ending ending;
  try {
    InProcess nodes(scenario, seed, bus, tell);
    nodes.join(Recorder::kPeriod_ns,
               [&recorder](const wire::Sequences& newest) { recorder.take(newest); });
    for (int cycle = 0; !recorder.done() && !ending.interrupted; ++cycle) {
      ending.interrupted = wire::StopFlag::requested();
      nodes.advance();
      if (cycle % kCyclesPerLook == 0) show(recorder.live());
    }
  } catch (const std::exception& error) {
    ending.failed = ending.details = error.what();
  }
  return ending;
}

void stop(Supervisor& supervisor) {
  for (const std::string& name : supervisor.stop())
    fmt::print(stderr, "c3rt: {} did not end by itself and was killed\n", name);
}

}  // namespace c3rt::cli
