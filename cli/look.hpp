#pragma once
// What is on the bus: `c3rt topics`, `echo`, `hz`.
#include <string>

#include "cli/client.hpp"

namespace c3rt::cli {

/// What is looked at, and for how long.
struct LookSettings {
  std::string topic;
  int count = 0;           // lines or reports; 0: until interrupted
  double timeout_s = 5.0;  // without a sample, until it is given up; 0: never
};

/// @throws UsageError that names the known ones
[[noreturn]] void unknown_topic(const std::string& name);

/// Every topic: readers, writers, rate, QoS and type; what the processes say of each other. With
/// `peers` also every reader and writer with its process.
int print_topics(const Seat& seat, bool peers);

/// Samples as JSON, one a line. @return kCriterionFailed where nobody writes
/// @throws UsageError for an unknown topic
int echo(const Seat& seat, const LookSettings& settings);

/// Rate, jitter and losses once a second, for each key and writer. As echo().
int measure_rate(const Seat& seat, const LookSettings& settings);

}  // namespace c3rt::cli
