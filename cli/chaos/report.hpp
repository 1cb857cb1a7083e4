#pragma once
// What chaos amounts to: chaos.json and chaos.txt, and a picture of the recovery times.
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/chaos/recovery.hpp"
#include "cli/invariants/processes.hpp"
#include "cli/invariants/violations.hpp"

namespace c3rt::cli::chaos {

/// What the p99 of recovery may be [s].
constexpr double kLimit = 3.0, kPlantLimit = 5.0;

struct Summary {
  std::string scenario, clock;
  std::uint64_t seed = 0;
  double rate = 0.0;    // faults in a minute of the time between them
  std::string result;   // "passed", "violated", "interrupted", what failed
  double lasted = 0.0;  // of the session's clock [s]
  double wall = 0.0;    // [s]
  std::uint64_t passes = 0, samples = 0, reflexes = 0;
  std::uint64_t rows_lost = 0;          // of processes.csv: there was no room
  std::vector<std::string> log_hashes;  // of the passes, in simulated time
  std::string again;                    // a command that shows the first violation again
};

/// One of the two limits.
struct Criterion {
  std::string name;
  double value, limit;  // [s]; kNever where something has not recovered
  bool met;
};
/// Those that some fault was about.
std::vector<Criterion> criteria_of(const std::vector<Outcome>& outcomes);

using Courses = std::map<std::string, invariants::Processes::Course>;

nlohmann::ordered_json to_json(const Summary& summary, const std::vector<Outcome>& outcomes,
                               const invariants::Violations& violations, const Courses& courses);

/// The same for a person.
std::string to_text(const Summary& summary, const std::vector<Outcome>& outcomes,
                    const invariants::Violations& violations);

/// faults.csv: a line for each.
std::string to_csv(const std::vector<Outcome>& outcomes);

/// recovery.png. @return what is missing and why; empty if it is there
std::string draw_recovery(const std::filesystem::path& folder, const std::string& title,
                          const std::vector<Outcome>& outcomes);

}  // namespace c3rt::cli::chaos
