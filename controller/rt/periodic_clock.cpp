#include "controller/rt/periodic_clock.hpp"

#include <cerrno>
#include <ctime>
#include <stdexcept>

namespace c3rt::rt {

namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

void sleep_until(std::int64_t time_ns) noexcept {
  const timespec at{static_cast<std::time_t>(time_ns / kNsPerSecond),
                    static_cast<long>(time_ns % kNsPerSecond)};
  // a signal ends the sleep early; the deadline stays
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
  }
}

}  // namespace

std::int64_t now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNsPerSecond + now.tv_nsec;
}

PeriodicClock::PeriodicClock(std::int64_t period_ns, std::int64_t first_ns)
    : period_ns_(period_ns), deadline_ns_(first_ns) {
  if (period_ns <= 0)
    throw std::invalid_argument("PeriodicClock: the period must be longer than 0 ns");
}

Wakeup PeriodicClock::wait() noexcept {
  const std::int64_t late_ns = now_ns() - (deadline_ns_ + period_ns_);
  const std::int64_t missed = late_ns > 0 ? late_ns / period_ns_ : 0;
  deadline_ns_ += (missed + 1) * period_ns_;
  sleep_until(deadline_ns_);
  const std::int64_t woke_ns = now_ns();
  return {deadline_ns_, woke_ns, woke_ns - deadline_ns_, missed};
}

}  // namespace c3rt::rt
