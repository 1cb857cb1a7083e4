#pragma once
// `c3rt latency`: what this machine can hold, in one report.
#include <cstdint>
#include <string>

namespace c3rt::cli::latency {

struct Settings {
  std::string scenario = "circle_vision";
  double duration = 60.0;  // of all three stages together [s]
  int load = 0;            // ordinary threads that compute all the time
  std::string profile = "loopback";
  std::string domain = "any";
  std::string out;  // empty: out/latency-DATE
  bool json = false;
};

/// The shortest that has three stages worth measuring [s]
constexpr double kShortest = 6.0;
constexpr double kLongest = 3600.0;

/// Measures the machine alone, DDS, and the four processes, each for its part of the time.
/// @return kDone where the machine is good for 1 kHz, kCriterionFailed where not or interrupted
/// @throws UsageError, config::ConfigError, ProcessFailure
int run(const Settings& settings);

}  // namespace c3rt::cli::latency
