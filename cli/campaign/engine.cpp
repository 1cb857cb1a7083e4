#include "cli/campaign/engine.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include <sys/wait.h>

#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "cli/supervisor.hpp"

namespace c3rt::cli::campaign {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);
constexpr double kGrace = 20.0;  // a run ends its own four processes first [s]
constexpr int kTailLines = 15;

struct Running {
  std::size_t job;
  double since;  // [s]
};

JobEnd end_of(const ChildExit& child, const Running& running) {
  JobEnd end{running.job, kProcessFailed, "", seconds_now() - running.since};
  if (WIFEXITED(child.status)) end.status = WEXITSTATUS(child.status);
  if (end.status != kDone && end.status != kCriterionFailed) {
    end.failure = child.name + " " + child.reason + "; the end of its log (" + child.log.string() +
                  "):\n" + tail(child.log, kTailLines);
  }
  return end;
}

}  // namespace

int cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

void run_here(const std::vector<Job>& jobs, int at_once, const Watch& watch) {
  Supervisor supervisor;
  std::map<std::string, Running> running;  // by the child's name
  std::size_t next = 0;
  const auto start = [&] {
    const Job& job = jobs[next];
    ChildSpec child{
        job.name, {(binary_directory() / "c3rt").string(), "run"}, job.folder / "run.log"};
    child.arguments.insert(child.arguments.end(), job.words.begin(), job.words.end());
    child.arguments.push_back("--out=" + job.folder.string());
    running[job.name] = {next++, seconds_now()};
    supervisor.start(child);
  };
  while ((next < jobs.size() || !running.empty()) && !watch.stop()) {
    while (next < jobs.size() && running.size() < static_cast<std::size_t>(at_once)) start();
    while (const auto child = supervisor.take_ended()) {
      const JobEnd end = end_of(*child, running.at(child->name));
      running.erase(child->name);
      watch.ended(end);
    }
    watch.look(static_cast<int>(running.size()));
    std::this_thread::sleep_for(kLook);
  }
  supervisor.stop(kGrace);
}

}  // namespace c3rt::cli::campaign
