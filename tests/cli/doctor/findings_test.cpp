#include "cli/doctor/findings.hpp"

#include <algorithm>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace c3rt::cli::doctor;
using Catch::Contains;

namespace {

constexpr long long kGibibyte = 1LL << 30;

/// Everything as it should be.
Facts healthy() {
  Facts facts;
  facts.version = "1.2.3";
  facts.instance = "c3rt up circle_slow";
  int pid = 10;
  for (const char* name : {"plant", "impedance", "planner", "vision"}) {
    ProcessFacts process;
    process.name = name;
    process.heard = process.in_service = true;
    process.pid = pid++;
    process.user = "ada";
    process.session = 7;
    process.state = "running";
    facts.processes.push_back(process);
  }
  facts.scheduling = {80, "", 99, kUnlimited, false, 950000, true, "6.1-rt"};
  facts.machine = {4, "tsc", {"performance"}};
  facts.profile = {"loopback", "loopback.xml", "", {{"lo", true, true}}, false, {"lo"}};
  facts.folders = {{"runtime folder", "/run/c3rt", "", kGibibyte}};
  facts.tools = {{"matplotlib", "apt install python3-matplotlib", "pictures", true}};
  return facts;
}

/// What is not well.
std::vector<Finding> complaints(const Facts& facts) {
  std::vector<Finding> all = findings(facts);
  all.erase(std::remove_if(all.begin(), all.end(),
                           [](const Finding& f) { return f.verdict == Verdict::kOk; }),
            all.end());
  return all;
}

}  // namespace

TEST_CASE("doctor: a healthy instance has no complaint, and says who runs") {
  const Facts facts = healthy();
  CHECK(complaints(facts).empty());
  CHECK_THAT(text(facts, findings(facts)), Contains("c3rt 1.2.3 on domain 0") &&
                                               Contains("running, pid 12, user ada, session 7") &&
                                               Contains("0 problems, 0 warnings"));
}

