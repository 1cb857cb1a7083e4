#include "cli/latency/latency.hpp"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sched.h>
#include <sys/utsname.h>

#include "cli/example/scenario.hpp"
#include "cli/exit_status.hpp"
#include "cli/latency/hop.hpp"
#include "cli/latency/report.hpp"
#include "cli/latency/wakeup.hpp"
#include "cli/launch.hpp"
#include "cli/paths.hpp"
#include "cli/progress.hpp"
#include "cli/watch.hpp"
#include "idl/process.hpp"
#include "idl/security.hpp"
#include "plant_emulator/errors.hpp"

namespace c3rt::cli::latency {
namespace {

// of the whole time: the machine alone, DDS; the rest is the processes'
constexpr double kAlone = 1.0 / 6.0, kDds = 1.0 / 6.0;

bool stopped() { return wire::StopFlag::requested(); }

LaunchSettings launch_settings(const Settings& settings) {
  if (is_example(scenario_path(settings.scenario)))
    throw UsageError("latency: " + settings.scenario +
                     " is a numerical example: it has no processes to measure");
  LaunchSettings launch;
  launch.verb = "latency";
  launch.scenario = settings.scenario;
  launch.out = settings.out.empty() ? new_folder("latency").string() : settings.out;
  launch.any_domain = settings.domain == "any";
  if (!launch.any_domain) launch.domain = static_cast<std::uint32_t>(std::stoul(settings.domain));
  launch.dds_profile = settings.profile;
  return launch;
}

void describe_machine(Report& report) {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) report.cores = CPU_COUNT(&set);
  utsname name{};
  if (uname(&name) == 0) report.kernel = name.release;
  std::ifstream clock("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  std::getline(clock, report.clock_source);
}

/// With the samples for the picture.
Row row(const std::string& key, const char* stage, const std::string& name,
        std::vector<double> samples) {
  Row result{key, stage, name, distribution(samples), std::move(samples)};
  return result;
}
/// Of what a process tells of itself.
Row row(const char* key, const char* name, const wire::Quantiles& q) {
  Distribution times;
  times.count = q.count;
  if (q.count > 0) {
    times.p50 = q.p50_s;
    times.p95 = q.p95_s;
    times.p99 = q.p99_s;
    times.p999 = q.p999_s;
    times.max = q.max_s;
  }
  return {key, kProcessStage, name, times, {}};
}

/// Measures in three stages; each leaves its part of the report.
class Measurement {
 public:
  explicit Measurement(const Settings& settings)
      : settings_(settings),
        launch_(launch_settings(settings)),
        priority_(launch_.scenario().impedance.thread.fifo_priority) {
    report_.scenario = launch_.scenario().name;
    report_.profile = settings.profile;
    report_.duration = settings.duration;
    report_.load = settings.load;
    describe_machine(report_);
  }

  int run() {
    // before this process has a thread
    EchoProcess echo(launch_.bus(), priority_);
    std::optional<EchoProcess> plain;
    if (secure_) plain.emplace(plain_bus(), priority_);
    launch_.require_free_bus();
    const Load load(settings_.load);
    fmt::print(stderr, "c3rt latency: {:g} s, results in {}\n", settings_.duration,
               launch_.out().string());
    {
      Progress progress("latency");
      progress_ = &progress;
      machine_alone();
      if (!stopped()) dds(echo, launch_.bus(), secure_ ? 0.5 : 1.0, "");
      echo.end();
      if (plain && !stopped()) dds(*plain, plain_bus(), 0.5, "_plain");
      plain.reset();
      if (!stopped()) processes();
      progress_ = nullptr;
    }
    if (stopped() || ending_.interrupted) {
      fmt::print(stderr, "c3rt latency: interrupted, there is no report\n");
      launch_.lock().set_ended("interrupted");
      return kCriterionFailed;
    }
    if (!ending_.failed.empty()) {
      launch_.lock().set_ended(ending_.failed);
      throw ProcessFailure(ending_.details);
    }
    return finish();
  }

 private:
  void show(double share, const char* stage) { progress_->update(share, stage); }

