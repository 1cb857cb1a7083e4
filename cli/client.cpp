#include "cli/client.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/keys/keystore.hpp"
#include "cli/lock.hpp"
#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "config/scenario.hpp"
#include "controller/planner/target.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/convert.hpp"
#include "idl/faults.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace {

using std::chrono::milliseconds;

constexpr double kDiscovery = 3.0;  // until a peer must have been found [s]
constexpr double kPresence = 0.5;   // in which a process that runs tells its status [s]
constexpr double kReply = 10.0;     // until a process must have answered [s]

/// Looks every 10 ms. @return false when the time is over or a stop was requested
bool wait_until(double seconds, const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (wire::StopFlag::requested() || std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return true;
}

/// Whether the process tells its status.
bool speaks(wire::Bus& bus, wire::Process process) {
  wire::Reader<wire::ServiceStatus> reader(bus, 64);
  return wait_until(kPresence, [&] {
    wire::ServiceStatus status{};
    bool heard = false;
    while (reader.take(status)) heard = heard || status.process == process;
    return heard;
  });
}

/// A sample that is answered: written to whoever listens, and the reply printed.
template <typename T>
class Question {
 public:
  explicit Question(const Seat& seat) : seat_(seat), bus_(bus_settings(seat)) {}

  /// @return false, and says so, where nobody takes it
  bool find_peers() {
    if (wait_until(kDiscovery, [this] {
          return writer_.matched_readers() > 0 && replies_.matched_writers() > 0;
        })) {
      std::this_thread::sleep_for(milliseconds(200));  // others may be discovered a moment later
      return true;
    }
    fmt::print(stderr, "c3rt: error: nobody listens to {} on domain {}; is an instance up{}?\n",
               wire::topic<T>().name, seat_.domain,
               seat_.dds_profile == "loopback" ? " (of another host: --dds lan)" : "");
    return false;
  }
  /// Asks all before one has to answer. @return an exit status
  int ask(std::vector<std::pair<T, wire::Process>> samples) {
    const auto first_id = static_cast<std::uint64_t>(rt::now_ns());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i].first.request_id = first_id + i;
      if (!writer_.write(samples[i].first, rt::now_ns())) {
        fmt::print(stderr, "c3rt: error: {} could not be sent\n", wire::topic<T>().name);
        return kProcessFailed;
      }
    }
    std::vector<std::optional<wire::ServiceReply>> replies(samples.size());
    wait_until(kReply, [&] {
      wire::ServiceReply reply{};
      while (replies_.take(reply)) {
        const std::uint64_t i = reply.request_id - first_id;
        if (i < replies.size()) replies[i] = reply;
      }
      return std::all_of(replies.begin(), replies.end(),
                         [](const auto& answer) { return answer.has_value(); });
    });
    int exit_status = kDone;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const char* process = wire::process_name(samples[i].second);
      if (!replies[i]) {
        const bool there = speaks(bus_, samples[i].second);
        fmt::print(stderr, "c3rt: error: {} did not answer within {:.0f} s{}\n", process, kReply,
                   there ? "" : ", and nothing is heard of it on service/status: it does not run");
        exit_status = kProcessFailed;
        continue;
      }
      fmt::print(replies[i]->ok ? stdout : stderr, "{}: {}\n", process,
                 config::printable(replies[i]->text, sizeof replies[i]->text));
      if (!replies[i]->ok) exit_status = std::max<int>(exit_status, kCriterionFailed);
    }
    return exit_status;
  }

 private:
  const Seat& seat_;
  wire::Bus bus_;
  wire::Writer<T> writer_{bus_};
  wire::Reader<wire::ServiceReply> replies_{bus_};
};

template <typename T>
int ask(const Seat& seat, const T& sample, wire::Process process) {
  Question<T> question(seat);
  return question.find_peers() ? question.ask({{sample, process}}) : kProcessFailed;
}

