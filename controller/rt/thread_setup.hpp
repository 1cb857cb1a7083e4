#pragma once
// What the kernel must grant a thread before it is real-time.
#include <string>
#include <vector>

namespace c3rt::rt {

struct ThreadSettings {
  int fifo_priority = 0;  // SCHED_FIFO 1..99; 0: leave the scheduler alone
  std::vector<int> cpus;  // the thread may run on these; empty: anywhere
  bool lock_memory =
      false;  // mlockall for the whole process, and a stack and heap that are already there
};

/// Applies the settings to the calling thread, as far as the kernel allows; it never ends the
/// process. Threads that this one starts later inherit scheduler and CPUs: open the bus first, then
/// call this.
/// @return what was refused and why, as one sentence for a warning; empty if everything was
/// granted.
std::string setup_thread(const ThreadSettings& settings);

}  // namespace c3rt::rt
