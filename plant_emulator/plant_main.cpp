// c3rt-plant: the simulated robot, table and balls on the bus, paced by the clock (realtime) or
// pacing all (lockstep).
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <spdlog/spdlog.h>

#include "config/process_options.hpp"
#include "config/scenario.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "idl/bus_settings.hpp"
#include "idl/endpoint.hpp"
#include "idl/process.hpp"
#include "plant_emulator/messages.hpp"
#include "plant_emulator/orders.hpp"
#include "plant_emulator/plant.hpp"
#include "plant_emulator/start.hpp"

namespace c3rt::plant {
namespace {

constexpr std::int64_t kCycleNs = 1'000'000;
constexpr std::int64_t kScenePeriodNs = 10'000'000;  // truth for the recorder, beside the exposures
constexpr std::int64_t kJoinTimeoutNs = 60'000'000'000;  // lockstep: the other processes' start
constexpr std::int64_t kPollNs = 50'000'000;             // of the thread that serves clients
constexpr double kStanding = 0.02;                       // [rad/s]
constexpr int kStepPriority = 70;  // below the impedance process, for whose answer the robot waits

/// Due instants of a period on the session's clock: true once for each that has passed.
class Schedule {
 public:
  Schedule(std::int64_t period_ns, std::int64_t first_ns)
      : period_ns_(period_ns), next_ns_(first_ns) {}
  bool due(std::int64_t now_ns) noexcept {
    if (now_ns < next_ns_) return false;
    next_ns_ += ((now_ns - next_ns_) / period_ns_ + 1) * period_ns_;
    return true;
  }

 private:
  std::int64_t period_ns_;
  std::int64_t next_ns_;
};

/// The plant with its faults and schedules: one call per cycle, the same in both clocks.
class Cycle {
 public:
  Cycle(const config::Scenario& scenario, std::uint64_t seed, wire::StatusReporter& status)
      : plant_(drawn_start(scenario.plant, seed)),
        exposure_(std::llround(1e9 / scenario.vision.rate), 0),
        scene_(kScenePeriodNs, 0),
        pushes_(drawn_pushes(scenario.plant.pushes,
                             static_cast<int>(scenario.plant.world.balls.size()), seed)),
        cycles_(status.counter("cycles")),
        lost_commands_(status.counter("lost_commands")),
        saturated_(status.counter("saturated_cycles")),
        reflexes_(status.counter("reflexes")),
        success_(status.counter("success_rate_1e3")),
        success_min_(status.counter("success_rate_min_1e3")),
        exposures_(status.counter("exposures")),
        faults_(status.counter("faults")) {
    success_min_ = 1000;
  }

  void obey(const Order& order) noexcept {
    const double until = plant_.state().time + order.duration;
    switch (order.kind) {
      case OrderKind::kRecover:
        plant_.request_recovery();
        return;
      case OrderKind::kStop:
        plant_.request_stop();
        return;
      case OrderKind::kPushBall:
        plant_.push_ball(order.index, order.value);
        break;
      case OrderKind::kDropCommands:
        plant_.drop_commands(order.duration);
        break;
      case OrderKind::kStall:
        stall(order.duration);
        break;
      case OrderKind::kNan:
        nan_until_ = until;
        break;
      case OrderKind::kEndFaults:
        plant_.drop_commands(0);
        nan_until_ = 0;
        break;
    }
    ++faults_;
  }

  void command(const wire::RobotCommand& command) noexcept {
    plant_.set_command(Eigen::Map<const Vector7d>(command.tau_nm), command.header.seq,
                       command.origin.state_ns);
  }

  void step() noexcept {
    // the scenario's own pushes take the way of a client's, but at the same instant in every run
    for (; pushed_ < pushes_.size() && pushes_[pushed_].time <= plant_.state().time; ++pushed_) {
      obey({OrderKind::kPushBall, pushes_[pushed_].ball, 0.0, pushes_[pushed_].impulse});
    }
    plant_.step_1ms();
    const State& s = plant_.state();
    cycles_.store(++count_, std::memory_order_relaxed);
    lost_commands_.store(s.lost_commands, std::memory_order_relaxed);
    saturated_.store(s.saturated_cycles, std::memory_order_relaxed);
    if (s.mode == Mode::kReflex && mode_ != Mode::kReflex) ++reflexes_;
    moving_ = s.mode == Mode::kMove ? moving_ + 1 : 0;
    shown_moving_.store(moving_, std::memory_order_relaxed);
    shown_standing_.store(s.dq.cwiseAbs().maxCoeff() < kStanding, std::memory_order_relaxed);
    const auto success = static_cast<std::uint64_t>(std::lround(1000 * s.command_success_rate));
    success_.store(success, std::memory_order_relaxed);
    // the window must be full, or one early loss would read as a bad connection
    if (moving_ >= kSuccessWindow && success < success_min_)
      success_min_.store(success, std::memory_order_relaxed);
    mode_ = s.mode;
    shown_mode_.store(s.mode, std::memory_order_relaxed);
    shown_errors_.store(s.errors, std::memory_order_relaxed);
    shown_waiting_.store(plant_.waits_for_commands(), std::memory_order_relaxed);
  }

