#pragma once
// What the measured times amount to. Pure: samples in, figures and a judgement out.
#include <cstdint>
#include <string>
#include <vector>

#include "cli/report/metrics.hpp"
#include "cli/report/series.hpp"

namespace c3rt::cli::latency {

/// Of the servo, and so of the probes beside it.
constexpr std::int64_t kPeriod_ns = 1'000'000;

/// Quantiles by nearest rank [s]; kNone without samples.
struct Distribution {
  std::uint64_t count = 0;
  double p50 = kNone, p95 = kNone, p99 = kNone, p999 = kNone, max = kNone;
};
Distribution distribution(std::vector<double> samples);

/// One wake-up of a periodic thread.
struct Wakeup {
  std::int64_t deadline_ns = 0;  // when it was to be [CLOCK_MONOTONIC]
  std::int64_t latency_ns = 0;   // how much later it was
};
/// Their latencies [s].
std::vector<double> latencies_of(const std::vector<Wakeup>& wakeups);

/// A time in which a thread was due and did not run.
struct Stall {
  std::int64_t begin_ns = 0, end_ns = 0;
};
/// A wake-up that is later than this is a stall: half a cycle, after which the servo can miss its
/// own [ns]
constexpr std::int64_t kStall_ns = 500'000;
/// The stalls of several threads, in order of time, those that overlap as one.
std::vector<Stall> stalls(const std::vector<std::vector<Wakeup>>& threads);

/// libfranka's control_command_success_rate, the share of the last 100 commands that came in their
/// cycle, over the states from the first command that tracks, once 100 cycles lie behind it: at the
/// start of a motion the share is one of fewer commands.
struct SuccessRate {
  std::uint64_t states = 0;
  double average = kNone, minimum = kNone;
  std::int64_t minimum_ns = 0;  // when it was lowest, for the first time
};
SuccessRate success_rate(const Series& series);

/// Cycles of the robot that no command answered, from the first command that tracks and since the
/// reference threads watch.
struct MissedCycles {
  std::uint64_t cycles = 0;              // robot states
  std::uint64_t missed = 0;              // that no command answers
  std::uint64_t within_stalls = 0;       // of these, as far as a reference thread stalled then, too
  std::vector<std::int64_t> outside_ns;  // times of the others
  /// Of all cycles, those that were missed while every reference thread was punctual; kNone of none
  double share_outside() const;
};
/// A state and its answer are this near to a stall if it may be the cause: the burst that follows
/// one is over by then [ns]
constexpr std::int64_t kNearStall_ns = 5'000'000;
/// @param stalls in order of time
/// @param from_ns when the reference threads began
MissedCycles missed_cycles(const Series& series, const std::vector<Stall>& stalls,
                           std::int64_t from_ns = 0);

/// What the judgement looks at.
struct Measured {
  Distribution wakeup, reference;  // of the machine alone
  Distribution servo_compute;
  Distribution hop_raw;           // of Cyclone DDS alone, one way
  Distribution state_to_command;  // from the state's stamp to the command's
  SuccessRate success;
  MissedCycles missed;
  std::vector<Stall> stalls;  // during the run of the processes
  std::string reflexes;       // names of the errors that stopped the robot; empty: none
  std::string refused;        // why the servo's priority is refused; empty: granted
};

struct Judgement {
  bool good = false;                // for 1 kHz: the robot's criteria are met
  std::string sentence;             // the verdict in plain words
  std::vector<std::string> causes;  // what was seen that explains it, or that is worth knowing
  /// The robot's, then what c3rt itself promises on a quiet machine of two cores.
  std::vector<CriterionResult> robot, program;
};
/// The robot's criteria: success rate at least 0.95 on average (libfranka's communication test
/// calls less "many packets lost", and less than 0.90 "probably not sufficient"), at least 0.80 at
/// any time (20 lost in a row stop the robot), no reflex.
Judgement judge(const Measured& measured);

}  // namespace c3rt::cli::latency
