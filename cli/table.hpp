#pragma once
// What a person sees while it runs.
#include <string>

#include "cli/recorder.hpp"

namespace c3rt::cli {

/// One line per process: state, pid, rate, latencies, counters and its sentence.
std::string service_table(
    const std::array<std::optional<wire::ServiceStatus>, wire::kProcessCount>& services);

/// A counter of service/status by its name; 0 if there is none.
std::uint64_t counter(const wire::ServiceStatus& status, const char* name);

/// The live table of `c3rt run` on standard output: in place on a terminal, else a line every few
/// seconds.
class LiveTable {
 public:
  /// @param unit, goal what Live::turns counts, and how many end the run
  LiveTable(const std::string& title, const std::string& unit, int goal, double duration);
  /// Call it often; it draws when it is time.
  void update(const Live& live);
  void finish(const Live& live);  // a last time, and the cursor below

 private:
  void draw(const Live& live);
  void tell_changes(const Live& live);  // of a process's state, as they come; not on a terminal
  std::string title_, unit_;
  int goal_;
  double duration_;  // [s]
  bool terminal_;
  std::array<c3rt_v2_ServiceState, wire::kProcessCount> states_{};
  int lines_ = 0;          // drawn so far, to be drawn over
  double drawn_at_ = 0.0;  // wall [s]
  std::uint64_t drawn_steps_ = 0;
  double factor_ = kNone;  // of real time, since the last drawing
};

}  // namespace c3rt::cli
