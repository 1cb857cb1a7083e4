#include "cli/service.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/fields.hpp"
#include "cli/guests.hpp"
#include "cli/keeper.hpp"
#include "cli/lock.hpp"
#include "cli/neighbours.hpp"
#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "cli/table.hpp"
#include "cli/watch.hpp"
#include "idl/client/client.hpp"
#include "idl/process.hpp"
#include "idl/security.hpp"

namespace c3rt::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr auto kStart = std::chrono::seconds(60);       // until every process must run
constexpr double kListen = 1.5, kListenWithKeys = 5.0;  // [s]
constexpr auto kEnd = std::chrono::seconds(20);         // until the supervisor must have ended

/// Starts this program again, detached from the terminal, with its words in a file.
pid_t detach(const std::vector<std::string>& words, const std::filesystem::path& log) {
  const std::string self = (binary_directory() / "c3rt").string();
  std::vector<char*> arguments{const_cast<char*>(self.c_str())};
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t pid = fork();
  if (pid != 0) return pid;
  setsid();
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0644);
  const int nothing = open("/dev/null", O_RDONLY);
  if (output < 0 || nothing < 0 || dup2(nothing, 0) < 0 || dup2(output, 1) < 0 ||
      dup2(output, 2) < 0)
    _exit(126);
  execv(self.c_str(), arguments.data());
  _exit(127);
}

/// Where else an instance could be.
std::string hint(const Seat& seat) {
  return seat.dds_profile == "loopback" ? " (seen from this host; of another one: --dds lan)" : "";
}

/// Whose the instance is that our locks do not know.
std::string not_yours(const Seat& seat, const std::vector<Neighbour>& others) {
  return fmt::format("domain {}: an instance that is not yours, or was started by hand: {}",
                     seat.domain, text(others));
}

bool is_up(const std::optional<wire::ServiceStatus>& status) {
  return status && in_service(*status);
}

int count_in_service(const Services& services) {
  return static_cast<int>(std::count_if(services.begin(), services.end(), is_up));
}

