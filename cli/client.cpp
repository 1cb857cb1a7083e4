#include "cli/client.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "cli/keys/keystore.hpp"
#include "cli/lock.hpp"
#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "config/scenario.hpp"
#include "controller/planner/adjustable_weights.hpp"
#include "controller/planner/target.hpp"
#include "idl/client/client.hpp"
#include "idl/convert.hpp"
#include "idl/faults.hpp"

namespace c3rt::cli {
namespace {

constexpr double kReply = 10.0;    // until a process must have answered [s]
constexpr double kPresence = 0.5;  // in which a process that runs tells its status [s]

/// Asks all before one has to answer, and prints the answers. @return an exit status
template <typename T>
int ask(const Seat& seat, const std::vector<T>& samples) {
  client::Client client(bus_settings(seat));
  std::vector<std::optional<client::Reply>> replies;
  try {
    replies = client.ask(samples, kReply);
  } catch (const client::NobodyListens& error) {
    fmt::print(stderr, "c3rt: error: {}; is an instance up{}?\n", error.what(),
               seat.dds_profile == "loopback" ? " (of another host: --dds lan)" : "");
    return kProcessFailed;
  }
  int exit_status = kDone;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const char* process = wire::process_name(wire::asked_process(samples[i]));
    if (!replies[i]) {
      const auto heard = client.status(kPresence);
      const bool there =
          heard[static_cast<std::size_t>(wire::asked_process(samples[i]))].has_value();
      fmt::print(stderr, "c3rt: error: {} did not answer within {:.0f} s{}\n", process, kReply,
                 there ? "" : ", and nothing is heard of it on service/status: it does not run");
      exit_status = kProcessFailed;
      continue;
    }
    fmt::print(replies[i]->ok ? stdout : stderr, "{}: {}\n", process,
               config::printable(replies[i]->text, replies[i]->text.size()));
    if (!replies[i]->ok) exit_status = std::max<int>(exit_status, kCriterionFailed);
  }
  return exit_status;
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

bool in_service(const wire::ServiceStatus& status) {
  return status.state == c3rt_v2_SERVICE_RUNNING || status.state == c3rt_v2_SERVICE_DEGRADED;
}

bool has_come_up(const wire::ServiceStatus& status, bool without_plant) {
  return in_service(status) || (without_plant && status.state == c3rt_v2_SERVICE_STARTING);
}

int request(const Seat& seat, const std::vector<wire::Process>& processes,
            c3rt_v2_RequestVerb verb) {
  // that the arm follows again is the work of all of them
  std::vector<wire::ServiceRequest> wanted;
  for (const wire::Process process : processes) {
    wire::ServiceRequest sample{};
    sample.process = process;
    sample.verb = verb;
    wanted.push_back(sample);
  }
  return ask(seat, wanted);
}

int inject(const Seat& seat, wire::FaultInject fault) {
  const auto scenario = running_scenario(seat);
  const std::string refused =
      wire::refusal(fault, scenario ? fault_scope(*scenario) : wire::FaultScope{});
  if (!refused.empty()) throw UsageError("fault: " + refused);
  return ask(seat, std::vector{fault});
}

int order(const Seat& seat, const wire::RobotOrder& order) {
  const wire::Refusal refused = wire::validate(order);
  if (refused) throw UsageError("robot: " + to_text(refused));
  return ask(seat, std::vector{order});
}

int set_target(const Seat& seat, const task::Request& request) {
  const auto scenario = running_scenario(seat);
  try {
    const planner::Target target = planner::load_target(request);
    const std::string refused =
        scenario ? planner::refusal(target, planner::target_limits(scenario->planner)) : "";
    if (!refused.empty()) throw task::RequestError(refused);
    return ask(seat, std::vector{wire::task_target(request)});
  } catch (const task::RequestError& error) {
    throw UsageError(std::string("target: ") + error.what());
  }
}

int list_weights(const Seat& seat) {
  const auto scenario = running_scenario(seat);
  if (!scenario)
    throw UsageError(fmt::format(
        "weights: expected an instance of this user on domain {}, got none", seat.domain));
  const std::vector<planner::AdjustableWeight> all = planner::adjustable_weights(scenario->planner);
  if (all.empty()) {
    fmt::print(
        "{} allows no other weights than its own; with --set planner.weights.adjustable_by=100 "
        "it does\n",
        scenario->name);
    return kCriterionFailed;
  }
  fmt::print("{:<32} {:>12} {:>12} {:>12}\n", "weight", "scenario's", "least", "most");
  for (const planner::AdjustableWeight& weight : all)
    fmt::print("{:<32} {:>12.6g} {:>12.6g} {:>12.6g}\n", weight.name, weight.value, weight.min,
               weight.max);
  return kDone;
}

int set_weights(const Seat& seat, const std::map<std::string, double>& weights) {
  const auto scenario = running_scenario(seat);
  const std::string refused =
      scenario ? planner::refusal(weights, planner::adjustable_weights(scenario->planner)) : "";
  if (!refused.empty()) throw UsageError("weights: " + refused);
  try {
    return ask(seat, std::vector{wire::planner_weights(weights)});
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

}  // namespace c3rt::cli
