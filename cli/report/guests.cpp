#include "cli/report/guests.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/report/json.hpp"
#include "controller/base/time.hpp"

namespace c3rt::cli {
namespace {

using base::seconds;

/// One stream: when samples take effect, and when that was measured which they were made from.
struct Stamps {
  std::int64_t time_ns;
  std::int64_t from_ns;
};

/// Of each object or of the robot.
using Streams = std::map<int, std::vector<Stamps>>;

struct Kind {
  const char* topic;
  const char* stamp;  // the field that tells what a sample was made from
  const char* from;   // in words
  Streams (*streams)(const Series&);
};

Streams plans_of(const Series& series) {
  Streams streams;
  for (const PlanRow& row : series.plan) streams[0].push_back({row.time_ns, row.state_ns});
  return streams;
}
Streams estimates_of(const Series& series) {
  Streams streams;
  for (const EstimateRow& row : series.estimate)
    streams[row.object].push_back({row.time_ns, row.exposure_ns});
  return streams;
}
Streams commands_of(const Series& series) {
  Streams streams;
  for (const CommandRow& row : series.command) streams[0].push_back({row.time_ns, row.state_ns});
  return streams;
}

const std::map<std::string, Kind> kKinds{
    {"planner", {"plan", "origin.state_ns", "robot state", plans_of}},
    {"vision", {"object/estimate", "exposure_ns", "exposure", estimates_of}},
    {"impedance", {"robot/command", "origin.state_ns", "robot state", commands_of}}};

/// Longer gaps than are allowed, in one stream.
void tell_gaps(const std::vector<Stamps>& stream, const Series& series, const std::string& of,
               const GuestLimits& limits, std::vector<std::string>& problems) {
  const std::int64_t begin_ns = start_ns(series);
  int gaps = 0;
  std::int64_t longest_ns = 0, at_ns = 0;
  for (std::size_t i = 1; i < stream.size(); ++i) {
    const std::int64_t gap_ns = stream[i].time_ns - stream[i - 1].time_ns;
    if (seconds(gap_ns) > limits.longest_gap) ++gaps;
    if (gap_ns > longest_ns) {
      longest_ns = gap_ns;
      at_ns = stream[i - 1].time_ns;
    }
  }
  if (gaps > 0)
    problems.push_back(fmt::format(
        "rate: {} gap{} of more than {:g} s ({}), the longest {:.3f} s from {:.3f} s on{}", gaps,
        gaps == 1 ? "" : "s", limits.longest_gap, limits.gap_key, seconds(longest_ns),
        seconds(at_ns - begin_ns), of));
  const std::int64_t last_ns = stream.back().time_ns;
  const std::int64_t end_ns = series.state.empty() ? last_ns : series.state.back().time_ns;
  if (seconds(end_ns - last_ns) > limits.longest_gap)
    problems.push_back(fmt::format("silent: nothing came after {:.3f} s, for the last {:.3f} s{}",
                                   seconds(last_ns - begin_ns), seconds(end_ns - last_ns), of));
}

}  // namespace

Guest look_at_guest(const std::string& process, const Series& series, const GuestLimits& limits,
                    const std::vector<GuestRefusals>& refused) {
  const auto found = kKinds.find(process);
  if (found == kKinds.end())
    throw std::invalid_argument("guest: expected planner, vision or impedance, got " + process);
  const Kind& kind = found->second;
  Guest guest;
  guest.process = process;
  guest.topic = kind.topic;
  const Streams streams = kind.streams(series);
  std::vector<double> ages;
  std::uint64_t unstamped = 0, ahead = 0;
  for (const auto& [object, stream] : streams) {
    const std::string of = streams.size() > 1 ? fmt::format(", of object {}", object) : "";
    guest.samples += stream.size();
    tell_gaps(stream, series, of, limits, guest.problems);
    const double spoke = seconds(stream.back().time_ns - stream.front().time_ns);
    const double rate = spoke > 0.0 ? static_cast<double>(stream.size() - 1) / spoke : kNone;
    if (std::isfinite(rate) && !(guest.rate <= rate)) guest.rate = rate;  // the slowest object's
    for (const Stamps& sample : stream) {
      if (sample.from_ns <= 0) {
        ++unstamped;
      } else {
        ages.push_back(seconds(sample.time_ns - sample.from_ns));
        if (ages.back() < 0.0) ++ahead;
      }
    }
  }
  guest.age = spread(ages);
  if (guest.samples == 0) guest.problems.push_back("nothing of " + guest.topic + " was let in");
  if (unstamped > 0)
    guest.problems.push_back(
        fmt::format("stamps: {} of {} samples have no {}", unstamped, guest.samples, kind.stamp));
  if (ahead > 0)
    guest.problems.push_back(fmt::format(
        "stamps: {} of {} samples take effect before the {} that they say they were made from",
        ahead, guest.samples, kind.from));
  if (std::isfinite(guest.age.p99) && guest.age.p99 > limits.longest_gap)
    guest.problems.push_back(fmt::format(
        "late: in effect {:.3f} s after the {} that they were made from (p99; {} {:g} s)",
        guest.age.p99, kind.from, limits.gap_key, limits.longest_gap));
  for (const GuestRefusals& each : refused)
    guest.problems.push_back(fmt::format("refused: {} by {} ({}): {}", each.count, each.reader,
                                         each.reason, each.latest));
  return guest;
}

nlohmann::ordered_json to_json(const Guest& guest) {
  return {{"process", guest.process},      {"topic", guest.topic},
          {"samples", guest.samples},      {"rate_hz", number(guest.rate)},
          {"age_s", quantiles(guest.age)}, {"problems", guest.problems}};
}

}  // namespace c3rt::cli
