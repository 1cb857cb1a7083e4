#include "controller/rt/thread_setup.hpp"

#include <cerrno>
#include <cstddef>
#include <cstring>

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace c3rt::rt {

namespace {

constexpr std::size_t kPrefaultedStack = 256 * 1024;

// touches the stack below, so that the first deep call does not fault
[[gnu::noinline]] void prefault_stack() noexcept {
  unsigned char stack[kPrefaultedStack];
  volatile unsigned char* byte = stack;
  for (std::size_t i = 0; i < kPrefaultedStack; i += 4096) byte[i] = 0;
}

int lock_memory() noexcept {
  // freed memory stays in the process, so that it does not fault again
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  // where the amount is limited, locking the future would make later allocations fail
  rlimit limit{};
  const bool unlimited =
      geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
  if (mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) != 0) return errno;
  prefault_stack();
  return 0;
}

int restrict_to(const std::vector<int>& cpus) noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) {
    if (cpu < 0 || cpu >= CPU_SETSIZE) return EINVAL;
    CPU_SET(cpu, &set);
  }
  return pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

}  // namespace

std::string setup_thread(const ThreadSettings& settings) {
  std::string refused;
  const auto note = [&refused](const std::string& what, int error) {
    if (error == 0) return;
    refused += (refused.empty() ? "" : "; ") + what + " refused (" + std::strerror(error) + ")";
  };
  if (settings.lock_memory) note("locking the memory", lock_memory());
  if (!settings.cpus.empty()) {
    std::string names;
    for (const int cpu : settings.cpus) names += (names.empty() ? "" : ",") + std::to_string(cpu);
    note("CPU affinity " + names, restrict_to(settings.cpus));
  }
  if (settings.fifo_priority > 0) {
    sched_param parameter{};
    parameter.sched_priority = settings.fifo_priority;
    note("SCHED_FIFO priority " + std::to_string(settings.fifo_priority),
         pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter));
  }
  return refused;
}

}  // namespace c3rt::rt
