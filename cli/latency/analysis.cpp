#include "cli/latency/analysis.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cli/report/text_table.hpp"
#include "controller/base/quantile.hpp"
#include "controller/base/time.hpp"

namespace c3rt::cli::latency {
namespace {

// libfranka's limits of the average; 20 of the last 100 lost stop the robot when they are in a row
constexpr double kGoodAverage = 0.95, kPoorAverage = 0.90, kLeast = 0.80;
constexpr std::int64_t kWindow_ns = 100'000'000;  // of 100 commands
// what c3rt promises of itself
constexpr double kWakeupRatio = 1.2, kCompute_s = 100e-6, kMissedShare = 1e-4;
// over two hops of DDS alone and the computation between them
constexpr double kAnswerP50Ratio = 1.5, kAnswerP99Ratio = 2.0;
// a reference that is later in a thousandth of its cycles leaves the servo half of its own
constexpr double kLateReference_s = 1e-9 * static_cast<double>(kStall_ns);

std::string microseconds(double value_s) { return fmt::format("{:.0f} µs", 1e6 * value_s); }

std::vector<std::string> causes(const Measured& m) {
  std::vector<std::string> all;
  if (!m.refused.empty())
    all.push_back(m.refused + ": the 1 kHz threads ran as ordinary ones (c3rt doctor)");
  if (!m.stalls.empty()) {
    std::int64_t longest_ns = 0;
    for (const Stall& stall : m.stalls)
      longest_ns = std::max(longest_ns, stall.end_ns - stall.begin_ns);
    all.push_back(fmt::format(
        "{} time{} a reference thread of the same priority was not woken for more than {}, the "
        "longest {} ms: the machine or a more urgent thread had its core",
        m.stalls.size(), m.stalls.size() == 1 ? "" : "s", microseconds(kLateReference_s),
        shown(1e3 * base::seconds(longest_ns), 3)));
  }
  if (m.reference.p999 > kLateReference_s) {
    all.push_back("the machine alone woke the reference threads later than " +
                  microseconds(m.reference.p999) + " in one of a thousand cycles");
  }
  if (m.missed.missed > m.missed.within_stalls) {
    all.push_back(
        fmt::format("{} of {} cycles were missed while every reference thread was "
                    "punctual: processes or bus were too slow",
                    m.missed.missed - m.missed.within_stalls, m.missed.cycles));
  }
  return all;
}

std::string sentence(const Measured& m, bool good) {
  const std::string rate =
      fmt::format("of the last 100 commands {:.1f} came in time on average, {:.0f} at worst",
                  100.0 * m.success.average, 100.0 * m.success.minimum);
  if (m.success.states == 0)
    return "not good for 1 kHz: the arm never tracked a plan, so nothing was measured";
  if (!m.reflexes.empty())
    return "not good for 1 kHz: the robot stopped (" + m.reflexes + "); " + rate;
  if (good) return "good for 1 kHz: " + rate;
  if (m.success.average < kPoorAverage)
    return "not good for 1 kHz: " + rate + ", probably not sufficient for a real robot";
  if (m.success.average < kGoodAverage)
    return "not good for 1 kHz: " + rate + ", many commands are lost";
  return "not good for 1 kHz: " + rate + ", as few at worst as when the robot stops";
}

}  // namespace

Distribution distribution(std::vector<double> samples) {
  Distribution result;
  result.count = samples.size();
  if (samples.empty()) return result;
  std::sort(samples.begin(), samples.end());
  result.p50 = base::quantile_nearest(samples, 0.5);
  result.p95 = base::quantile_nearest(samples, 0.95);
  result.p99 = base::quantile_nearest(samples, 0.99);
  result.p999 = base::quantile_nearest(samples, 0.999);
  result.max = samples.back();
  return result;
}

std::vector<double> latencies_of(const std::vector<Wakeup>& wakeups) {
  std::vector<double> all;
  all.reserve(wakeups.size());
  for (const Wakeup& wakeup : wakeups) all.push_back(base::seconds(wakeup.latency_ns));
  return all;
}

std::vector<Stall> stalls(const std::vector<std::vector<Wakeup>>& threads) {
  std::vector<Stall> all;
  for (const std::vector<Wakeup>& thread : threads) {
    for (const Wakeup& wakeup : thread) {
      if (wakeup.latency_ns > kStall_ns)
        all.push_back({wakeup.deadline_ns, wakeup.deadline_ns + wakeup.latency_ns});
    }
  }
  std::sort(all.begin(), all.end(),
            [](const Stall& a, const Stall& b) { return a.begin_ns < b.begin_ns; });
  std::vector<Stall> apart;
  for (const Stall& stall : all) {
    if (apart.empty() || stall.begin_ns > apart.back().end_ns) {
      apart.push_back(stall);
    } else {
      apart.back().end_ns = std::max(apart.back().end_ns, stall.end_ns);
    }
  }
  return apart;
}

SuccessRate success_rate(const Series& series) {
  SuccessRate result;
  const CommandRow* const first = first_tracking(series);
  if (first == series.command.end()) return result;
  double sum = 0.0;
  for (const StateRow& state : series.state) {
    if (state.time_ns < first->time_ns + kWindow_ns) continue;
    ++result.states;
    sum += state.success_rate;
    if (result.minimum <= state.success_rate) continue;
    result.minimum = state.success_rate;
    result.minimum_ns = state.time_ns;
  }
  if (result.states > 0) result.average = sum / static_cast<double>(result.states);
  return result;
}

double MissedCycles::share_outside() const {
  return cycles == 0 ? kNone
                     : static_cast<double>(missed - within_stalls) / static_cast<double>(cycles);
}

MissedCycles missed_cycles(const Series& series, const std::vector<Stall>& stalls,
                           std::int64_t from_ns) {
  MissedCycles result;
  const CommandRow* const first = first_tracking(series);
  if (first == series.command.end()) return result;
  std::vector<std::int64_t> answered;
  answered.reserve(series.command.size());
  for (const CommandRow& command : series.command) answered.push_back(command.state_ns);
  std::sort(answered.begin(), answered.end());
  for (const StateRow& state : series.state) {
    // after the last answer the recording ends, not the servo
    if (state.time_ns < std::max(first->time_ns, from_ns) || state.time_ns > answered.back())
      continue;
    ++result.cycles;
    if (std::binary_search(answered.begin(), answered.end(), state.time_ns)) continue;
    ++result.missed;
    // the first that ends no earlier than just before the state
    const auto near = std::lower_bound(
        stalls.begin(), stalls.end(), state.time_ns - kNearStall_ns,
        [](const Stall& stall, std::int64_t time_ns) { return stall.end_ns < time_ns; });
    if (near != stalls.end() && near->begin_ns <= state.time_ns + kNearStall_ns) {
      ++result.within_stalls;
    } else {
      result.outside_ns.push_back(state.time_ns);
    }
  }
  return result;
}

Judgement judge(const Measured& m) {
  Judgement result;
  const auto at_least = [](const char* name, double value, double limit) {
    return CriterionResult{name, value, limit, value >= limit};
  };
  const auto at_most = [](const char* name, double value, double limit) {
    return CriterionResult{name, value, limit, value <= limit};
  };
  result.robot = {at_least("success_rate_average", m.success.average, kGoodAverage),
                  at_least("success_rate_minimum", m.success.minimum, kLeast),
                  at_most("robot_stopped", m.reflexes.empty() ? 0.0 : 1.0, 0.0)};
  result.program = {
      at_most("wakeup_p99_over_reference", m.wakeup.p99 / m.reference.p99, kWakeupRatio),
      at_most("servo_compute_p99_s", m.servo_compute.p99, kCompute_s),
      at_most("missed_cycles_outside_stalls", m.missed.share_outside(), kMissedShare),
      at_most("state_to_command_p50_over_hops",
              m.state_to_command.p50 / (2.0 * m.hop_raw.p50 + m.servo_compute.p50),
              kAnswerP50Ratio),
      at_most("state_to_command_p99_over_hops",
              m.state_to_command.p99 / (2.0 * m.hop_raw.p99 + m.servo_compute.p99),
              kAnswerP99Ratio)};
  result.good = std::all_of(result.robot.begin(), result.robot.end(),
                            [](const CriterionResult& criterion) { return criterion.met; });
  result.sentence = sentence(m, result.good);
  result.causes = causes(m);
  return result;
}

}  // namespace c3rt::cli::latency
