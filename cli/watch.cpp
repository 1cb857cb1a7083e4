#include "cli/watch.hpp"

#include <chrono>
#include <cstdint>
#include <thread>

#include <fmt/format.h>

#include "cli/launch.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);
constexpr double kLongestSilence =
    60.0;  // of the plant, while the others start or a tick is worked on [s]

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

}  // namespace c3rt::cli
