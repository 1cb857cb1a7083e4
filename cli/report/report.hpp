#pragma once
// report.json: the keys that other programs read.
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/report/guests.hpp"
#include "cli/report/metrics.hpp"

namespace c3rt::cli {

/// What the processes say about themselves in service/status.
struct ServiceFigures {
  Spread impedance_wakeup;   // [s]
  Spread impedance_compute;  // [s]
  std::uint64_t impedance_missed_cycles = 0;
  std::uint64_t stale_plan_events = 0;
};

struct Report {
  std::string scenario;
  std::uint64_t seed = 0;
  std::string clock;  // "realtime", "lockstep"
  std::string
      result;  // "passed", "criteria not met", "interrupted", "planner was killed by signal 11 (…)"
  Figures figures;
  ServiceFigures services;
  double real_time_factor = kNone;    // time of the plant / time of the wall
  std::vector<std::string> reflexes;  // names of the errors that stopped the robot
  std::string log_hash;
  std::vector<Guest> guests;  // clients that played a process
};

/// @return true if every criterion is met
bool all_met(const std::vector<CriterionResult>& criteria);

/// SI units; what the run did not give is null.
nlohmann::ordered_json to_json(const Report& report);

/// The report for a person: some lines for the terminal.
std::string summary(const Report& report);

}  // namespace c3rt::cli