/// Names of our processes that are not in service, with a comma between them.
std::string not_in_service(const Services& services, const LaunchSettings& settings) {
  std::string names;
  for (int i = 0; i < wire::kProcessCount; ++i) {
    const std::string name = wire::process_name(static_cast<wire::Process>(i));
    const auto& status = services[static_cast<std::size_t>(i)];
    if (i == c3rt_v2_PROCESS_RECORDER || settings.leaves_out(name) ||
        (status && has_come_up(*status, settings.leaves_out("plant"))))
      continue;
    names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

}  // namespace

int up(const LaunchSettings& settings, const std::vector<std::string>& serve_arguments) {
  // a mistake is told here, not in the log of the detached supervisor; the lock is free again right
  // after
  { const Launch check(settings); }
  const std::filesystem::path log = supervisor_log(settings.domain);
  const pid_t pid = detach(serve_arguments, log);
  if (pid < 0) throw ProcessFailure("cannot start the supervisor");
  const auto deadline = steady_clock::now() + kStart;
  const Seat seat{settings.domain, settings.dds_profile};
  std::string missing = "the supervisor";
  std::optional<wire::Bus> bus;
  while (steady_clock::now() < deadline && !wire::StopFlag::requested()) {
    int ended = 0;
    if (waitpid(pid, &ended, WNOHANG) == pid) {
      fmt::print(stderr, "{}", tail(log, 30));
      return WIFEXITED(ended) && WEXITSTATUS(ended) != kDone ? WEXITSTATUS(ended) : kProcessFailed;
    }
    const auto instance = holder(runtime_directory(), settings.domain);
    if (!instance || instance->pid != pid) {
      std::this_thread::sleep_for(milliseconds(50));
      continue;
    }
    // one bus for all looks: where it is secure, processes take a second and more to trust it
    if (!bus) bus.emplace(bus_settings(seat));
    const Services services = client::listen(*bus, 1.0);
    missing = not_in_service(services, settings);
    if (missing.empty()) {
      fmt::print("{} is up (pid {}, domain {}, logs in {}/logs)\n{}", instance->scenario, pid,
                 settings.domain, instance->out, service_table(services));
      // those of now: they were written while it was listened
      const auto now = holder(runtime_directory(), settings.domain);
      if (now) {
        for (const std::string& note : now->notes) fmt::print("{}\n", note);
      }
      return kDone;
    }
    std::this_thread::sleep_for(milliseconds(100));
  }
  kill(pid, SIGTERM);
  waitpid(pid, nullptr, 0);
  if (wire::StopFlag::requested()) return kCriterionFailed;
  throw ProcessFailure("not running after " + std::to_string(kStart.count()) + " s: " + missing);
}

int serve(const LaunchSettings& settings) {
  Launch launch(settings);
  launch.require_free_bus();
  Supervisor supervisor;
  launch.start(supervisor, false);
  if (!settings.without.empty()) launch.lock().set_notes({"waits for " + guests_text(launch)});
  fmt::print("{} runs on domain {}\n", launch.scenario().name, settings.domain);
  std::fflush(stdout);
  std::optional<ChildExit> end;
  Keeper keeper(launch, supervisor);
  while (!wire::StopFlag::requested() && !(end = keeper.step()))
    std::this_thread::sleep_for(milliseconds(20));
  stop(supervisor);
  if (!end) {
    launch.lock().set_ended("stopped");
    return kDone;
  }
  launch.lock().set_ended(end->name + " " + end->reason);
  throw ProcessFailure(failure_text(*end));
}

int down(const Seat& seat) {
  const auto instance = holder(runtime_directory(), seat.domain);
  if (!instance) {
    const wire::Bus bus(bus_settings(seat));
    const std::vector<Neighbour> others = neighbours(bus, kLookForNeighbours);
    if (others.empty()) {
      fmt::print("nothing runs on domain {}{}\n", seat.domain, hint(seat));
      return kDone;
    }
    fmt::print(stderr, "c3rt: error: {}; it can be ended only where it was started\n",
               not_yours(seat, others));
    return kCriterionFailed;
  }
  if (kill(instance->pid, SIGTERM) != 0) {
    throw ProcessFailure(fmt::format("cannot signal pid {} ({} {})", instance->pid, instance->verb,
                                     instance->scenario));
  }
  const auto deadline = steady_clock::now() + kEnd;
  while (holder(runtime_directory(), seat.domain)) {
    if (steady_clock::now() >= deadline) {
      throw ProcessFailure(fmt::format("pid {} ({} {}) has not ended within {} s", instance->pid,
                                       instance->verb, instance->scenario, kEnd.count()));
    }
    std::this_thread::sleep_for(milliseconds(20));
  }
  fmt::print("{} {} (pid {}) has ended\n", instance->verb, instance->scenario, instance->pid);
  return kDone;
}

int status(const Seat& seat) {
  const auto instance = holder(runtime_directory(), seat.domain);
  const wire::BusSettings settings = bus_settings(seat);
  wire::Bus bus(settings);
  // processes on a busy machine take seconds to trust a new participant
  const bool secure = wire::is_secure(read_text(settings.profile_uri));
  const Services services = client::listen(bus, secure ? kListenWithKeys : kListen);
  const bool any =
      std::any_of(services.begin(), services.end(), [](const auto& s) { return s.has_value(); });
  if (instance) {
    fmt::print("domain {}: c3rt {} {} ({}, pid {}, since {}){}\n", seat.domain, instance->verb,
               instance->scenario, instance->clock, instance->pid, instance->started,
               instance->out.empty() ? "" : ", results in " + instance->out);
    for (const std::string& note : instance->notes) fmt::print("  {}\n", note);
  } else if (any) {
    fmt::print("{}\n", not_yours(seat, neighbours(bus, kLookForNeighbours)));
  } else {
    fmt::print("domain {}: nothing runs{}", seat.domain, hint(seat));
    const auto last = last_instance(runtime_directory(), seat.domain);
    if (last && !last->ended.empty())
      fmt::print("; the last, c3rt {} {}: {}", last->verb, last->scenario, last->ended);
    fmt::print("\n");
    return kCriterionFailed;
  }
  fmt::print("{}", service_table(services));
  for (const wire::PeerProblem& problem : bus.problems())
    fmt::print("  problem: {}\n", problem.text);
  return count_in_service(services) == 4 ? kDone : kProcessFailed;
}

}  // namespace c3rt::cli