/// That of the instance on this domain; nothing where none of this user runs, or where it cannot be
/// read any more.
std::optional<config::Scenario> running_scenario(const Seat& seat) {
  const auto instance = holder(runtime_directory(), seat.domain);
  if (!instance || instance->file.empty()) return std::nullopt;
  try {
    return config::load_scenario(instance->file, instance->overrides);
  } catch (const config::ConfigError&) {
    return std::nullopt;
  }
}

wire::FaultScope fault_scope(const config::Scenario& scenario) {
  wire::FaultScope scope;
  for (const plant::ObjectParameters& object : scenario.plant.world.objects)
    scope.object_masses.push_back(object.object.mass);
  const bool cameras = scenario.vision.source == vision::SourceKind::kCameras;
  scope.cameras = cameras ? static_cast<int>(scenario.vision.cameras.size()) : 0;
  return scope;
}

}  // namespace

wire::BusSettings bus_settings(const Seat& seat) {
  wire::BusSettings bus;
  bus.domain = seat.domain;
  bus.shares_clock = false;  // the seat may be on another host
  const auto instance = holder(runtime_directory(), seat.domain);
  bus.profile_uri = instance && !instance->profile.empty()
                        ? instance->profile
                        : dds_profile_path(seat.dds_profile).string();
  keys::require_keys(bus.profile_uri, {"client"});
  if (instance) {
    bus.clock =
        instance->clock == "lockstep" ? wire::ClockMode::kLockstep : wire::ClockMode::kRealtime;
    bus.session_id = instance->session;
  }
  return bus;
}

Services listen(wire::Bus& bus, double seconds) {
  wire::Reader<wire::ServiceStatus> reader(bus, 64);
  Services services;
  const std::uint64_t session = bus.session_id();
  wait_until(seconds, [&] {
    wire::ServiceStatus status{};
    while (reader.take(status)) {
      const auto process = static_cast<std::size_t>(status.process);
      // what an older instance left behind is no word of this one; who plays a process may know
      // none
      const std::uint64_t theirs = status.header.session_id;
      const bool ours = session == 0 || theirs == 0 || theirs == session;
      if (ours && process < services.size()) services[process] = status;
    }
    return std::count_if(services.begin(), services.end(),
                         [](const auto& s) { return s.has_value(); }) == 4;
  });
  return services;
}

bool in_service(const wire::ServiceStatus& status) {
  return status.state == c3rt_v2_SERVICE_RUNNING || status.state == c3rt_v2_SERVICE_DEGRADED;
}

int request(const Seat& seat, const std::vector<wire::Process>& processes,
            c3rt_v2_RequestVerb verb) {
  Question<wire::ServiceRequest> question(seat);
  if (!question.find_peers()) return kProcessFailed;
  // that the arm follows again is the work of all of them
  std::vector<std::pair<wire::ServiceRequest, wire::Process>> wanted;
  for (const wire::Process process : processes) {
    wire::ServiceRequest sample{};
    sample.process = process;
    sample.verb = verb;
    wanted.emplace_back(sample, process);
  }
  return question.ask(std::move(wanted));
}

int inject(const Seat& seat, wire::FaultInject fault) {
  const auto scenario = running_scenario(seat);
  const std::string refused =
      wire::refusal(fault, scenario ? fault_scope(*scenario) : wire::FaultScope{});
  if (!refused.empty()) throw UsageError("fault: " + refused);
  return ask(seat, fault, fault.process);
}

int set_target(const Seat& seat, const task::Request& request) {
  const auto scenario = running_scenario(seat);
  try {
    const planner::Target target = planner::load_target(request);
    const std::string refused =
        scenario ? planner::refusal(target, planner::target_limits(scenario->planner)) : "";
    if (!refused.empty()) throw task::RequestError(refused);
    return ask(seat, wire::task_target(request), c3rt_v2_PROCESS_PLANNER);
  } catch (const task::RequestError& error) {
    throw UsageError(std::string("target: ") + error.what());
  }
}

}  // namespace c3rt::cli
