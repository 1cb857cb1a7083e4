#include "cli/doctor/findings.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace c3rt::cli::doctor {
namespace {

constexpr long long kMebibyte = 1 << 20;
constexpr long long kLockedBytes = 128 * kMebibyte;  // of c3rt-impedance, with room to grow
constexpr long long kLowRoom = 200 * kMebibyte;      // a run with logs takes 0.7 MB a second
constexpr long long kNoRoom = kMebibyte;             // below this a run does not start
constexpr int kFewCores = 2;
constexpr int kFewDays = 30;  // until keys expire
constexpr std::size_t kMostText = 300;

/// Clock sources that are read without a call into the kernel.
const std::set<std::string> kFastClocks{"tsc", "kvm-clock", "arch_sys_counter",
                                        "hyperv_clocksource_tsc_page"};
/// Governors that keep the clock rate up.
const std::set<std::string> kSteadyGovernors{"performance", "userspace"};

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  return all;
}

std::string mebibytes(long long bytes) {
  if (bytes == kUnlimited) return "unlimited";
  return bytes >= 10 * kMebibyte ? fmt::format("{} MiB", bytes / kMebibyte)
                                 : fmt::format("{} KiB", bytes / 1024);
}

class Examination {
 public:
  explicit Examination(const Facts& facts) : facts_(facts) {}

  std::vector<Finding> all() {
    processes();
    bus();
    rights();
    machine();
    profile();
    keys();
    folders();
    programs();
    return std::move(all_);
  }

 private:
  void add(const std::string& about, Verdict verdict, const std::string& said,
           const std::string& advice = "") {
    all_.push_back({group_, about, verdict, said, verdict == Verdict::kOk ? "" : advice});
  }
  std::string on_domain(const std::string& command) const {
    return facts_.domain == 0 ? command : command + fmt::format(" --domain {}", facts_.domain);
  }
  std::string restart() const {
    return on_domain("c3rt down") + "; " + on_domain("c3rt up SCENARIO");
  }

  void processes() {
    group_ = "processes";
    const auto heard = std::count_if(facts_.processes.begin(), facts_.processes.end(),
                                     [](const auto& process) { return process.heard; });
    if (!facts_.instance.empty()) add("instance", Verdict::kOk, facts_.instance);
    for (const std::string& note : facts_.notes) {
      add("supervisor", Verdict::kWarning, note,
          fmt::format("Read the process's log, then start anew: {}.", restart()));
    }
    if (heard == 0 && facts_.instance.empty()) {
      add("instance", Verdict::kWarning, fmt::format("nothing runs on domain {}", facts_.domain),
          fmt::format("Start one: {}.", on_domain("c3rt up SCENARIO")));
    }
    const bool wanted = heard > 0 || !facts_.instance.empty();
    std::set<std::uint64_t> sessions;
    for (const ProcessFacts& process : facts_.processes) {
      if (process.heard) sessions.insert(process.session);
      one(process, wanted);
    }
    if (sessions.size() > 1) {
      add("sessions", Verdict::kProblem,
          fmt::format("the processes are of {} sessions", sessions.size()),
          fmt::format("End those that are left over and start all together: {}.", restart()));
    }
    if (!facts_.strangers.empty()) {
      add("second writers", Verdict::kProblem,
          "other processes write what these write: " + joined(facts_.strangers),
          "End them where they were started, or use another --domain.");
    }
  }

  void one(const ProcessFacts& process, bool wanted) {
    if (!process.installed) {
      add(process.name, Verdict::kProblem, "there is no program c3rt-" + process.name,
          "Build or install it: ./c3rt build.");
    }
    if (!process.heard) {
      if (wanted)
        add(process.name, Verdict::kProblem, "nothing is heard of it on service/status",
            fmt::format("Look at its log in the instance's folder, then {}.", restart()));
      return;
    }
    std::string said = fmt::format("{}, pid {}", process.state, process.pid);
    if (!process.user.empty()) said += ", user " + process.user;
    if (!process.host.empty()) said += ", on " + process.host;
    said += fmt::format(", session {}", process.session);
    if (!process.program.empty()) said += ", " + process.program;
    if (!process.text.empty()) said += ": " + process.text.substr(0, kMostText);
    if (!process.in_service) {
      add(process.name, Verdict::kProblem, said,
          fmt::format("Look at its log in the instance's folder, then {}.", restart()));
    } else if (process.state == "degraded") {
      add(process.name, Verdict::kWarning, said,
          fmt::format("Do what it says, or bring the robot back: {}.", on_domain("c3rt recover")));
    } else {
      add(process.name, Verdict::kOk, said);
    }
    if (process.replaced) {
      add(process.name, Verdict::kWarning,
          "its program was replaced since it started: it runs an older version",
          fmt::format("Start it anew: {}.", restart()));
    }
    for (const std::string& refused : process.refused) {
      add(process.name, Verdict::kWarning, refused,
          fmt::format("Find the writer and correct it: {}.", on_domain("c3rt topics --peers")));
    }
  }

