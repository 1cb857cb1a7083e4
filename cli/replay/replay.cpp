#include "cli/replay/replay.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include "cli/exit_status.hpp"
#include "cli/lock.hpp"
#include "cli/look.hpp"
#include "cli/neighbours.hpp"
#include "cli/paths.hpp"
#include "cli/recorded.hpp"
#include "cli/recording/in_order.hpp"
#include "cli/replay/comparison.hpp"
#include "cli/replay/overview.hpp"
#include "cli/replay/publisher.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/security.hpp"

namespace c3rt::cli::replay {
namespace {

constexpr double kLookForPlant = 3.0;  // until its session must have been heard [s]

Overview overview_of(const Settings& settings) {
  try {
    return look_over(settings.file);
  } catch (const mcap::Error& error) {
    throw UsageError(error.what());
  }
}

template <typename List>
std::string joined(const List& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

/// A topic that only one may write: a second one is refused by every reader.
bool has_one_writer(const wire::Topic& topic) {
  return topic.writer.has_value() || topic.qos == wire::Qos::kStatus;
}

/// Nobody wants again what was asked of a process, unless it is asked for.
bool asks(const wire::Topic& topic) {
  return &topic == &wire::topic<wire::ServiceRequest>() ||
         &topic == &wire::topic<wire::ServiceReply>() ||
         &topic == &wire::topic<wire::FaultInject>() || &topic == &wire::topic<wire::RobotOrder>();
}

/// Those of the recording that are wanted. @throws UsageError for one that it does not have
std::set<std::string> wanted_topics(const Settings& settings, const Overview& overview) {
  std::set<std::string> recorded, wanted;
  for (const auto& [topic, count] : overview.contents.samples) recorded.insert(topic);
  for (const std::string& topic : settings.topics) {
    if (!wire::with_topic(topic, [](const auto&) {})) unknown_topic(topic);
    if (recorded.count(topic) == 0)
      throw UsageError(
          fmt::format("{} has no {}; it has {}", settings.file, topic, joined(recorded)));
    wanted.insert(topic);
  }
  if (!wanted.empty()) return wanted;
  for (const wire::Topic& topic : wire::table::kTopics) {
    if (recorded.count(topic.name) > 0 && !asks(topic)) wanted.insert(topic.name);
  }
  return wanted;
}

/// The topics of these that a stranger writes and nobody else may, with who it is.
std::map<std::string, Neighbour> taken(const wire::Bus& bus, const std::set<std::string>& topics) {
  std::map<std::string, Neighbour> result;
  const std::map<std::string, Neighbour> all = writers(bus);
  for (const wire::Topic& topic : wire::table::kTopics) {
    const auto writer = all.find(topic.name);
    if (topics.count(topic.name) > 0 && has_one_writer(topic) && writer != all.end())
      result.insert(*writer);
  }
  return result;
}

std::map<std::string, Neighbour> look_for_writers(const wire::Bus& bus,
                                                  const std::set<std::string>& topics) {
  const double until = 1e-9 * static_cast<double>(rt::now_ns()) + kLookForNeighbours;
  while (1e-9 * static_cast<double>(rt::now_ns()) < until && !wire::StopFlag::requested())
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return taken(bus, topics);
}

/// Tells others on this host of what it plays, as a run does: `c3rt view` finds its scenario.
std::unique_ptr<DomainLock> lock_of(const Seat& seat, const wire::BusSettings& bus,
                                    const Overview& overview) {
  Instance self;
  self.pid = getpid();
  self.verb = "replay";
  self.scenario = text_of(overview.contents, kRunMetadata, "scenario");
  const std::string file = text_of(overview.contents, kRunMetadata, "file");
  if (access(file.c_str(), R_OK) == 0) self.file = file;
  self.overrides = overrides_of(overview.contents);
  self.clock = "realtime";
  self.session = bus.session_id;
  self.seed = seed_of(overview.contents);
  self.profile = bus.profile_uri;
  self.started = fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::localtime(std::time(nullptr)));
  return std::make_unique<DomainLock>(runtime_directory(), seat.domain, self);
}

/// The session that others are in, of a plant that no instance of ours tells.
std::uint64_t session_heard(const wire::BusSettings& settings) {
  wire::Bus bus(settings);
  wire::Reader<wire::RobotState> states(bus);
  const std::int64_t until_ns = rt::now_ns() + static_cast<std::int64_t>(kLookForPlant * 1e9);
  wire::RobotState state{};
  while (!states.take(state) && rt::now_ns() < until_ns && !wire::StopFlag::requested())
    bus.wait_for_data(50'000'000);
  return bus.session_id();
}

int feed(const Seat& seat, const Settings& settings) {
  wire::BusSettings bus_of = bus_settings(seat);
  if (wire::is_secure(read_text(bus_of.profile_uri)))
    throw UsageError(
        "on a secure bus nobody but a process may write what it writes: replay on the "
        "profile loopback or lan");
  const auto instance = holder(runtime_directory(), seat.domain);
  if (bus_of.clock == wire::ClockMode::kLockstep)
    throw UsageError(
        fmt::format("domain {} is in lockstep: nobody joins it in realtime", seat.domain));
  const Overview overview = overview_of(settings);
  if (wire::StopFlag::requested()) return kCriterionFailed;
  tell_of(overview.contents, settings.file);
  std::set<std::string> topics = wanted_topics(settings, overview);

  std::unique_ptr<DomainLock> lock;
  if (!instance) {
    wire::BusSettings look = bus_of;
    look.session_id = 0;
    const wire::Bus bus(look);
    const bool plant = look_for_writers(bus, {"robot/state"}).count("robot/state") > 0;
    bus_of.session_id = plant ? session_heard(look) : wire::draw_session();
    lock = lock_of(seat, bus_of, overview);
  }
  wire::Bus bus(bus_of);
  for (const auto& [topic, who] : look_for_writers(bus, topics)) {
    if (!settings.topics.empty())
      throw UsageError(
          fmt::format("{} writes {} on domain {} already: end it, or leave the topic "
                      "out of --topics",
                      who.text(), topic, seat.domain));
    fmt::print(stderr, "c3rt: {} is left out: {} writes it\n", topic, who.text());
    topics.erase(topic);
  }
  if (topics.empty())
    throw UsageError(
        fmt::format("every topic of {} has a writer on domain {}", settings.file, seat.domain));
  Publisher publisher(bus, topics, settings.rate, overview.begin_ns, overview.end_ns);
  publisher.set_watch([&]() -> std::string {
    const auto others = taken(bus, topics);
    if (others.empty()) return "";
    return others.begin()->second.text() + " writes " + others.begin()->first + " now";
  });
  fmt::print("{}: {:.1f} s of {} on domain {}\n", settings.file, overview.duration(),
             joined(topics), seat.domain);
  std::fflush(stdout);
  look_for_writers(bus, {});  // readers find the writers meanwhile
  publisher.begin();
  InOrder in_order(publisher, overview.begin_ns);
  play(settings.file, in_order);
  in_order.finish();
  publisher.end();

  std::uint64_t written = 0;
  for (const auto& [topic, count] : publisher.written()) written += count;
  const bool whole = publisher.failure().empty() && !wire::StopFlag::requested();
  std::string end = fmt::format("{} samples", written);
  if (publisher.not_sent() > 0) end += fmt::format(", {} could not be sent", publisher.not_sent());
  if (settings.rate > 0.0) end += fmt::format(", at most {:.1f} ms late", 1e3 * publisher.latest());
  if (!whole) end += fmt::format("; ended after {:.1f} s of it", publisher.passed());
  fmt::print("{}\n", end);
  if (!publisher.failure().empty()) fmt::print(stderr, "c3rt: error: {}\n", publisher.failure());
  if (lock) lock->set_ended(whole ? "played" : "ended early");
  return whole ? kDone : kCriterionFailed;
}

wire::Process process_of(const std::string& name) {
  for (const wire::Process process :
       {c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION, c3rt_v2_PROCESS_IMPEDANCE}) {
    if (name == wire::process_name(process)) return process;
  }
  throw UsageError("no process to compare: " + name);
}

void print(const ComparisonResult& result) {
  fmt::print("  {:<18}{:>10}{:>10}{:>20}\n", "topic", "recorded", "given", "same to the bit");
  for (const TopicResult& topic : result.topics) {
    if (topic.recorded + topic.given == 0) continue;
    fmt::print("  {:<18}{:>10}{:>10}{:>20}\n", topic.topic, topic.recorded, topic.given,
               topic.same);
  }
  if (result.first.empty()) return;
  fmt::print("the first that is not the same: {}\n", result.first);
  if (result.fields.empty()) return;
  fmt::print("  {:<18}{:<32}{:>10}{:>22}{:>12}\n", "topic", "field", "answers",
             "largest difference", "in number");
  for (const FieldResult& field : result.fields) {
    fmt::print("  {:<18}{:<32}{:>10}{:>22}{:>12}\n", field.topic, field.field, field.answers,
               field.largest > 0.0 ? fmt::format("{:.3g}", field.largest) : "", field.largest_seq);
  }
}

int compare(const Settings& settings) {
  const wire::Process process = process_of(settings.compare);
  const Overview overview = overview_of(settings);
  if (wire::StopFlag::requested()) return kCriterionFailed;
  tell_of(overview.contents, settings.file);
  const bool realtime = text_of(overview.contents, kRunMetadata, "clock") != "lockstep";
  if (realtime && process == c3rt_v2_PROCESS_IMPEDANCE)
    throw UsageError(
        "impedance: of a recording in lockstep alone; in realtime nobody has recorded "
        "when it acted");
  const config::Scenario scenario =
      scenario_of(overview.contents, settings.file, settings.scenario, settings.overrides);
  const std::uint64_t seed = settings.seed ? *settings.seed : seed_of(overview.contents);
  if (overview.of_other_sessions > 0)
    fmt::print(stderr, "c3rt: {} samples are of other sessions than the first: left out\n",
               overview.of_other_sessions);
  if (overview.first_state > 1)
    fmt::print(stderr,
               "c3rt: the recording begins after its run (robot/state {}): what the {} remembered "
               "then is not known\n",
               overview.first_state, settings.compare);
  ComparisonResult result;
  {
    Comparison comparison(scenario, process, seed, overview, realtime);
    InOrder in_order(comparison, overview.begin_ns, comparison.shifts());
    play(settings.file, in_order);
    in_order.finish();
    result = comparison.finish();
  }
  if (wire::StopFlag::requested()) {
    fmt::print("interrupted\n");
    return kCriterionFailed;
  }
  if (result.recorded() == 0)
    throw UsageError(fmt::format("{} has no answers of the {}", settings.file, settings.compare));
  fmt::print("{} of {} (seed {}, {}): {}\n", settings.compare, scenario.name, seed,
             realtime ? "realtime" : "lockstep",
             result.all_same() ? "every answer is the same to the bit" : "answers differ");
  print(result);
  return result.all_same() ? kDone : kCriterionFailed;
}

}  // namespace

int run(const Seat& seat, const Settings& settings) {
  return settings.compare.empty() ? feed(seat, settings) : compare(settings);
}

}  // namespace c3rt::cli::replay
