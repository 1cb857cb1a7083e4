#include "cli/doctor/facts.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "cli/fields.hpp"
#include "cli/keys/keystore.hpp"
#include "cli/lock.hpp"
#include "cli/neighbours.hpp"
#include "cli/paths.hpp"
#include "cli/python.hpp"
#include "config/text.hpp"
#include "idl/client/client.hpp"
#include "idl/discovery.hpp"
#include "idl/process.hpp"
#include "idl/security.hpp"

namespace c3rt::cli::doctor {
namespace fs = std::filesystem;
namespace {

constexpr int kServoPriority = 80;  // of the shipped scenarios' servo threads
// for words of the processes: an instance that is known to be there is given more, since a busy
// machine takes its time and a false alarm is worse [s]
constexpr double kListen = 1.5, kListenToInstance = 5.0;
// until a type that is defined differently is known to be: idl/peers
constexpr auto kMatching = std::chrono::milliseconds(2200);

/// A line of a file of the kernel, "" where there is none.
std::string line_of(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

bool in_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path file = fs::path(folder.empty() ? "." : folder) / program;
    if (access(file.c_str(), X_OK) == 0 && fs::is_regular_file(file)) return true;
  }
  return false;
}

long long limit_of(decltype(RLIMIT_RTPRIO) resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return 0;
  return limit.rlim_cur == RLIM_INFINITY ? kUnlimited : static_cast<long long>(limit.rlim_cur);
}

/// What the kernel says to a thread that wants it; the thread ends at once.
std::string refusal_of_fifo(int priority) {
  int error = 0;
  std::thread([&error, priority] {
    sched_param parameter{};
    parameter.sched_priority = priority;
    error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
  }).join();
  return error == 0 ? "" : std::strerror(error);
}

bool has_capability(int bit) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, 7, "CapEff:") == 0)
      return (std::strtoull(line.c_str() + 7, nullptr, 16) >> bit & 1U) != 0;
  }
  return false;
}

SchedulingFacts scheduling() {
  constexpr int kIpcLock = 14;  // CAP_IPC_LOCK
  SchedulingFacts facts;
  facts.wanted_priority = kServoPriority;
  facts.refused = refusal_of_fifo(kServoPriority);
  facts.priority_limit = limit_of(RLIMIT_RTPRIO);
  facts.locked_memory_bytes = limit_of(RLIMIT_MEMLOCK);
  facts.may_lock_any = has_capability(kIpcLock);
  const std::string share = line_of("/proc/sys/kernel/sched_rt_runtime_us");
  facts.real_time_share_us = share.empty() ? kUnlimited : std::atoll(share.c_str());
  facts.real_time_kernel = line_of("/sys/kernel/realtime") == "1";
  utsname name{};
  if (uname(&name) == 0) facts.kernel = name.release;
  return facts;
}

MachineFacts machine() {
  MachineFacts facts;
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) facts.cores = CPU_COUNT(&set);
  facts.clock_source = line_of("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  std::set<std::string> governors;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &set)) continue;
    const std::string governor =
        line_of(fmt::format("/sys/devices/system/cpu/cpu{}/cpufreq/scaling_governor", cpu));
    if (!governor.empty()) governors.insert(governor);
  }
  facts.governors.assign(governors.begin(), governors.end());
  return facts;
}

/// Interfaces of this host, and whether each is up.
std::map<std::string, bool> host_interfaces() {
  std::map<std::string, bool> all;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return all;
  for (const ifaddrs* at = first; at != nullptr; at = at->ifa_next)
    all[at->ifa_name] = (at->ifa_flags & IFF_UP) != 0;
  freeifaddrs(first);
  return all;
}

/// The interfaces of a profile's text, and whether it leaves the choice to DDS.
void read_interfaces(const std::string& xml, ProfileFacts& facts) {
  const std::map<std::string, bool> host = host_interfaces();
  for (const auto& [name, up] : host) {
    if (up) facts.available.push_back(name);
  }
  // what stands in a comment is no interface
  const std::string text = std::regex_replace(xml, std::regex("<!--[^]*?-->"), "");
  const std::regex element("<NetworkInterface\\b([^>]*)>");
  const std::regex name("\\bname\\s*=\\s*[\"']([^\"']*)[\"']");
  for (std::sregex_iterator at(text.begin(), text.end(), element), end; at != end; ++at) {
    const std::string attributes = (*at)[1];
    std::smatch found;
    if (!std::regex_search(attributes, found, name)) {
      facts.any_interface = true;
      continue;
    }
    const auto known = host.find(found[1]);
    facts.interfaces.push_back(
        {config::printable(found[1]), known != host.end(), known != host.end() && known->second});
  }
  if (facts.interfaces.empty()) facts.any_interface = true;
}