  void machine_alone() {
    const double duration = kAlone * settings_.duration;
    WakeupProbe probe(duration, priority_);
    const double end = seconds_now() + duration;
    while (seconds_now() < end && !stopped()) {
      show(kAlone * (1.0 - (end - seconds_now()) / duration), "the machine alone");
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    const WakeupRecord record = probe.stop();
    report_.measured.refused = record.refused;
    report_.real_time = record.refused.empty() && priority_ > 0;
    report_.rows.push_back(row("alone_wakeup_loop", kAloneStage, "wake-up of a 1 kHz loop",
                               latencies_of(record.loop)));
    report_.measured.wakeup = report_.rows.back().times;
    report_.rows.push_back(row("alone_wakeup_reference", kAloneStage, "wake-up of the reference",
                               record.reference_latencies()));
    report_.measured.reference = report_.rows.back().times;
  }

  /// The same profile without its keys, from a file among the results.
  wire::BusSettings plain_bus() const {
    wire::BusSettings bus = launch_.bus();
    const std::filesystem::path file = launch_.out() / "plain_profile.xml";
    write_text(file, wire::without_keys(read_text(bus.profile_uri)));
    bus.profile_uri = file.string();
    return bus;
  }

  /// @param part of the stage's time
  /// @param suffix of the rows' keys: "_plain" for the profile without keys
  void dds(EchoProcess& echo, const wire::BusSettings& bus, double part,
           const std::string& suffix) {
    HopRecord record =
        measure_hops(bus, echo, part * kDds * settings_.duration, priority_, stopped,
                     [&](double share) { show(kAlone + kDds * share, "DDS there and back"); });
    if (stopped()) return;
    if (record.died) throw ProcessFailure("latency: the other end of the ping has died");
    if (!record.answered)
      throw ProcessFailure("latency: the other end of the ping was not found on domain " +
                           std::to_string(launch_.bus().domain));
    report_.pings += record.sent;
    report_.pings_lost += record.lost;
    const char* without = suffix.empty() ? "" : ", without keys";
    report_.rows.push_back(row("hop" + suffix, kDdsStage,
                               std::string("state there, command back, as the servo") + without,
                               std::move(record.layer)));
    report_.rows.push_back(row("hop_raw" + suffix, kDdsStage,
                               std::string("the same by DDS alone") + without,
                               std::move(record.raw)));
    if (suffix.empty()) report_.measured.hop_raw = report_.rows.back().times;
  }

  void processes() {
    const double duration = (1.0 - kAlone - kDds) * settings_.duration;
    const config::Scenario& scenario = launch_.scenario();
    Supervisor supervisor;
    // nothing but the time ends it
    Recorder recorder(launch_.bus(),
                      {scenario.task.motion, std::numeric_limits<int>::max(), duration});
    launch_.start(supervisor, true);
    std::optional<WakeupProbe> probe;
    ending_ = watch(supervisor, recorder, [&](const Live& live) {
      // the processes' start is no part of it
      if (live.any && !probe) probe.emplace(duration, priority_);
      show(kAlone + kDds + (1.0 - kAlone - kDds) * live.time / duration, "the four processes");
    });
    const WakeupRecord record = probe ? probe->stop() : WakeupRecord{};
    recorder.stop();
    const Live live = recorder.live();
    stop(supervisor);
    add_processes(recorder.series(), live, record);
  }

  void add_processes(const Series& series, const Live& live, const WakeupRecord& record) {
    Measured& measured = report_.measured;
    report_.rows.push_back(
        row("wakeup_loop", kProcessStage, "wake-up of a 1 kHz loop", latencies_of(record.loop)));
    report_.rows.push_back(row("wakeup_reference", kProcessStage, "wake-up of the reference",
                               record.reference_latencies()));
    if (const auto& servo = live.services[c3rt_v2_PROCESS_IMPEDANCE]) {
      report_.rows.push_back(row("servo_wakeup", "wake-up of the servo, from the state's arrival",
                                 servo->wakeup_latency));
      report_.rows.push_back(row("servo_compute", "servo compute", servo->compute));
      measured.servo_compute = report_.rows.back().times;
    }
    const Latencies times = cli::latencies(series);
    report_.rows.push_back(row("state_to_command", kProcessStage, "state to command",
                               {times.state_to_command.begin(), times.state_to_command.end()}));
    measured.state_to_command = report_.rows.back().times;
    report_.rows.push_back(row("exposure_to_plan", kProcessStage, "exposure to plan",
                               {times.exposure_to_plan.begin(), times.exposure_to_plan.end()}));
    report_.rows.push_back(row("exposure_to_torque", kProcessStage, "exposure to torque",
                               {times.exposure_to_torque.begin(), times.exposure_to_torque.end()}));
    measured.success = success_rate(series);
    measured.stalls = stalls(record.references);
    measured.missed = missed_cycles(series, measured.stalls,
                                    record.loop.empty() ? 0 : record.loop.front().deadline_ns);
    std::uint64_t errors = 0;
    for (const StateRow& state : series.state) {
      if (state.reflex) errors |= state.errors;
    }
    measured.reflexes = plant::names(errors);
    report_.loop = record.loop;
    for (const std::vector<Wakeup>& reference : record.references)
      report_.reference.insert(report_.reference.end(), reference.begin(), reference.end());
  }

  int finish() {
    report_.judgement = judge(report_.measured);
    launch_.lock().set_ended(report_.judgement.sentence);
    const std::string json = to_json(report_).dump(2) + "\n";
    write_text(launch_.out() / "latency.json", json);
    const std::string missing = draw(launch_.out() / "latency.png", report_);
    fmt::print("{}", settings_.json ? json : text(report_));
    if (!settings_.json) fmt::print("report and picture: {}\n", launch_.out().string());
    if (!missing.empty()) fmt::print(stderr, "c3rt: {}\n", missing);
    return report_.judgement.good ? kDone : kCriterionFailed;
  }

  const Settings settings_;
  Launch launch_;
  const int priority_;
  const bool secure_ = wire::is_secure(read_text(launch_.bus().profile_uri));
  Report report_;
  Ending ending_;
  Progress* progress_ = nullptr;
};

}  // namespace

int run(const Settings& settings) { return Measurement(settings).run(); }

}  // namespace c3rt::cli::latency