  wire::RobotState state() const noexcept {
    wire::RobotState sample = robot_state(plant_.state());
    if (plant_.state().time < nan_until_)
      sample.q_rad[0] = std::numeric_limits<double>::quiet_NaN();
    return sample;
  }

  /// @return true if a sample of the scene is due, at an exposure or for the recorder
  bool scene_due(std::int64_t now_ns, wire::Scene& sample) noexcept {
    const bool exposure = exposure_.due(now_ns);
    if (!scene_.due(now_ns) && !exposure) return false;
    if (exposure) ++exposures_;
    sample = scene(plant_.state(), exposure);
    return true;
  }

  // for the thread that serves clients
  Mode mode() const noexcept { return shown_mode_.load(std::memory_order_relaxed); }
  Errors errors() const noexcept { return shown_errors_.load(std::memory_order_relaxed); }
  std::int64_t cycles() const noexcept { return static_cast<std::int64_t>(cycles_.load()); }
  int moving_cycles() const noexcept { return shown_moving_.load(std::memory_order_relaxed); }
  bool standing() const noexcept { return shown_standing_.load(std::memory_order_relaxed); }
  bool waits_for_commands() const noexcept {
    return shown_waiting_.load(std::memory_order_relaxed);
  }

 private:
  /// Stands still, but not when it is asked to end.
  static void stall(double duration) noexcept {
    using std::chrono::steady_clock;
    const auto until = steady_clock::now() + std::chrono::duration<double>(duration);
    while (!wire::StopFlag::requested() && steady_clock::now() < until)
      std::this_thread::sleep_for(std::min<std::chrono::duration<double>>(
          until - steady_clock::now(), std::chrono::milliseconds(10)));
  }

  Plant plant_;
  Schedule exposure_, scene_;
  std::vector<Push> pushes_;
  std::size_t pushed_ = 0;
  std::atomic<std::uint64_t>&cycles_, &lost_commands_, &saturated_, &reflexes_, &success_,
      &success_min_, &exposures_, &faults_;
  std::uint64_t count_ = 0;
  int moving_ = 0;
  double nan_until_ = 0.0;
  Mode mode_ = Mode::kIdle;
  std::atomic<Mode> shown_mode_{Mode::kIdle};
  std::atomic<Errors> shown_errors_{0};
  std::atomic<int> shown_moving_{0};
  std::atomic<bool> shown_standing_{false}, shown_waiting_{false};
};

/// Clients' requests and faults become orders; changes of the robot's mode become status and log.
class ClientDesk {
 public:
  ClientDesk(const Cycle& cycle, wire::Endpoint& endpoint, OrderQueue& orders)
      : cycle_(cycle), endpoint_(endpoint), orders_(orders) {}

  void serve(std::int64_t now_ns) {
    const auto cycle = static_cast<std::uint64_t>(cycle_.cycles());
    endpoint_.serve_requests(
        now_ns, [this](c3rt_v2_RequestVerb verb) { return obey(verb); }, cycle);
    endpoint_.answer_pending(now_ns, cycle, [this](c3rt_v2_RequestVerb verb, bool late) {
      return verb == c3rt_v2_REQUEST_RECOVER ? recovered(late) : stopped(late);
    });
    endpoint_.serve_faults(now_ns, [this](const wire::FaultInject& fault) {
      return std::string(orders_.put(order_of(fault)) ? "" : "too many faults at once");
    });
    report();
  }

 private:
  std::optional<wire::Answer> obey(c3rt_v2_RequestVerb verb) {
    const OrderKind kind = verb == c3rt_v2_REQUEST_RECOVER ? OrderKind::kRecover : OrderKind::kStop;
    if (orders_.put({kind, 0, 0, Eigen::Vector3d::Zero()})) return {};
    return wire::Answer{false, "too many requests at once"};
  }

  std::optional<wire::Answer> stopped(bool late) const {
    const bool stands = cycle_.mode() != Mode::kMove && cycle_.standing();
    if (stands) return wire::Answer{true, "stopped, the arm stands; recover ends it"};
    if (late) return wire::Answer{false, "the arm does not stand yet"};
    return {};
  }