FolderFacts folder(const std::string& what, const fs::path& wanted) {
  // a folder that is made when it is needed: what counts is where it will be
  std::error_code error;
  fs::path existing = fs::absolute(wanted, error);
  while (!existing.empty() && !fs::exists(existing, error) && existing != existing.root_path())
    existing = existing.parent_path();
  FolderFacts facts{what, fs::absolute(wanted, error).string(), "", 0};
  if (!fs::is_directory(existing, error)) {
    facts.refused = existing.string() + " is no folder";
  } else {
    try {
      require_room(existing);
    } catch (const std::exception& reason) {
      const std::string said = reason.what();
      facts.refused = said.substr(said.rfind(": ") + 2);
    }
  }
  struct statvfs room {};
  if (statvfs(existing.c_str(), &room) == 0)
    facts.free_bytes =
        static_cast<long long>(room.f_bavail) * static_cast<long long>(room.f_frsize);
  return facts;
}

std::vector<FolderFacts> folders(const std::optional<Instance>& instance) {
  std::vector<FolderFacts> all;
  try {
    all.push_back(folder("runtime folder", runtime_directory()));
  } catch (const UsageError& error) {
    all.push_back({"runtime folder", "XDG_RUNTIME_DIR/c3rt", error.what(), 0});
  }
  all.push_back(folder("output folder", "out"));
  if (instance && !instance->out.empty()) all.push_back(folder("instance's folder", instance->out));
  return all;
}

std::vector<ToolFacts> tools() {
  std::vector<ToolFacts> all{
      {"coacd", "pip install coacd", "convex pieces (object add --decompose)"},
      {"python3", "apt install python3", "many runs (campaign, tune, reproduce)"}};
  for (ToolFacts& tool : all) tool.found = in_path(tool.program);
  all.push_back({"matplotlib", "apt install python3-matplotlib",
                 "pictures (run, reproduce, campaign, latency)",
                 !find_python({"matplotlib"}).program.empty()});
  return all;
}

/// The file that a process of this host runs.
void look_at_program(ProcessFacts& process) {
  std::error_code error;
  const std::string link =
      fs::read_symlink("/proc/" + std::to_string(process.pid) + "/exe", error).string();
  if (error) return;
  constexpr const char* kGone = " (deleted)";
  process.replaced = link.size() > std::strlen(kGone) &&
                     link.compare(link.size() - std::strlen(kGone), std::string::npos, kGone) == 0;
  process.program = process.replaced ? link.substr(0, link.size() - std::strlen(kGone)) : link;
}

std::string text(const wire::RefusedSamples& refused) {
  return fmt::format("refused {} samples of {} ({}), the newest: {}", refused.count,
                     config::printable(refused.topic), config::printable(refused.reason),
                     config::printable(refused.latest, 300));
}

/// The four by the words of service/status, and who else writes.
void look_at_processes(wire::Bus& bus, Facts& facts) {
  const Services services =
      client::listen(bus, facts.instance.empty() ? kListen : kListenToInstance);
  const std::vector<Neighbour> writers = neighbours(bus, kLookForNeighbours);
  for (ProcessFacts& process : facts.processes) {
    for (int i = 0; i < wire::kProcessCount; ++i) {
      const auto& status = services[static_cast<std::size_t>(i)];
      if (!status || process.name != wire::process_name(static_cast<wire::Process>(i))) continue;
      process.heard = true;
      process.in_service = in_service(*status);
      process.pid = status->pid;
      process.session = status->header.session_id;
      process.state = name_of(status->state);
      process.text = config::printable(status->text, sizeof status->text);
      for (int k = 0; k < wire::refused_kinds(*status); ++k)
        process.refused.push_back(text(status->refused[k]));
      const auto writer = std::find_if(writers.begin(), writers.end(), [&](const Neighbour& one) {
        return one.pid == process.pid;
      });
      if (writer == writers.end()) continue;
      process.user = writer->user;
      const bool here = writer->host == wire::host_name();
      if (!here) process.host = config::printable(writer->host);
      if (here) look_at_program(process);
    }
  }
  for (const Neighbour& writer : writers) {
    const bool one_of_four = std::any_of(
        facts.processes.begin(), facts.processes.end(),
        [&](const auto& process) { return process.heard && process.pid == writer.pid; });
    if (!one_of_four) facts.strangers.push_back(writer.text());
  }
}