TEST_CASE("doctor: one change of the facts is one complaint, with what to do about it") {
  struct Case {
    const char* what;
    void (*change)(Facts&);
    Verdict verdict;
    const char* about;
    const char* said;
    const char* advice;
  };
  const auto [what, change, verdict, about, said, advice] = GENERATE(values<Case>({
      {"a process is silent", [](Facts& f) { f.processes[2].heard = false; }, Verdict::kProblem,
       "planner", "nothing is heard", "c3rt up SCENARIO"},
      {"a process failed",
       [](Facts& f) {
         f.processes[0].in_service = false;
         f.processes[0].state = "failed";
       },
       Verdict::kProblem, "plant", "failed", "log"},
      {"a process is degraded",
       [](Facts& f) {
         f.processes[0].state = "degraded";
         f.processes[0].text = "reflex";
       },
       Verdict::kWarning, "plant", "degraded, pid 10, user ada, session 7: reflex", "c3rt recover"},
      {"a program was replaced", [](Facts& f) { f.processes[3].replaced = true; },
       Verdict::kWarning, "vision", "older version", "c3rt down; c3rt up SCENARIO"},
      {"a program is missing", [](Facts& f) { f.processes[1].installed = false; },
       Verdict::kProblem, "impedance", "no program c3rt-impedance", "./c3rt build"},
      {"samples are refused", [](Facts& f) { f.processes[1].refused = {"refused 3 samples"}; },
       Verdict::kWarning, "impedance", "refused 3 samples", "c3rt topics --peers"},
      {"a process of another session", [](Facts& f) { f.processes[1].session = 6; },
       Verdict::kProblem, "sessions", "2 sessions", "c3rt down"},
      {"a second plant", [](Facts& f) { f.strangers = {"c3rt-plant (pid 99)"}; },
       Verdict::kProblem, "second writers", "c3rt-plant (pid 99)", "--domain"},
      {"the supervisor gave up", [](Facts& f) { f.notes = {"vision was given up"}; },
       Verdict::kWarning, "supervisor", "vision was given up", "c3rt down"},
      {"a client of other QoS", [](Facts& f) { f.peer_problems = {"plan: requests RELIABLE"}; },
       Verdict::kProblem, "peers", "plan: requests RELIABLE", "c3rt topics --peers"},
      {"a key is missing",
       [](Facts& f) {
         f.keys.folder = "/keys";
         f.keys.problems = {{"vision/identity.key is missing", "c3rt keys init"}};
       },
       Verdict::kProblem, "keys", "vision/identity.key is missing", "c3rt keys init"},
      {"keys expire soon",
       [](Facts& f) {
         f.keys.folder = "/keys";
         f.keys.days_left = 3;
         f.keys.expires = "2026-12-02";
       },
       Verdict::kWarning, "keys", "good until 2026-12-02", "--force"},
      {"no real-time priority",
       [](Facts& f) {
         f.scheduling.refused = "Operation not permitted";
         f.scheduling.priority_limit = 0;
       },
       Verdict::kWarning, "SCHED_FIFO", "Operation not permitted; rtprio limit 0", "rtprio 99"},
      {"little may be locked",
       [](Facts& f) { f.scheduling.locked_memory_bytes = 8 << 20; }, Verdict::kWarning,
       "memory lock", "8192 KiB", "memlock unlimited"},
      {"real-time threads may take nothing",
       [](Facts& f) { f.scheduling.real_time_share_us = 0; }, Verdict::kProblem, "real-time share",
       "0 ms", "sched_rt_runtime_us"},
      {"an ordinary kernel", [](Facts& f) { f.scheduling.real_time_kernel = false; },
       Verdict::kWarning, "kernel", "no PREEMPT_RT", "c3rt latency"},
      {"one core", [](Facts& f) { f.machine.cores = 1; }, Verdict::kWarning, "cores", "1 may",
       "--clock lockstep"},
      {"a slow clock", [](Facts& f) { f.machine.clock_source = "hpet"; }, Verdict::kWarning,
       "clock source", "hpet", "echo tsc"},
      {"cores that slow down",
       [](Facts& f) { f.machine.governors = {"performance", "powersave"}; }, Verdict::kWarning,
       "CPU governor", "performance, powersave", "cpupower"},
      {"a profile that DDS refuses", [](Facts& f) { f.profile.refused = "not well formed"; },
       Verdict::kProblem, "profile", "not well formed", "--profile loopback"},
      {"an interface that is not there",
       [](Facts& f) {
         f.profile.interfaces = {{"eth7", false, false}};
       },
       Verdict::kProblem, "interface eth7", "does not exist; this host has lo", "loopback.xml"},
      {"an interface that is down",
       [](Facts& f) {
         f.profile.interfaces = {{"lo", true, false}};
       },
       Verdict::kProblem, "interface lo", "is down", "ip link set lo up"},
      {"a folder that cannot be written",
       [](Facts& f) { f.folders[0].refused = "Read-only file system"; }, Verdict::kProblem,
       "runtime folder", "/run/c3rt: Read-only file system", "XDG_RUNTIME_DIR"},
      {"little room", [](Facts& f) { f.folders[0].free_bytes = 100 << 20; }, Verdict::kWarning,
       "runtime folder", "100 MiB free", "du -xhd1 /run/c3rt"},
      {"no room", [](Facts& f) { f.folders[0].free_bytes = 4096; }, Verdict::kProblem,
       "runtime folder", "4 KiB free", "du -xhd1 /run/c3rt"},
      {"no matplotlib", [](Facts& f) { f.tools[0].found = false; }, Verdict::kWarning,
       "matplotlib", "without it no pictures", "apt install python3-matplotlib"},
  }));
  CAPTURE(what);
  Facts facts = healthy();
  change(facts);
  const std::vector<Finding> found = complaints(facts);
  REQUIRE(found.size() == 1);
  CHECK(found[0].verdict == verdict);
  CHECK(found[0].about == about);
  CHECK_THAT(found[0].said, Contains(said));
  CHECK_THAT(found[0].advice, Contains(advice));
}

TEST_CASE("doctor: where nothing runs that is a warning alone, with the command that starts it") {
  Facts facts = healthy();
  facts.domain = 3;
  facts.instance.clear();
  for (ProcessFacts& process : facts.processes) process.heard = process.in_service = false;
  const std::vector<Finding> found = complaints(facts);
  REQUIRE(found.size() == 1);
  CHECK(found[0].verdict == Verdict::kWarning);
  CHECK(found[0].advice == "Start one: c3rt up SCENARIO --domain 3.");
}

TEST_CASE("doctor: capability to lock memory makes the limit meaningless") {
  Facts facts = healthy();
  facts.scheduling.locked_memory_bytes = 0;
  facts.scheduling.may_lock_any = true;
  CHECK(complaints(facts).empty());
}

TEST_CASE("doctor: JSON has every finding, with the counts of problems and warnings") {
  Facts facts = healthy();
  facts.processes[2].heard = false;
  facts.machine.cores = 1;
  const std::vector<Finding> all = findings(facts);
  const nlohmann::ordered_json json = to_json(facts, all);
  CHECK(json["problems"] == 1);
  CHECK(json["warnings"] == 1);
  CHECK(json["findings"].size() == all.size());
  const auto planner = std::find_if(json["findings"].begin(), json["findings"].end(),
                                    [](const auto& f) { return f["about"] == "planner"; });
  REQUIRE(planner != json["findings"].end());
  CHECK((*planner)["verdict"] == "problem");
  CHECK((*planner)["group"] == "processes");
}
