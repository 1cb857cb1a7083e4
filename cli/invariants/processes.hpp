#pragma once
// What every process must keep for as long as it runs: memory, threads and descriptors stay as they
// were once it had settled, its log grows slowly, it is neither lost nor another one.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cli/invariants/violations.hpp"

namespace c3rt::cli::invariants {

/// One look at a process, as /proc tells it.
struct ProcessSample {
  std::string name;
  int pid = 0;               // 0: it is not there
  std::uint64_t memory = 0;  // resident [bytes]
  int threads = 0, descriptors = 0;
  std::uint64_t log = 0;  // size of its log [bytes]
};

struct ProcessLimits {
  double settles_after = 300.0;           // what is there then is what it stays at [s]
  double memory = 1024.0 * 1024.0;        // more than that [bytes]
  double log = 64.0 * 1024.0;             // more than that [bytes] …
  double log_per_hour = 1024.0 * 1024.0;  // … and this much in every hour [bytes]
};

/// Violations are named lost, restarted, memory, threads, descriptors and log_growth; their subject
/// is the process.
class Processes {
 public:
  Processes(const ProcessLimits& limits, Violations& violations)
      : limits_(limits), violations_(violations) {}

  /// @param time of the look, since the watch began [s]
  void hear(double time, const ProcessSample& sample);
  /// Somebody started it again on purpose: it settles anew.
  void restarted(const std::string& name) { known_.erase(name); }

  /// What a process settled at and has come to.
  struct Course {
    int pid = 0;
    double first = 0.0, last = 0.0;  // looks at it [s]
    bool settled = false;
    ProcessSample at_first, at_settling, largest, newest;
    std::uint64_t logged = 0, logged_at_settling = 0;  // in all, over every rotation [bytes]
  };
  const std::map<std::string, Course>& courses() const noexcept { return known_; }

 private:
  const ProcessLimits limits_;
  Violations& violations_;
  std::map<std::string, Course> known_;
};

}  // namespace c3rt::cli::invariants
