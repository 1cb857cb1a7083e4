// In the place of one of the four processes: says that it runs, and obeys stop and recover. The
// plant has a reflex when the impedance process is another one than before, the planner says which
// target it was told. Which one it is, its name tells.
#include <cstdlib>
#include <cstring>
#include <string>

#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/replies.hpp"

using namespace c3rt;

int main(int argc, char** argv) {
  const wire::StopFlag stop;
  wire::BusSettings settings;
  for (int i = 2; i < argc; ++i) {
    const auto value = [&](const char* option) -> const char* {
      const std::size_t length = std::strlen(option);
      return std::strncmp(argv[i], option, length) == 0 ? argv[i] + length : nullptr;
    };
    if (const char* text = value("--domain="))
      settings.domain = static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
    if (const char* text = value("--session="))
      settings.session_id = std::strtoull(text, nullptr, 10);
    if (const char* text = value("--dds-profile=")) settings.profile_uri = text;
  }
  const std::string name = argv[0];
  wire::Process process = c3rt_v2_PROCESS_PLANT;
  for (int i = 0; i < wire::kProcessCount; ++i) {
    const auto candidate = static_cast<wire::Process>(i);
    if (name.find(std::string("c3rt-") + wire::process_name(candidate)) != std::string::npos)
      process = candidate;
  }
  wire::Bus bus(settings);
  wire::StatusReporter status(bus, process);
  status.set_state(c3rt_v2_SERVICE_RUNNING, "a stub");
  wire::Reader<wire::ServiceRequest> requests(bus);
  wire::Reader<wire::ServiceStatus> statuses(bus, 64);
  wire::Reader<wire::TaskTarget> targets(bus);
  wire::Replies replies(bus, process);
  int impedance = 0;
  while (!wire::StopFlag::requested()) {
    bus.wait_for_data(10'000'000);
    wire::ServiceRequest request{};
    while (requests.take(request)) {
      if (request.process != process) continue;
      if (request.verb == c3rt_v2_REQUEST_RECOVER)
        status.set_state(c3rt_v2_SERVICE_RUNNING, "a stub");
      if (request.verb == c3rt_v2_REQUEST_STOP)
        status.set_state(c3rt_v2_SERVICE_DEGRADED, "stopped by a person; request recover");
      replies.answer(request.request_id, true, "done", rt::now_ns());
    }
    wire::TaskTarget target{};
    while (targets.take(target)) {
      if (process != c3rt_v2_PROCESS_PLANNER) continue;
      status.set_state(c3rt_v2_SERVICE_RUNNING, "a stub, told target " + std::string(target.kind) +
                                                    " with " + target.parameters[1].name + " " +
                                                    std::to_string(target.parameters[1].values[0]));
      replies.answer(target.request_id, target.kind != std::string("pose"), "of the stub",
                     rt::now_ns());
    }
    wire::ServiceStatus other{};
    while (statuses.take(other)) {
      if (process != c3rt_v2_PROCESS_PLANT || other.process != c3rt_v2_PROCESS_IMPEDANCE) continue;
      if (impedance != 0 && other.pid != impedance)
        status.set_state(c3rt_v2_SERVICE_DEGRADED, "reflex: of the stub");
      impedance = other.pid;
    }
  }
  return 0;
}
