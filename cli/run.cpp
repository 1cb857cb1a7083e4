#include "cli/run.hpp"

#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/spdlog.h>

#include "cli/guests.hpp"
#include "cli/judge.hpp"
#include "cli/log_rotation.hpp"
#include "cli/paths.hpp"
#include "cli/recorded.hpp"
#include "cli/recorder.hpp"
#include "cli/report/pictures.hpp"
#include "cli/report/report.hpp"
#include "cli/table.hpp"
#include "cli/watch.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace {

constexpr double kLookAtLogs = 1.0;  // [s]

/// As watch(), with the nodes in this process.
Ending run_here(const Launch& launch, std::uint64_t seed, Recorder& recorder, LiveTable& table) {
  const auto sink = std::make_shared<spdlog::sinks::rotating_file_sink_mt>(
      (launch.out() / "logs" / "in-process.log").string(), kLargestLog, kOlderLogs, true);
  spdlog::logger log("in-process", sink);
  const auto tell = [&log](wire::Process process, bool attention, const std::string& said) {
    log.log(attention ? spdlog::level::warn : spdlog::level::info, "{}: {}",
            wire::process_name(process), said);
  };
  return watch_in_process(launch.scenario(), seed, launch.bus(), recorder, tell,
                          [&table](const Live& live) { table.update(live); });
}

std::unique_ptr<Recording> begin_recording(const Launch& launch, const LaunchSettings& settings) {
  const std::filesystem::path file = launch.out() / kRecordingName;
  std::filesystem::remove(file);  // of an earlier run in this folder
  auto recording = std::make_unique<Recording>(file);
  tell(*recording, {launch.scenario().name, std::filesystem::absolute(launch.file()).string(),
                    settings.overrides, settings.seed, settings.clock_name()});
  return recording;
}

void end_recording(Recording& recording, const Report& report, const std::string& text) {
  recording.attach(kReportAttachment, "application/json", text);
  recording.add_metadata(kResultMetadata,
                         {{"result", report.result},
                          {"real_time_factor", fmt::format("{}", report.real_time_factor)}});
  recording.finish();
}

}  // namespace

int run(const LaunchSettings& settings) {
  Launch launch(settings);
  const config::Scenario& scenario = launch.scenario();
  const task::Task task = scenario.task.motion.seeded(settings.seed);

  fmt::print("c3rt run {} ({}{}, seed {}): {}\n", scenario.name, settings.clock_name(),
             settings.in_process ? " in one process" : "", settings.seed, scenario.description);
  fmt::print("results in {}\n", launch.out().string());
  std::fflush(stdout);

  // of a task that is done once every object counts
  const int course_goal =
      task.repeats() ? scenario.task.loops : static_cast<int>(scenario.plant.world.objects.size());
  if (!settings.in_process) launch.require_free_bus();
  Supervisor supervisor;
  // In realtime nothing is recorded before the guests have come; in lockstep the recorder takes
  // part from the first tick on. What waits for them is gone before the recorder is there: a
  // process that deletes one DDS participant while another of its own gets to know its peers may
  // never hear of what they write (Cyclone 0.10.2).
  const bool starts_first = !settings.without.empty() && !settings.lockstep;
  if (starts_first) launch.start(supervisor, true);
  if (!settings.without.empty()) {
    fmt::print("waits for {}\n", guests_text(launch));
    std::fflush(stdout);
    if (!await_guests(launch, supervisor)) {
      launch.lock().set_ended("interrupted");
      return kCriterionFailed;
    }
  }
  const std::unique_ptr<Recording> recording =
      settings.logs ? begin_recording(launch, settings) : nullptr;
  Recorder recorder(launch.bus(), {task, scenario.task.loops, scenario.task.duration_s},
                    recording.get(), launch.out());
  LiveTable table(
      fmt::format("c3rt run {}  {}  seed {}", scenario.name, settings.clock_name(), settings.seed),
      task.unit(), course_goal, scenario.task.duration_s);
  if (!settings.in_process && !starts_first) launch.start(supervisor, true);
  double looked_at = wall_time();
  const auto show = [&](const Live& live) {
    table.update(live);
    if (wall_time() - looked_at < kLookAtLogs) return;
    looked_at = wall_time();
    (void)rotate_logs(launch.out() / "logs");  // a log that grows on is no reason to end the run
  };
  const Ending ending = settings.in_process ? run_here(launch, settings.seed, recorder, table)
                                            : watch(supervisor, recorder, show);
  table.finish(recorder.live());
  recorder.stop();
  const Live live = recorder.live();
  stop(supervisor);

  Report report = judge(recorder.samples(), scenario, settings.seed);
  report.clock = settings.clock_name();
  report.real_time_factor = recorder.real_time_factor();
  report.guests = look_at_guests(launch, recorder.series(), live);
  const bool met = all_met(report.figures.criteria);
  if (!ending.failed.empty()) {
    report.result = ending.failed;
  } else if (ending.interrupted) {
    report.result = "interrupted";
  } else {
    report.result = result_of(report, live.robot_stopped);
  }
  if (!settings.in_process) launch.lock().set_ended(report.result);
  try {
    const std::string text = to_json(report).dump(2) + "\n";
    write_text(launch.out() / "report.json", text);
    if (recording != nullptr) end_recording(*recording, report, text);
  } catch (const std::exception& error) {
    // what ended the run comes first
    throw ProcessFailure(ending.details.empty() ? error.what()
                                                : ending.details + "\n" + error.what());
  }
  std::string missing;
  if (settings.pictures) {
    missing = draw_pictures(launch.out(), recorder.series(), task, report.figures,
                            fmt::format("{} ({})", scenario.name, settings.clock_name()));
  }

  for (const wire::RefusedCount& refused : live.refused) {
    fmt::print(stderr, "c3rt: the recorder refused {} samples of {} ({}) from {}: {}\n",
               refused.count, refused.topic, reason_name(refused.reason), refused.from,
               refused.latest);
  }
  fmt::print("\n{}", summary(report));
  if (!missing.empty()) fmt::print(stderr, "c3rt: {}\n", missing);
  fmt::print("  {:<22}{}\n", settings.pictures ? "report and pictures" : "report",
             launch.out().string());
  std::fflush(stdout);
  if (!ending.failed.empty()) {
    fmt::print(stderr, "c3rt: error: {}\n", ending.details);
    return kProcessFailed;
  }
  return met && !ending.interrupted && !live.robot_stopped ? kDone : kCriterionFailed;
}

}  // namespace c3rt::cli