/// Between all readers and writers; a reader of ours on every topic finds what no pair shows.
void look_at_peers(wire::Bus& bus, Facts& facts) {
  std::vector<std::shared_ptr<void>> readers;
  wire::for_each_topic([&](const auto& sample) {
    using T = std::decay_t<decltype(sample)>;
    readers.push_back(std::make_shared<wire::Reader<T>>(bus, 16));
  });
  // the first look begins the time that a definition may take to be matched
  (void)bus.problems();
  const auto end = std::chrono::steady_clock::now() + kMatching;
  while (std::chrono::steady_clock::now() < end && !wire::StopFlag::requested()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    bus.wait_for_data(1'000'000);
  }
  std::set<std::string> topics;
  for (const wire::PeerProblem& problem : wire::peer_disagreements(bus)) {
    topics.insert(problem.topic);
    facts.peer_problems.push_back(config::printable(problem.text, 500));
  }
  for (const wire::PeerProblem& problem : bus.problems()) {
    if (topics.count(problem.topic) == 0)
      facts.peer_problems.push_back(config::printable(problem.text, 500));
  }
}

constexpr std::time_t kDay_s = 86400;

/// Of all that this host has; without a folder nothing is known of whom it needs.
void look_at_keys(Facts& facts) {
  if (!wire::is_secure(read_text(facts.profile.path))) return;
  KeyFacts& found = facts.keys;
  const fs::path folder = wire::keys_directory();
  found.folder = folder.string();
  std::vector<std::string> identities{"client"};
  std::error_code error;
  for (const ProcessFacts& process : facts.processes)
    if (fs::is_directory(folder / process.name, error)) identities.push_back(process.name);
  const keys::Findings findings = keys::check(folder, identities, std::time(nullptr));
  for (const keys::Complaint& complaint : findings.problems)
    found.problems.push_back({complaint.text, complaint.advice});
  found.expires = keys::date(findings.expires);
  found.days_left = static_cast<int>((findings.expires - std::time(nullptr)) / kDay_s);
}

void look_at_bus(const Seat& seat, const std::string& used, Facts& facts) {
  ProfileFacts& profile = facts.profile;
  try {
    profile.path = used.empty() ? dds_profile_path(seat.dds_profile).string() : used;
    read_interfaces(read_text(profile.path), profile);
    look_at_keys(facts);
    if (!facts.keys.problems.empty()) {
      profile.refused = "cannot be joined with these keys";
      return;
    }
    const wire::BusSettings settings = bus_settings(seat);
    wire::Bus bus(settings);
    look_at_processes(bus, facts);
    look_at_peers(bus, facts);
  } catch (const UsageError& error) {
    profile.refused = error.what();
  } catch (const wire::WireError& error) {
    profile.refused = error.what();
  }
}

}  // namespace

Facts collect(const Seat& seat) {
  Facts facts;
  facts.version = C3RT_VERSION;
  facts.domain = seat.domain;
  facts.profile.name = seat.dds_profile;
  std::optional<Instance> instance;
  try {
    instance = holder(runtime_directory(), seat.domain);
  } catch (const UsageError&) {
    // told by the runtime folder's own finding
  }
  if (instance) {
    facts.instance = fmt::format("c3rt {} {} ({}, pid {}, since {}), results in {}", instance->verb,
                                 instance->scenario, instance->clock, instance->pid,
                                 instance->started, instance->out);
    facts.notes = instance->notes;
    if (!instance->profile.empty()) facts.profile.name = fs::path(instance->profile).stem();
  }
  for (int i = 0; i < wire::kProcessCount; ++i) {
    if (i == c3rt_v2_PROCESS_RECORDER) continue;
    ProcessFacts process;
    process.name = wire::process_name(static_cast<wire::Process>(i));
    const fs::path program = process_directory() / ("c3rt-" + process.name);
    process.installed = access(program.c_str(), X_OK) == 0;
    facts.processes.push_back(process);
  }
  facts.scheduling = scheduling();
  facts.machine = machine();
  facts.folders = folders(instance);
  facts.tools = tools();
  look_at_bus(seat, instance ? instance->profile : "", facts);
  return facts;
}

}  // namespace c3rt::cli::doctor