  void bus() {
    group_ = "DDS";
    for (const std::string& problem : facts_.peer_problems) {
      add("peers", Verdict::kProblem, problem,
          fmt::format("Give that client the QoS and type of the topic's row in {}.",
                      on_domain("c3rt topics --peers")));
    }
    const bool anyone = std::any_of(facts_.processes.begin(), facts_.processes.end(),
                                    [](const auto& process) { return process.heard; });
    if (facts_.peer_problems.empty() && anyone)
      add("peers", Verdict::kOk, "QoS and types of every reader and writer fit");
  }

  void rights() {
    group_ = "rights";
    const SchedulingFacts& s = facts_.scheduling;
    const std::string limit =
        s.priority_limit == kUnlimited ? "unlimited" : std::to_string(s.priority_limit);
    if (s.refused.empty()) {
      add("SCHED_FIFO", Verdict::kOk,
          fmt::format("priority {} is granted (rtprio limit {})", s.wanted_priority, limit));
    } else {
      add("SCHED_FIFO", Verdict::kWarning,
          fmt::format("priority {} is refused ({}; rtprio limit {}): the 1 kHz threads run as "
                      "ordinary ones and are late under load",
                      s.wanted_priority, s.refused, limit),
          "Put \"@realtime - rtprio 99\" into /etc/security/limits.d/realtime.conf, your user into "
          "the group (usermod -aG realtime $USER), and log in again.");
    }
    if (s.may_lock_any || s.locked_memory_bytes == kUnlimited) {
      add("memory lock", Verdict::kOk, "any amount may be locked");
    } else {
      add("memory lock", s.locked_memory_bytes >= kLockedBytes ? Verdict::kOk : Verdict::kWarning,
          fmt::format("{} may be locked, c3rt-impedance wants {}", mebibytes(s.locked_memory_bytes),
                      mebibytes(kLockedBytes)),
          "Put \"@realtime - memlock unlimited\" into /etc/security/limits.d/realtime.conf and log "
          "in again.");
    }
    if (s.refused.empty() && s.real_time_share_us >= 0) {
      add("real-time share", s.real_time_share_us > 0 ? Verdict::kOk : Verdict::kProblem,
          fmt::format("real-time threads may take {} ms of a second", s.real_time_share_us / 1000),
          "Allow them their share: sysctl kernel.sched_rt_runtime_us=950000.");
    }
    add("kernel", s.real_time_kernel ? Verdict::kOk : Verdict::kWarning,
        s.kernel + (s.real_time_kernel ? ", PREEMPT_RT" : ", no PREEMPT_RT: rare stalls of ms"),
        "For a real robot install one (apt install linux-image-rt-amd64), for the emulator measure "
        "this one: c3rt latency.");
  }

  void machine() {
    group_ = "machine";
    const MachineFacts& m = facts_.machine;
    add("cores", m.cores >= kFewCores ? Verdict::kOk : Verdict::kWarning,
        fmt::format("{} may be used", m.cores),
        "Give it two or more (taskset, the container's --cpus), or run in simulated time: c3rt run "
        "SCENARIO --clock lockstep.");
    if (m.clock_source.empty()) {
      add("clock source", Verdict::kOk, "the kernel does not tell it");
    } else {
      add("clock source", kFastClocks.count(m.clock_source) > 0 ? Verdict::kOk : Verdict::kWarning,
          m.clock_source +
              (kFastClocks.count(m.clock_source) > 0 ? "" : ": reading it goes through the kernel"),
          "If it is stable choose tsc: echo tsc > "
          "/sys/devices/system/clocksource/clocksource0/current_clocksource.");
    }
    const bool steady = std::all_of(
        m.governors.begin(), m.governors.end(),
        [](const std::string& governor) { return kSteadyGovernors.count(governor) > 0; });
    add("CPU governor", steady ? Verdict::kOk : Verdict::kWarning,
        m.governors.empty() ? "none is told (a virtual machine, or a fixed clock)"
                            : joined(m.governors) + (steady ? "" : ": cores slow down when idle"),
        "Keep the cores awake: cpupower frequency-set -g performance.");
  }

