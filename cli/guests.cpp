#include "cli/guests.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/client.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace {

constexpr double kPatience = 60.0;  // as long as the plant waits in lockstep [s]
constexpr std::int64_t kLook_ns = 50'000'000;
constexpr double kCommandsInARow = 0.02;  // that the robot bears to lose [s]

GuestLimits limits_of(const std::string& process, const config::Scenario& scenario) {
  if (process == "planner")
    return {scenario.impedance.limits.plan_timeout, "impedance.limits.plan_timeout_s"};
  if (process == "vision") return {scenario.planner.estimate_timeout, "planner.estimate_timeout_s"};
  return {kCommandsInARow, "20 cycles, after which the robot stops itself"};
}

const char* topic_of(const std::string& process) {
  if (process == "planner") return wire::topic<wire::Plan>().name;
  if (process == "vision") return wire::topic<wire::ObjectEstimate>().name;
  return wire::topic<wire::RobotCommand>().name;
}

/// Who reads the stream and counts what it refuses.
wire::Process reader_of(const std::string& process) {
  if (process == "planner") return c3rt_v2_PROCESS_IMPEDANCE;
  return process == "vision" ? c3rt_v2_PROCESS_PLANNER : c3rt_v2_PROCESS_PLANT;
}

std::vector<GuestRefusals> refusals_of(const std::string& process, const Live& live) {
  std::vector<GuestRefusals> all;
  const std::string topic = topic_of(process);
  const wire::Process reader = reader_of(process);
  if (const auto& status = live.services[static_cast<std::size_t>(reader)]) {
    for (int i = 0; i < wire::refused_kinds(*status); ++i) {
      const wire::RefusedSamples& refused = status->refused[i];
      if (refused.topic == topic)
        all.push_back({wire::process_name(reader), refused.count, refused.reason, refused.latest});
    }
  }
  if (!all.empty()) return all;
  for (const wire::RefusedCount& refused : live.refused) {
    if (refused.topic == topic)
      all.push_back({"the recorder", refused.count, reason_name(refused.reason), refused.latest});
  }
  return all;
}

}  // namespace

std::set<int> guests_on(wire::Bus& bus, const std::vector<std::string>& names, double seconds) {
  std::set<int> pids;
  wire::Reader<wire::ServiceStatus> statuses(bus, 64);
  for (const double end = wall_time() + seconds; wall_time() < end;) {
    bus.wait_for_data(kLook_ns);
    wire::ServiceStatus status{};
    while (statuses.take(status)) {
      if (std::find(names.begin(), names.end(), wire::process_name(status.process)) != names.end())
        pids.insert(status.pid);
    }
  }
  return pids;
}

std::string guests_text(const Launch& launch) {
  return fmt::format("{}: yours, on domain {}, profile {}", fmt::join(launch.without(), ", "),
                     launch.bus().domain, launch.profile());
}

bool await_guests(const Launch& launch, Supervisor& supervisor) {
  wire::BusSettings settings = launch.bus();
  settings.clock = wire::ClockMode::kRealtime;
  wire::Bus bus(settings);
  wire::Reader<wire::ServiceStatus> statuses(bus, 64);
  std::set<std::string> missing(launch.without().begin(), launch.without().end());
  for (const double end = wall_time() + kPatience; !missing.empty();) {
    if (wire::StopFlag::requested()) return false;
    if (const auto ended = supervisor.poll()) throw ProcessFailure(failure_text(*ended));
    if (wall_time() > end) {
      throw ProcessFailure(fmt::format(
          "nobody has come to play {} for {:g} s on domain {}, profile {}: a client says on "
          "service/status that it is in service (docs/clients.md)",
          fmt::join(missing, ", "), kPatience, launch.bus().domain, launch.profile()));
    }
    bus.wait_for_data(kLook_ns);
    wire::ServiceStatus status{};
    while (statuses.take(status)) {
      if (in_service(status)) missing.erase(wire::process_name(status.process));
    }
  }
  return true;
}

std::vector<Guest> look_at_guests(const Launch& launch, const Series& series, const Live& live) {
  std::vector<Guest> guests;
  for (const std::string& name : launch.without()) {
    guests.push_back(
        look_at_guest(name, series, limits_of(name, launch.scenario()), refusals_of(name, live)));
  }
  return guests;
}

}  // namespace c3rt::cli