  std::optional<wire::Answer> recovered(bool late) const {
    const Mode mode = cycle_.mode();
    const bool moves = mode == Mode::kMove && cycle_.moving_cycles() >= wire::kSteadyCycles;
    // a reflex that ends by itself is no answer yet
    const bool stopped_again =
        (mode == Mode::kReflex && !cycle_.waits_for_commands()) || mode == Mode::kUserStopped;
    if (!moves && !stopped_again && !late) return {};
    return wire::Answer{moves,
                        mode == Mode::kIdle ? "idle: no commands arrive; does c3rt-impedance run?"
                        : mode == Mode::kMove && !moves ? "the robot stopped again and moves again"
                                                        : mode_text()};
  }

  std::string mode_text() const {
    switch (cycle_.mode()) {
      case Mode::kIdle:
        return "idle: holds its position and waits for a command";
      case Mode::kMove:
        return "follows commands";
      case Mode::kReflex:
        return "reflex: " + names(cycle_.errors()) +
               (cycle_.waits_for_commands() ? "; moves again once commands come steadily"
                                            : "; request recover");
      case Mode::kUserStopped:
        break;
    }
    return "stopped by a person; request recover";
  }

  /// Of a fault that is not refused.
  static Order order_of(const wire::FaultInject& fault) {
    Order order{OrderKind::kEndFaults, static_cast<int>(fault.index), fault.duration_s,
                Eigen::Map<const Eigen::Vector3d>(fault.value)};
    if (fault.kind == c3rt_v2_FAULT_PUSH_OBJECT) order.kind = OrderKind::kPushBall;
    if (fault.kind == c3rt_v2_FAULT_DROP_COMMANDS) order.kind = OrderKind::kDropCommands;
    if (fault.kind == c3rt_v2_FAULT_STALL) order.kind = OrderKind::kStall;
    if (fault.kind == c3rt_v2_FAULT_NAN) order.kind = OrderKind::kNan;
    return order;
  }

  void report() {
    const Mode mode = cycle_.mode();
    const bool well = mode == Mode::kIdle || mode == Mode::kMove;
    const std::string text = mode_text();
    if (endpoint_.say(well ? c3rt_v2_SERVICE_RUNNING : c3rt_v2_SERVICE_DEGRADED, text))
      spdlog::info("mode {}", text);
  }

  const Cycle& cycle_;
  wire::Endpoint& endpoint_;
  OrderQueue& orders_;
};

/// Simulated over elapsed time, in thousandths.
std::uint64_t real_time_factor(std::uint64_t cycles, std::int64_t elapsed_ns) noexcept {
  if (elapsed_ns <= 0) return 0;
  return static_cast<std::uint64_t>(1000.0 * static_cast<double>(cycles) * kCycleNs /
                                    static_cast<double>(elapsed_ns));
}

/// Serves clients from a thread of its own while the loop steps.
class DeskThread {
 public:
  DeskThread(wire::Bus& bus, ClientDesk& desk)
      : bus_(bus), thread_([this, &desk] {
          while (!stop_) {
            bus_.wait_for_data(kPollNs);
            desk.serve(rt::now_ns());
          }
        }) {}
  ~DeskThread() {
    stop_ = true;
    bus_.wake();
    thread_.join();
  }

