#include "cli/latency/hop.hpp"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>

#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/latency/analysis.hpp"
#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "idl/process.hpp"
#include "idl/raw_ping.hpp"

namespace c3rt::cli::latency {
namespace {

constexpr std::int64_t kLost_ns = 50'000'000;           // an answer that takes longer is lost
constexpr std::int64_t kDiscovery_ns = 15'000'000'000;  // until both ends know each other
constexpr auto kLook = std::chrono::milliseconds(50);
constexpr auto kGrace = std::chrono::seconds(5);  // for the other end to end

rt::ThreadSettings servo(int fifo_priority) {
  rt::ThreadSettings settings;
  settings.fifo_priority = fifo_priority;
  return settings;
}

/// With the keys of a process, where the bus is secure: both ends write what only it may.
wire::BusSettings as(wire::Process process, wire::BusSettings settings) {
  settings.identity = wire::process_name(process);
  return settings;
}

/// The other end: a servo that does nothing but answer.
void answer(const wire::BusSettings& settings, int fifo_priority) {
  wire::Bus bus(as(c3rt_v2_PROCESS_IMPEDANCE, settings));
  wire::Signal arrival;
  wire::Inlet<wire::RobotState> states(bus, &arrival);
  wire::Outlet<wire::RobotCommand> commands(bus);
  const wire::RawEcho raw(bus);
  (void)rt::setup_thread(servo(fifo_priority));
  wire::RobotState state{};
  wire::RobotCommand command{};
  while (!wire::StopFlag::requested()) {
    if (!arrival.wait(kLost_ns) || !states.take(state)) continue;
    command.origin.state_ns = state.header.time_ns;
    commands.put(command, rt::now_ns());
  }
}

/// One sample on the servo's path and its answer.
class LayerPing {
 public:
  explicit LayerPing(wire::Bus& bus) : commands_(bus, &arrival_), states_(bus) {}

  /// -1 where no answer came in time. RT: no heap, no lock, no throw.
  std::int64_t round_trip_ns(std::int64_t timeout_ns) noexcept {
    const std::int64_t sent_ns = rt::now_ns();
    states_.put(state_, sent_ns);
    for (std::int64_t now_ns = sent_ns; now_ns - sent_ns < timeout_ns; now_ns = rt::now_ns()) {
      arrival_.wait(timeout_ns);
      if (commands_.take(command_) && command_.origin.state_ns == sent_ns)
        return rt::now_ns() - sent_ns;
    }
    return -1;
  }

 private:
  wire::Signal arrival_;
  wire::Inlet<wire::RobotCommand> commands_;
  wire::Outlet<wire::RobotState> states_;
  wire::RobotState state_{};
  wire::RobotCommand command_{};
};

/// Everything that the measuring thread touches.
struct Bench {
  LayerPing& layer;
  wire::RawPing& raw;
  HopRecord& record;
  std::size_t room;  // of each kind
  std::atomic<bool> stop{false}, done{false};
  std::atomic<std::size_t> cycles{0};

  /// Both ends know each other once both kinds have been answered.
  bool find() noexcept {
    const std::int64_t deadline_ns = rt::now_ns() + kDiscovery_ns;
    bool by_layer = false, by_raw = false;
    while (!(by_layer && by_raw)) {
      if (stop.load() || rt::now_ns() > deadline_ns) return false;
      by_layer = layer.round_trip_ns(kLost_ns) >= 0 || by_layer;
      by_raw = raw.round_trip_ns(kLost_ns) >= 0 || by_raw;
    }
    return true;
  }
  void measure() noexcept {
    record.answered = find();
    rt::PeriodicClock clock(kPeriod_ns);
    // the room was made before: push_back takes no more
    for (std::size_t i = 0; record.answered && i < 2 * room && !stop.load(); ++i) {
      clock.wait();
      const bool through_layer = i % 2 == 0;
      const std::int64_t round_ns =
          through_layer ? layer.round_trip_ns(kLost_ns) : raw.round_trip_ns(kLost_ns);
      ++record.sent;
      if (round_ns < 0) {
        ++record.lost;
      } else {
        (through_layer ? record.layer : record.raw).push_back(0.5 * base::seconds(round_ns));
      }
      cycles.store(i);
    }
    done.store(true);
  }
};

}  // namespace

EchoProcess::EchoProcess(const wire::BusSettings& settings, int fifo_priority) {
  const auto fail = [] {
    throw std::runtime_error(std::string("cannot start the other end of the ping: ") +
                             std::strerror(errno));
  };
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) fail();
  // what is printed later must not be printed by both
  std::fflush(nullptr);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ != 0) {
    close(ends[0]);
    gate_ = ends[1];
    if (pid_ < 0) fail();
    return;
  }
  close(ends[1]);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  char word = 0;
  if (getppid() != parent || read(ends[0], &word, 1) != 1) _exit(0);
  try {
    answer(settings, fifo_priority);
    _exit(0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "c3rt: the other end of the ping: %s\n", error.what());
    _exit(1);
  }
}

void EchoProcess::begin() {
  const char word = 'b';
  // where it has died nobody answers, and that is told
  [[maybe_unused]] const auto written = send(gate_, &word, 1, MSG_NOSIGNAL);
}

EchoProcess::~EchoProcess() { end(); }

bool EchoProcess::running() {
  if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == pid_) pid_ = 0;
  return pid_ > 0;
}

void EchoProcess::end() {
  if (gate_ >= 0) close(gate_);
  gate_ = -1;
  if (!running()) return;
  kill(pid_, SIGTERM);
  const auto deadline = std::chrono::steady_clock::now() + kGrace;
  while (running() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (!running()) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = 0;
}

HopRecord measure_hops(const wire::BusSettings& settings, EchoProcess& echo, double duration_s,
                       int fifo_priority, const std::function<bool()>& stop,
                       const std::function<void(double)>& shown) {
  HopRecord record;
  echo.begin();
  wire::Bus bus(as(c3rt_v2_PROCESS_PLANT, settings));
  LayerPing layer(bus);
  wire::RawPing raw(bus);
  const auto room =
      static_cast<std::size_t>(base::nanoseconds(duration_s) / (2 * kPeriod_ns));  // of each kind
  record.layer.reserve(room);
  record.raw.reserve(room);
  Bench bench{layer, raw, record, room};
  std::thread thread([&bench, fifo_priority] {
    (void)rt::setup_thread(servo(fifo_priority));
    bench.measure();
  });
  while (!bench.done.load()) {
    record.died = record.died || !echo.running();
    if (stop() || record.died) bench.stop.store(true);
    shown(room == 0 ? 1.0
                    : static_cast<double>(bench.cycles.load()) / static_cast<double>(2 * room));
    std::this_thread::sleep_for(kLook);
  }
  thread.join();
  return record;
}

}  // namespace c3rt::cli::latency
