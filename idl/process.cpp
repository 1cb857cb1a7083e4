#include "idl/process.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>

#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/shutdown_listener.hpp"

namespace c3rt::wire {

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void on_signal(int) { stop_requested.store(true); }

}  // namespace

std::uint64_t draw_session() noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U +
         static_cast<std::uint64_t>(now.tv_nsec);
}

StopFlag::StopFlag() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}
bool StopFlag::requested() noexcept { return stop_requested.load(std::memory_order_relaxed); }
void StopFlag::request() noexcept { stop_requested.store(true); }
void StopFlag::clear() noexcept { stop_requested.store(false); }

void become_helper_thread(const char* name) noexcept {
  pthread_setname_np(pthread_self(), name);
  const sched_param ordinary{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
}

void become_bus_thread(const char* name) noexcept {
  become_helper_thread(name);
  raise_to_bus_priority();
}

Signal::Signal() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (event_ < 0) throw WireError(std::string("cannot create an eventfd: ") + std::strerror(errno));
}
Signal::~Signal() { close(event_); }

void Signal::raise() noexcept {
  raised_ns_.store(rt::now_ns());
  const std::uint64_t one = 1;
  // only a full counter is refused, and then the signal is already up
  [[maybe_unused]] const auto written = write(event_, &one, sizeof one);
}

bool Signal::wait(std::int64_t timeout_ns) noexcept {
  pollfd waiting{event_, POLLIN, 0};
  const timespec timeout{static_cast<std::time_t>(timeout_ns / 1'000'000'000),
                         static_cast<long>(timeout_ns % 1'000'000'000)};
  if (ppoll(&waiting, 1, &timeout, nullptr) <= 0) return false;
  std::uint64_t raised = 0;
  return read(event_, &raised, sizeof raised) == sizeof raised;
}

ShutdownListener::ShutdownListener(Bus& bus, Process process)
    : bus_(bus),
      process_(process),
      requests_(bus, 16, Wakes::kItself),
      replies_(bus),
      thread_([this] { run(); }) {}

ShutdownListener::~ShutdownListener() {
  stop_.store(true);
  requests_.interrupt();
  thread_.join();
}

void ShutdownListener::run() {
  become_helper_thread("requests");
  ServiceRequest request{};
  while (!stop_.load()) {
    requests_.wait(1'000'000'000);
    while (requests_.take(request)) {
      if (request.process != process_ || request.verb != c3rt_v2_REQUEST_SHUTDOWN) continue;
      StopFlag::request();
      bus_.wake();
      ServiceReply reply{};
      reply.request_id = request.request_id;
      reply.process = process_;
      reply.ok = true;
      std::snprintf(reply.text, sizeof reply.text, "%s is shutting down", process_name(process_));
      replies_.write(reply, rt::now_ns());
    }
  }
}

}  // namespace c3rt::wire
