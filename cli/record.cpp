#include "cli/record.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_status.hpp"
#include "cli/judge.hpp"
#include "cli/lock.hpp"
#include "cli/look.hpp"
#include "cli/paths.hpp"
#include "cli/progress.hpp"
#include "cli/recorded.hpp"
#include "cli/recording/export.hpp"
#include "cli/recording/recording.hpp"
#include "cli/recording/samples.hpp"
#include "cli/recording/taken_topics.hpp"
#include "cli/report/pictures.hpp"
#include "cli/report/report.hpp"
#include "cli/series.hpp"
#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace fs = std::filesystem;
namespace {

using base::seconds;

constexpr auto kPoll = std::chrono::milliseconds(10);
constexpr const char* kClients = "clients";  // of report.json
constexpr double kMebibyte = 1024.0 * 1024.0;

template <typename... T>
std::uint64_t lost_of(TakenTopics<std::tuple<T...>>& topics) {
  std::uint64_t lost = 0;
  topics.for_each([&lost](auto& topic) { lost += topic.reader.counters().lost; });
  return lost;
}

std::string counted(const Recording& recording, std::uint64_t lost) {
  return fmt::format("{} samples, {:.1f} MiB, {} lost", recording.samples(),
                     static_cast<double>(recording.bytes()) / kMebibyte, lost);
}

/// Keeps what the report needs.
class Keeping final : public Listener {
 public:
#define C3RT_TOPIC(Type, ...) \
  void hear(const wire::Type& sample) override { samples.add(sample); }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  Samples samples;
};

/// What clients did wrong that played a process stands in the run's own report alone.
void keep_clients(const Contents& contents, nlohmann::ordered_json& report) {
  const auto text = contents.attachments.find(kReportAttachment);
  if (text == contents.attachments.end()) return;
  const auto of_run = nlohmann::ordered_json::parse(text->second, nullptr, false);
  if (of_run.is_object() && of_run.contains(kClients)) report[kClients] = of_run[kClients];
}

bool ends_in_reflex(const Series& series) {
  return !series.state.empty() && series.state.back().reflex;
}

}  // namespace

int record(const Seat& seat, const RecordSettings& settings) {
  const fs::path file = settings.file;
  if (fs::exists(file)) throw UsageError(file.string() + " is there already");
  wire::Bus bus(bus_settings(seat));
  std::unique_ptr<Recording> recording;
  try {
    recording = std::make_unique<Recording>(file);
  } catch (const mcap::Error& error) {
    throw UsageError(error.what());
  }
  const auto instance = holder(runtime_directory(), seat.domain);
  if (instance && !instance->file.empty()) {
    tell(*recording, {instance->scenario, instance->file, instance->overrides, instance->seed,
                      instance->clock});
  }
  TakenTopics<wire::TopicTypes> topics(bus);
  const auto now = [] { return seconds(rt::now_ns()); };
  const double begun = now();
  double heard = begun;
  {
    Progress progress("record");
    while (!wire::StopFlag::requested()) {
      const std::uint64_t before = recording->samples();
      topics.for_each([&](auto& topic) { topic.drain({nullptr, recording.get(), nullptr}); });
      const double time = now();
      if (recording->samples() != before) heard = time;
      if (settings.timeout_s > 0.0 && time - heard > settings.timeout_s) break;
      if (settings.duration_s > 0.0 && time - begun >= settings.duration_s) break;
      progress.update(counted(*recording, lost_of(topics)));
      std::this_thread::sleep_for(kPoll);
    }
  }
  recording->finish();
  if (recording->samples() == 0) {
    fs::remove(file);
    fmt::print(stderr, "c3rt: error: nobody wrote anything on domain {}; is an instance up?\n",
               seat.domain);
    return kCriterionFailed;
  }
  const std::uint64_t lost = lost_of(topics);
  fmt::print("{}: {}\n", file.string(), counted(*recording, lost));
  return lost > 0 ? kCriterionFailed : kDone;
}

int report_recording(const ReportSettings& settings) {
  Keeping keeping;
  Contents contents;
  try {
    contents = play(settings.file, keeping);
  } catch (const mcap::Error& error) {
    throw UsageError(error.what());
  }
  tell_of(contents, settings.file);
  const config::Scenario scenario =
      scenario_of(contents, settings.file, settings.scenario, settings.overrides);
  const std::uint64_t seed = settings.seed ? *settings.seed : seed_of(contents);
  Report report = judge(keeping.samples, scenario, seed);
  report.clock = text_of(contents, kRunMetadata, "clock");
  report.result = text_of(contents, kResultMetadata, "result");
  if (report.result.empty())
    report.result = result_of(report, ends_in_reflex(keeping.samples.series()));
  const std::string factor = text_of(contents, kResultMetadata, "real_time_factor");
  if (!factor.empty()) report.real_time_factor = std::strtod(factor.c_str(), nullptr);
  fmt::print("{}", summary(report));
  if (!settings.series.empty()) {
    const fs::path folder = make_folder(settings.series);
    write_series(folder, keeping.samples.series(), scenario.task.motion.seeded(seed));
    fmt::print("  {:<22}{}\n", "series", folder.string());
  }
  if (!settings.out.empty()) {
    const fs::path out = make_folder(settings.out);
    nlohmann::ordered_json json = to_json(report);
    keep_clients(contents, json);
    write_text(out / "report.json", json.dump(2) + "\n");
    const std::string missing =
        draw_pictures(out, keeping.samples.series(), scenario.task.motion.seeded(seed),
                      report.figures, fmt::format("{} ({})", scenario.name, report.clock));
    if (!missing.empty()) fmt::print(stderr, "c3rt: {}\n", missing);
    fmt::print("  {:<22}{}\n", "report and pictures", out.string());
  }
  return report.result == "passed" ? kDone : kCriterionFailed;
}

int export_recording(const std::string& file, const std::vector<std::string>& topics,
                     const std::string& out) {
  for (const std::string& topic : topics) {
    if (!wire::with_topic(topic, [](const auto&) {})) unknown_topic(topic);
  }
  fs::path folder = out;
  if (out.empty()) {
    folder = file;
    folder.replace_extension("");
    folder += "_csv";
  }
  Contents contents;
  try {
    contents = write_csv(file, topics, make_folder(folder));
  } catch (const mcap::Error& error) {
    throw UsageError(error.what());
  }
  tell_of(contents, file);
  for (const auto& [topic, count] : contents.samples) {
    if (topics.empty() || std::find(topics.begin(), topics.end(), topic) != topics.end())
      fmt::print("{:<18}{:>10} samples\n", topic, count);
  }
  fmt::print("{}\n", folder.string());
  return kDone;
}

}  // namespace c3rt::cli
