#pragma once
// c3rt up with its four real processes, and a client that watches them over the bus.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <signal.h>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/dds.hpp"
#include "idl/text.hpp"
#include "tests/cli/folder.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/outcome.hpp"
#include "tests/system/loopback.hpp"

namespace c3rt::test {

class Service {
 public:
  /// @param options of c3rt up, more than the clock
  Service(const std::string& scenario, wire::ClockMode clock, const std::string& options = {})
      : clock_(clock) {
    for (const char* runtime : {"own", "other"})
      std::filesystem::create_directories(folder_.path() / runtime);
    const bool lockstep = clock == wire::ClockMode::kLockstep;
    const support::Outcome up =
        c3rt("up " + scenario + " --clock " + (lockstep ? "lockstep" : "realtime") + " --out '" +
             (folder_.path() / "out").string() + "' " + options);
    if (up.status != 0) throw std::runtime_error("c3rt up: " + up.output);
    bus_.emplace(settings());
    states_.emplace(*bus_, 1024);
    commands_.emplace(*bus_, 1024);
    plans_.emplace(*bus_);
    scenes_.emplace(*bus_);
    statuses_.emplace(*bus_);
    replies_.emplace(*bus_);
    requests_.emplace(*bus_);
    faults_.emplace(*bus_);
    targets_.emplace(*bus_);
    if (!until([&] { return state_.header.time_ns != 0 && status(c3rt_v2_PROCESS_VISION); }, 60.0))
      throw std::runtime_error("nothing is heard of the service");
  }
  ~Service() { c3rt("down"); }

  /// Status and words of a command of the person at the machine.
  support::Outcome c3rt(const std::string& arguments) const { return command(arguments, "own"); }
  /// The same of somebody who has not started the service.
  support::Outcome stranger(const std::string& arguments) const {
    return command(arguments, "other");
  }
  wire::BusSettings settings() const {
    wire::BusSettings bus = loopback_settings();
    bus.clock = clock_;
    return bus;
  }
  wire::Bus& bus() { return *bus_; }

  /// The service's time, simulated in lockstep [s].
  double time() const { return 1e-9 * static_cast<double>(state_.header.time_ns); }
  /// The next state, and all else that has come: what lasted between two looks is seen, too.
  void look() {
    if (!states_->take(state_)) {
      bus_->wait_for_data(20'000'000);
      (void)states_->take(state_);
    }
    while (commands_->take(command_)) {
    }
    while (plans_->take(plan_)) {
    }
    while (scenes_->take(scene_)) {
    }
    wire::ServiceStatus status{};
    while (statuses_->take(status)) statuses_newest_[index(status.process)] = status;
    wire::ServiceReply reply{};
    while (replies_->take(reply)) {
      for (auto& [id, answer] : answers_) {
        if (id == reply.request_id) answer = reply;
      }
    }
  }
  /// @return false if it has not happened after so long in the service's time; or after two minutes
  bool until(const std::function<bool()>& condition, double seconds) {
    std::optional<double> end;  // unknown until the first state tells the time
    const std::int64_t patience_ns = rt::now_ns() + 120'000'000'000;
    while (!condition()) {
      // states that wait to be looked at are of the past
      if (!end && state_.header.time_ns != 0)
        end = 1e-9 * static_cast<double>(std::max(
                         {state_.header.time_ns, command_.header.time_ns, scene_.header.time_ns})) +
              seconds;
      if ((end && time() > *end) || rt::now_ns() > patience_ns) return false;
      look();
    }
    return true;
  }
  void run(double seconds) {
    (void)until([] { return false; }, seconds);
  }
  /// The arm moves so far within so long.
  bool goes_on(double meters = 0.004, double seconds = 5.0) {
    const Eigen::Vector3d here = p_WE();
    return until([&] { return (p_WE() - here).norm() > meters; }, seconds);
  }

  using Answer = std::optional<wire::ServiceReply>;
  /// Of the three that have to do with the arm, as c3rt stop and c3rt recover ask. Empty: all are
  /// well, else what was not.
  std::string ask(c3rt_v2_RequestVerb verb) {
    answers_ = {};
    std::size_t i = 0;
    for (const wire::Process process :
         {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER}) {
      wire::ServiceRequest request{};
      request.process = process;
      request.verb = verb;
      request.request_id = answers_[i++].first = ++last_id_;
      requests_->write(request, rt::now_ns());
    }
    const std::string wrong = answers();
    // nothing brings a state before a later reply: what is read next is of after the answers
    std::int64_t answered_ns = 0;
    for (const auto& [id, answer] : answers_) {
      if (answer) answered_ns = std::max(answered_ns, answer->header.time_ns);
    }
    (void)until([&] { return state_.header.time_ns >= answered_ns; }, 1.0);
    return wrong;
  }
  /// Asked by `write`. Empty: taken, else why not.
  template <typename T, typename Write>
  std::string question(T sample, const Write& write) {
    answers_ = {};
    sample.request_id = answers_[0].first = ++last_id_;
    write(sample);
    return answers();
  }
  std::string target(const std::string& kind) {
    wire::TaskTarget target{};
    wire::set_text(target.kind, kind);
    return question(target,
                    [this](wire::TaskTarget& asked) { targets_->write(asked, rt::now_ns()); });
  }
  std::string inject(wire::Process process, c3rt_v2_FaultKind kind, double seconds) {
    wire::FaultInject fault{};
    fault.process = process;
    fault.kind = kind;
    fault.duration_s = seconds;
    return question(fault,
                    [this](wire::FaultInject& asked) { faults_->write(asked, rt::now_ns()); });
  }

