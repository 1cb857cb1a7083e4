#include "cli/latency/analysis.hpp"

#include <cmath>
#include <numeric>

#include <catch2/catch.hpp>

using namespace c3rt::cli;
using namespace c3rt::cli::latency;
using Catch::Contains;

namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A state every millisecond; each answered by a command, but for those that `missed` names.
template <typename Missed>
Series cycles(int count, Missed&& missed) {
  Series series;
  for (int i = 0; i < count; ++i) {
    StateRow state;
    state.time_ns = i * kMs;
    state.success_rate = 1.0;
    series.state.push_back(state);
    if (missed(i)) continue;
    CommandRow command;
    command.time_ns = state.time_ns + kMs / 5;
    command.state_ns = state.time_ns;
    command.tracking = true;
    series.command.push_back(command);
  }
  return series;
}

/// A machine and a run without a fault.
Measured quiet() {
  Measured m;
  m.wakeup.p99 = 55e-6;
  m.reference.p99 = 50e-6;
  m.reference.p999 = 90e-6;
  m.servo_compute.p50 = 30e-6;
  m.servo_compute.p99 = 40e-6;
  m.hop_raw.p50 = 60e-6;
  m.hop_raw.p99 = 100e-6;
  m.state_to_command.p50 = 210e-6;
  m.state_to_command.p99 = 430e-6;
  m.success = {40'000, 0.999, 0.97, 0};
  m.missed = {40'000, 3, 0, {}};
  return m;
}

bool met(const std::vector<CriterionResult>& criteria, const std::string& name) {
  for (const CriterionResult& criterion : criteria) {
    if (criterion.name == name) return criterion.met;
  }
  FAIL("no criterion " << name);
  return false;
}

}  // namespace

TEST_CASE(
    "latency: quantiles of 1 to 10000 are the samples of those ranks; of nothing there are none") {
  std::vector<double> samples(10'000);
  std::iota(samples.rbegin(), samples.rend(), 1.0);
  const Distribution d = distribution(samples);
  CHECK(d.count == 10'000);
  CHECK(d.p50 == 5000.0);
  CHECK(d.p95 == 9500.0);
  CHECK(d.p99 == 9900.0);
  CHECK(d.p999 == 9990.0);
  CHECK(d.max == 10'000.0);
  CHECK(distribution({}).count == 0);
  CHECK(std::isnan(distribution({}).p50));
}

TEST_CASE(
    "latency: a stall is a wake-up later than half a cycle; those of two threads that overlap are "
    "one") {
  const std::vector<Wakeup> one{{0, kStall_ns}, {10 * kMs, 4 * kMs}, {50 * kMs, 1 * kMs}};
  const std::vector<Wakeup> other{{12 * kMs, 5 * kMs}, {30 * kMs, kStall_ns + 1}};
  const std::vector<Stall> found = stalls({one, other});
  REQUIRE(found.size() == 3);
  CHECK(found[0].begin_ns == 10 * kMs);
  CHECK(found[0].end_ns == 17 * kMs);
  CHECK(found[1].begin_ns == 30 * kMs);
  CHECK(found[2].end_ns == 51 * kMs);
  CHECK(stalls({}).empty());
}

TEST_CASE(
    "latency: the success rate counts once 100 cycles lie behind the first command that tracks") {
  Series series = cycles(1000, [](int) { return false; });
  for (CommandRow& command : series.command) command.tracking = command.state_ns >= 500 * kMs;
  for (StateRow& state : series.state) {
    // half until 600 ms: of the few commands of a motion that has just begun; then 0.9 once, else 1
    state.success_rate = state.time_ns <= 600 * kMs ? 0.5 : state.time_ns == 700 * kMs ? 0.9 : 1.0;
  }
  const SuccessRate rate = success_rate(series);
  // the first command is written 0.2 ms after the state of 500 ms
  CHECK(rate.states == 399);
  CHECK(rate.minimum == 0.9);
  CHECK(rate.minimum_ns == 700 * kMs);
  CHECK(rate.average == Approx((398 * 1.0 + 0.9) / 399.0).epsilon(1e-12));
  CHECK(success_rate(Series{}).states == 0);
  CHECK(std::isnan(success_rate(Series{}).average));
}

TEST_CASE(
    "latency: a state without a command is a missed cycle, and near a stall it is the stall's") {
  // missed: 100 to 109, and 500 alone; a reference thread stalled from 98.5 to 108 ms
  const Series series = cycles(1000, [](int i) { return (i >= 100 && i < 110) || i == 500; });
  const std::vector<Stall> seen{{98 * kMs + kMs / 2, 108 * kMs}, {700 * kMs, 703 * kMs}};
  const MissedCycles missed = missed_cycles(series, seen);
  CHECK(missed.cycles == 999);  // the first state lies before the first command
  CHECK(missed.missed == 11);
  CHECK(missed.within_stalls == 10);
  CHECK(missed.outside_ns == std::vector<std::int64_t>{500 * kMs});
  CHECK(missed.share_outside() == Approx(1.0 / 999.0).epsilon(1e-12));
  CHECK(missed_cycles(series, {}).within_stalls == 0);
  // nobody watched before
  CHECK(missed_cycles(series, {}, 105 * kMs).missed == 6);
  CHECK(missed_cycles(series, {}, 105 * kMs).cycles == 895);
  CHECK(std::isnan(missed_cycles(Series{}, {}).share_outside()));
}

TEST_CASE(
    "latency: a missed cycle counts as a stall's up to 5 ms before and behind it, and no further") {
  const std::vector<Stall> seen{{100 * kMs, 110 * kMs}};
  const auto within = [&](int missed) {
    return missed_cycles(cycles(1000, [missed](int i) { return i == missed; }), seen).within_stalls;
  };
  CHECK(within(94) == 0);
  CHECK(within(95) == 1);
  CHECK(within(105) == 1);
  CHECK(within(115) == 1);
  CHECK(within(116) == 0);
}

TEST_CASE("latency: a quiet machine is good for 1 kHz, and meets what c3rt promises of itself") {
  const Judgement judgement = judge(quiet());
  CHECK(judgement.good);
  CHECK_THAT(judgement.sentence, Contains("good for 1 kHz: of the last 100 commands 99.9"));
  CHECK(met(judgement.program, "wakeup_p99_over_reference"));  // 1.1
  CHECK(met(judgement.program, "servo_compute_p99_s"));
  CHECK(met(judgement.program, "missed_cycles_outside_stalls"));    // 0.75 of 10,000
  CHECK(met(judgement.program, "state_to_command_p50_over_hops"));  // 1.4
  CHECK(met(judgement.program, "state_to_command_p99_over_hops"));  // 1.79
}

TEST_CASE(
    "latency: the verdict is the robot's, in libfranka's limits: 0.95 on average, 0.80 at worst, "
    "no stop") {
  Measured m = quiet();
  m.success.average = 0.95;
  m.success.minimum = 0.80;
  CHECK(judge(m).good);
  m.success.average = 0.949;
  CHECK_FALSE(judge(m).good);
  CHECK_THAT(judge(m).sentence, Contains("not good") && Contains("many commands are lost"));
  m.success.average = 0.899;
  CHECK_THAT(judge(m).sentence, Contains("probably not sufficient"));
  m = quiet();
  m.success.minimum = 0.79;
  CHECK_FALSE(judge(m).good);
  m = quiet();
  m.reflexes = "communication_constraints_violation";
  CHECK_FALSE(judge(m).good);
  CHECK_THAT(judge(m).sentence, Contains("communication_constraints_violation"));
  CHECK_FALSE(judge(Measured{}).good);
  CHECK_THAT(judge(Measured{}).sentence, Contains("never tracked"));
}

TEST_CASE("latency: a promise that is not kept is told, and does not make the machine bad") {
  Measured m = quiet();
  m.wakeup.p99 = 61e-6;
  m.servo_compute.p99 = 101e-6;
  m.missed = {40'000, 25, 20, {}};
  m.state_to_command.p50 = 226e-6;
  m.state_to_command.p99 = 603e-6;
  const Judgement judgement = judge(m);
  CHECK(judgement.good);
  CHECK_FALSE(met(judgement.program, "wakeup_p99_over_reference"));  // 1.22
  CHECK_FALSE(met(judgement.program, "servo_compute_p99_s"));
  CHECK_FALSE(met(judgement.program, "missed_cycles_outside_stalls"));    // 1.25 of 10,000
  CHECK_FALSE(met(judgement.program, "state_to_command_p50_over_hops"));  // 1.51
  CHECK_FALSE(met(judgement.program, "state_to_command_p99_over_hops"));  // 2.001
  REQUIRE(judgement.causes.size() == 1);
  CHECK_THAT(judgement.causes[0], Contains("5 of 40000 cycles"));
}

TEST_CASE("latency: what explains a verdict is named: no priority, stalls, a late kernel") {
  Measured m = quiet();
  m.missed = {};
  CHECK(judge(m).causes.empty());
  m.refused = "SCHED_FIFO priority 80 refused (Operation not permitted)";
  m.stalls = {{0, 2 * kMs}, {10 * kMs, 24 * kMs}};
  m.reference.p999 = 2e-3;
  const std::vector<std::string> causes = judge(m).causes;
  REQUIRE(causes.size() == 3);
  CHECK_THAT(causes[0], Contains("priority 80 refused"));
  CHECK_THAT(causes[1], Contains("2 times") && Contains("the longest 14 ms"));
  CHECK_THAT(causes[2], Contains("one of a thousand"));
}
