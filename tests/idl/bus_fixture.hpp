#pragma once
// Buses of a DDS domain that no other test on this machine uses at the same time.
#include <cstdint>
#include <functional>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/dds.hpp"
#include "tests/support/own_domain.hpp"

namespace c3rt::wire::test {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1000 * kMs;

inline const std::uint32_t kDomain = support::kOwnDomain;

inline BusSettings settings(ClockMode clock = ClockMode::kRealtime, std::uint64_t session_id = 0) {
  BusSettings result;
  result.domain = kDomain;
  result.profile_uri = C3RT_SOURCE_DIRECTORY "/config/dds/loopback.xml";
  result.clock = clock;
  result.session_id = session_id;
  return result;
}

/// Waits until the condition holds; false after 10 s.
inline bool eventually(const std::function<bool()>& condition) {
  const std::int64_t deadline_ns = rt::now_ns() + 10 * kSecond;
  while (!condition()) {
    if (rt::now_ns() > deadline_ns) return false;
    usleep(1000);
  }
  return true;
}

/// Runs `body` in a process of its own; made while this process has no bus.
class Child {
 public:
  explicit Child(const std::function<int()>& body) : pid_(fork()) {
    if (pid_ == 0) _exit(body());
  }
  ~Child() {
    if (pid_ <= 0) return;
    kill(SIGKILL);
    wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  void kill(int signal) const { ::kill(pid_, signal); }
  pid_t pid() const { return pid_; }
  /// Exit status; -1 if a signal ended it.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_;
};

}  // namespace c3rt::wire::test