  void profile() {
    group_ = "DDS";
    const ProfileFacts& p = facts_.profile;
    if (p.refused.empty()) {
      add("profile", Verdict::kOk, fmt::format("{} ({})", p.name, p.path));
    } else {
      add("profile", Verdict::kProblem, p.refused,
          facts_.keys.problems.empty()
              ? "Correct the file, or take a shipped one: --profile loopback."
              : "Mend the keys, see below.");
    }
    for (const InterfaceFacts& interface : p.interfaces) {
      const bool usable = interface.exists && interface.up;
      add("interface " + interface.name, usable ? Verdict::kOk : Verdict::kProblem,
          usable             ? "is up"
          : interface.exists ? "is down"
                             : fmt::format("does not exist; this host has {}",
                                           p.available.empty() ? "none" : joined(p.available)),
          interface.exists
              ? fmt::format("Bring it up: ip link set {} up.", interface.name)
              : fmt::format("Name one of this host in {}.", p.path.empty() ? p.name : p.path));
    }
    if (p.any_interface) {
      add("interface", p.available.empty() ? Verdict::kProblem : Verdict::kOk,
          p.available.empty() ? "none is up" : "DDS chooses one of " + joined(p.available),
          "Bring one up: ip link set lo up.");
    }
  }

  void keys() {
    const KeyFacts& k = facts_.keys;
    if (k.folder.empty()) return;
    for (const KeyProblem& problem : k.problems)
      add("keys", Verdict::kProblem, problem.text, problem.advice);
    if (!k.problems.empty()) return;
    add("keys", k.days_left < kFewDays ? Verdict::kWarning : Verdict::kOk,
        fmt::format("{}, good until {}", k.folder, k.expires),
        "Make new ones in time, and copy them to every host: c3rt keys init --force.");
  }

  void folders() {
    group_ = "folders";
    for (const FolderFacts& folder : facts_.folders) {
      const std::string free = mebibytes(folder.free_bytes) + " free";
      if (!folder.refused.empty()) {
        add(folder.what, Verdict::kProblem, folder.path + ": " + folder.refused,
            folder.what == "runtime folder"
                ? "Give this user a folder of its own: export XDG_RUNTIME_DIR=/run/user/$(id -u)."
                : "Choose a folder that can be written: --out DIR.");
      } else if (folder.free_bytes < kLowRoom) {
        add(folder.what, folder.free_bytes < kNoRoom ? Verdict::kProblem : Verdict::kWarning,
            folder.path + ": " + free, fmt::format("Make room: du -xhd1 {}.", folder.path));
      } else {
        add(folder.what, Verdict::kOk, folder.path + ": " + free);
      }
    }
  }

  void programs() {
    group_ = "programs";
    for (const ToolFacts& tool : facts_.tools) {
      add(tool.program, tool.found ? Verdict::kOk : Verdict::kWarning,
          tool.found ? "found, for " + tool.needed_for
                     : "is not installed: without it no " + tool.needed_for,
          "Install it: " + tool.package + ".");
    }
  }

  const Facts& facts_;
  std::string group_;
  std::vector<Finding> all_;
};

}  // namespace

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kWarning:
      return "warning";
    case Verdict::kProblem:
      return "problem";
  }
  return "problem";
}

std::vector<Finding> findings(const Facts& facts) {
  std::vector<Finding> all = Examination(facts).all();
  // the profile comes after the machine, and belongs beside what is said of the peers
  const std::vector<std::string> order{"processes", "DDS",     "rights",
                                       "machine",   "folders", "programs"};
  const auto place = [&order](const Finding& finding) {
    return std::find(order.begin(), order.end(), finding.group) - order.begin();
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Finding& a, const Finding& b) { return place(a) < place(b); });
  return all;
}

int count(const std::vector<Finding>& all, Verdict verdict) {
  return static_cast<int>(std::count_if(all.begin(), all.end(), [verdict](const Finding& finding) {
    return finding.verdict == verdict;
  }));
}

std::string text(const Facts& facts, const std::vector<Finding>& all) {
  std::string result = fmt::format("c3rt {} on domain {}\n", facts.version, facts.domain);
  std::string group;
  for (const Finding& finding : all) {
    if (finding.group != group) result += fmt::format("{}\n", group = finding.group);
    result +=
        fmt::format("  {:<8} {:<16} {}\n", name_of(finding.verdict), finding.about, finding.said);
    if (!finding.advice.empty()) result += fmt::format("  {:<25} {}\n", "", finding.advice);
  }
  const int problems = count(all, Verdict::kProblem), warnings = count(all, Verdict::kWarning);
  return result + fmt::format("{} problem{}, {} warning{}\n", problems, problems == 1 ? "" : "s",
                              warnings, warnings == 1 ? "" : "s");
}

nlohmann::ordered_json to_json(const Facts& facts, const std::vector<Finding>& all) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Finding& finding : all) {
    list.push_back({{"group", finding.group},
                    {"about", finding.about},
                    {"verdict", name_of(finding.verdict)},
                    {"said", finding.said},
                    {"advice", finding.advice}});
  }
  return {{"version", facts.version},
          {"domain", facts.domain},
          {"profile", facts.profile.name},
          {"problems", count(all, Verdict::kProblem)},
          {"warnings", count(all, Verdict::kWarning)},
          {"findings", list}};
}

}  // namespace c3rt::cli::doctor