  const wire::RobotState& state() const { return state_; }
  const wire::RobotCommand& command() const { return command_; }
  const wire::Plan& plan() const { return plan_; }
  const wire::Scene& scene() const { return scene_; }
  Eigen::Vector3d p_WE() const { return Eigen::Map<const Eigen::Vector3d>(state_.p_WE_m); }
  Eigen::Vector3d p_WB() const {
    return Eigen::Map<const Eigen::Vector3d>(scene_.objects[0].p_WB_m);
  }
  double ball_speed() const {
    return Eigen::Map<const Eigen::Vector3d>(scene_.objects[0].v_WB_m_per_s).norm();
  }
  const std::optional<wire::ServiceStatus>& status(wire::Process process) const {
    return statuses_newest_[index(process)];
  }
  std::string text(wire::Process process) const {
    return status(process) ? std::string(status(process)->text) : std::string();
  }
  std::uint64_t counter(wire::Process process, const char* name) const {
    const auto& newest = status(process);
    for (int i = 0; newest && i < c3rt_v2_COUNTERS; ++i) {
      if (std::strcmp(newest->counter_names[i], name) == 0) return newest->counters[i];
    }
    return 0;
  }
  /// What a process has refused of a topic for a reason.
  std::optional<wire::RefusedSamples> refused(wire::Process process, const char* topic,
                                              const char* reason) const {
    const auto& newest = status(process);
    for (int i = 0; newest && i < wire::refused_kinds(*newest); ++i) {
      const wire::RefusedSamples& samples = newest->refused[i];
      if (std::string(samples.topic) == topic && std::string(samples.reason) == reason)
        return samples;
    }
    return std::nullopt;
  }
  /// Follows commands and the plan.
  bool tracks() const {
    return state_.mode == c3rt_v2_ROBOT_MOVE && command_.mode == c3rt_v2_IMPEDANCE_TRACK;
  }

 private:
  support::Outcome command(const std::string& arguments, const std::string& runtime) const {
    return support::outcome_of("XDG_RUNTIME_DIR='" + (folder_.path() / runtime).string() +
                               "' '" C3RT_BINARY_DIRECTORY "/bin/c3rt' " + arguments +
                               " --domain " + std::to_string(test_domain()));
  }
  static std::size_t index(wire::Process process) { return static_cast<std::size_t>(process); }
  std::string answers() {
    const bool all = until(
        [&] {
          for (const auto& [id, answer] : answers_) {
            if (id != 0 && !answer) return false;
          }
          return true;
        },
        30.0);  // of a machine with more to do
    std::string wrong = all ? "" : "not all have answered; ";
    for (const auto& [id, answer] : answers_) {
      if (answer && !answer->ok)
        wrong += std::string(wire::process_name(answer->process)) + ": " + answer->text + "; ";
    }
    return wrong;
  }

  wire::ClockMode clock_;
  cli::Folder folder_;
  std::optional<wire::Bus> bus_;
  std::optional<wire::Reader<wire::RobotState>> states_;
  std::optional<wire::Reader<wire::RobotCommand>> commands_;
  std::optional<wire::Reader<wire::Plan>> plans_;
  std::optional<wire::Reader<wire::Scene>> scenes_;
  std::optional<wire::Reader<wire::ServiceStatus>> statuses_;
  std::optional<wire::Reader<wire::ServiceReply>> replies_;
  std::optional<wire::Writer<wire::ServiceRequest>> requests_;
  std::optional<wire::Writer<wire::FaultInject>> faults_;
  std::optional<wire::Writer<wire::TaskTarget>> targets_;
  std::array<std::pair<std::uint64_t, Answer>, 3> answers_{};  // id 0: not asked
  std::uint64_t last_id_ = static_cast<std::uint64_t>(rt::now_ns());
  wire::RobotState state_{};
  wire::RobotCommand command_{};
  wire::Plan plan_{};
  wire::Scene scene_{};
  std::array<std::optional<wire::ServiceStatus>, wire::kProcessCount> statuses_newest_{};
};

}  // namespace c3rt::test