 private:
  wire::Bus& bus_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

std::string run_realtime(wire::Bus& bus, Cycle& cycle, wire::Endpoint& endpoint) {
  wire::StatusReporter& status = endpoint.status();
  auto& missed = status.counter("missed_cycles");
  auto& factor = status.counter("real_time_factor_1e3");
  OrderQueue orders;
  ClientDesk desk(cycle, endpoint, orders);
  const DeskThread desk_thread(bus, desk);
  wire::Inlet<wire::RobotCommand> commands(bus);
  wire::Outlet<wire::RobotState> states(bus);
  wire::Outlet<wire::Scene> scenes(bus);
  const std::string refused = rt::setup_thread({kStepPriority, {}, true});
  if (!refused.empty()) spdlog::warn("not real-time: {}", refused);

  wire::Loop::Settings pace{c3rt_v2_PROCESS_PLANT, kCycleNs};
  pace.wakeup_latency = &status.wakeup_latency();
  wire::Loop loop(bus, pace);
  wire::RobotCommand command{};
  wire::Scene scene{};
  Order order{};
  std::int64_t now_ns = 0;
  std::int64_t first_ns = 0;
  std::uint64_t cycles = 0;
  while (loop.wait(now_ns)) {
    const std::int64_t begin_ns = rt::now_ns();
    if (first_ns == 0) first_ns = now_ns;
    while (orders.take(order)) cycle.obey(order);
    if (commands.take(command)) cycle.command(command);
    cycle.step();
    states.put(cycle.state(), now_ns);
    if (cycle.scene_due(now_ns, scene)) scenes.put(scene, now_ns);
    ++cycles;
    missed.store(loop.missed_cycles(), std::memory_order_relaxed);
    factor.store(real_time_factor(cycles, now_ns - first_ns + kCycleNs), std::memory_order_relaxed);
    const std::int64_t end_ns = rt::now_ns();
    status.compute().add(1e-9 * static_cast<double>(end_ns - begin_ns));
  }
  return loop.failure();
}

std::vector<wire::Process> expected_processes(const std::vector<std::string>& names) {
  std::vector<wire::Process> processes;
  for (const std::string& name : names) {
    int i = 0;
    while (i < wire::kProcessCount && name != wire::process_name(static_cast<wire::Process>(i)))
      ++i;
    if (i == wire::kProcessCount || i == c3rt_v2_PROCESS_PLANT)
      throw std::invalid_argument("--expect: no process \"" + name + "\" to wait for");
    processes.push_back(static_cast<wire::Process>(i));
  }
  return processes;
}

std::string run_lockstep(wire::Bus& bus, Cycle& cycle, wire::Endpoint& endpoint,
                         const std::vector<std::string>& expect) {
  wire::StatusReporter& status = endpoint.status();
  auto& factor = status.counter("real_time_factor_1e3");
  OrderQueue orders;
  ClientDesk desk(cycle, endpoint, orders);
  wire::Reader<wire::RobotCommand> commands(bus);
  wire::Writer<wire::RobotState> states(bus);
  wire::Writer<wire::Scene> scenes(bus);
  wire::LockstepMaster master(bus, expected_processes(expect), kJoinTimeoutNs);

  wire::RobotCommand command{};
  wire::Scene scene{};
  Order order{};
  const std::int64_t start_ns = rt::now_ns();
  std::uint64_t cycles = 0;
  // time begins at one cycle: 0 means "none" in a stamp
  for (std::int64_t now_ns = kCycleNs;; now_ns += kCycleNs) {
    const std::int64_t begin_ns = rt::now_ns();
    wire::RobotState state = cycle.state();
    states.write(state, now_ns);
    if (cycle.scene_due(now_ns, scene)) scenes.write(scene, now_ns);
    if (!master.advance(now_ns)) return master.failure();
    desk.serve(now_ns);
    while (orders.take(order)) cycle.obey(order);
    if (commands.take_effective(now_ns, command)) cycle.command(command);
    cycle.step();
    ++cycles;
    const std::int64_t end_ns = rt::now_ns();
    factor.store(real_time_factor(cycles, end_ns - start_ns), std::memory_order_relaxed);
    status.compute().add(1e-9 * static_cast<double>(end_ns - begin_ns));
  }
}

int run(int argc, char** argv) {
  int exit_status = 0;
  const auto options = config::parse_process_options(
      argc, argv, "c3rt-plant",
      "The simulated robot with its 1 kHz torque interface, the table and the balls.", exit_status);
  if (!options) return exit_status;
  const wire::StopFlag stop;
  const config::Scenario scenario =
      config::load_scenario(options->scenario_path, options->overrides);
  const bool lockstep = options->clock == config::Clock::kLockstep;
  wire::BusSettings settings = wire::bus_settings(*options);
  if (settings.session_id == 0) settings.session_id = wire::draw_session();
  wire::Bus bus(settings);
  wire::FaultScope scope;
  for (const BallParameters& ball : scenario.plant.world.balls)
    scope.ball_masses.push_back(ball.mass);
  wire::Endpoint endpoint(
      bus, c3rt_v2_PROCESS_PLANT, scope, [](bool attention, const std::string& said) {
        spdlog::log(attention ? spdlog::level::warn : spdlog::level::info, "{}", said);
      });
  const auto cycle = std::make_unique<Cycle>(scenario, options->seed, endpoint.status());
  spdlog::info("start scenario={} clock={} session={} step_s={} balls={}", scenario.name,
               lockstep ? "lockstep" : "realtime", settings.session_id, scenario.plant.world.step,
               scenario.plant.world.balls.size());
  const std::string failure = lockstep ? run_lockstep(bus, *cycle, endpoint, options->expect)
                                       : run_realtime(bus, *cycle, endpoint);
  if (!failure.empty()) {
    spdlog::error("stop: {}", failure);
    return config::kFailedWhileRunning;
  }
  spdlog::info("stop");
  return config::kStopped;
}

}  // namespace
}  // namespace c3rt::plant

int main(int argc, char** argv) try {
  // what MuJoCo warns about becomes a named error of the robot; it shall not write a log file of
  // its own
  mju_user_warning = [](const char*) {};
  return c3rt::plant::run(argc, argv);
} catch (const std::exception& error) {
  std::fprintf(stderr, "c3rt-plant: %s\n", error.what());
  return c3rt::config::kCouldNotStart;
}
