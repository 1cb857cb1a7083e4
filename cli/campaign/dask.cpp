#include "cli/campaign/dask.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/campaign/python.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "cli/program.hpp"
#include "cli/supervisor.hpp"
#include "config/show.hpp"

namespace c3rt::cli::campaign {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr auto kLookAtWorkers = std::chrono::milliseconds(200);
constexpr double kAnswer = 60.0;        // of a helper program, on a cold disk [s]
constexpr double kWorkersGrace = 30.0;  // the runs on the workers end first [s]
constexpr const char* kPrograms[] = {"c3rt", "c3rt-plant", "c3rt-impedance", "c3rt-planner",
                                     "c3rt-vision"};

/// The full path of a program of the PATH, for exec.
std::string found(const std::string& program) {
  if (program.find('/') != std::string::npos) return program;
  std::string path = std::getenv("PATH") != nullptr ? std::getenv("PATH") : "/usr/bin:/bin";
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t colon = std::min(path.find(':', from), path.size());
    const fs::path candidate = fs::path(path.substr(from, colon - from)) / program;
    if (access(candidate.c_str(), X_OK) == 0) return candidate.string();
    from = colon + 1;
  }
  return program;
}

std::string sha256(const fs::path& file) {
  const ProgramEnd end = run_program({"sha256sum", file.string()}, "", kAnswer);
  if (!end.ok() || end.output.size() < 64)
    throw UsageError("--engine dask: cannot hash " + file.string() + ": sha256sum " + end.reason);
  return end.output.substr(0, 64);
}

json order(const std::vector<Job>& jobs, const std::string& address, int at_once) {
  json programs = json::object();
  for (const char* name : kPrograms) programs[name] = sha256(binary_directory() / name);
  json list = json::array();
  json scenarios = json::object();  // whole, so that a worker needs no file of ours
  for (const Job& job : jobs) {
    list.push_back({{"words", job.words}, {"folder", job.folder.string()}});
    const std::string& file = job.words.front();
    if (!scenarios.contains(file)) scenarios[file] = config::whole_scenario(file);
  }
  return {{"program", (binary_directory() / "c3rt").string()},
          {"programs_sha256", programs},
          {"address", address},
          {"at_once", at_once},
          {"scenarios", scenarios},
          {"jobs", list}};
}

/// What a finished job left; nothing if it has not finished.
std::optional<JobEnd> end_of(const std::vector<Job>& jobs, std::size_t index) {
  std::ifstream stream(jobs[index].folder / "end.json");
  if (!stream) return std::nullopt;
  const json end = json::parse(stream, nullptr, false);
  if (!end.is_object()) return std::nullopt;
  return JobEnd{index, end.at("status"), end.at("failure"), end.at("wall_s")};
}

}  // namespace

void run_on_dask(const std::vector<Job>& jobs, const std::string& address, int at_once,
                 const Watch& watch) {
  const std::string interpreter = found(python_with("--engine dask", "distributed", "distributed"));
  const fs::path folder = jobs.front().folder.parent_path();
  for (const Job& job : jobs) fs::remove(job.folder / "end.json");
  write_text(folder / "dask.json", order(jobs, address, at_once).dump(1) + "\n");
  Supervisor supervisor;
  supervisor.start({"dask",
                    {interpreter, python_file("campaign", "dask_runs.py").string(),
                     (folder / "dask.json").string()},
                    folder / "dask.log"});
  std::vector<std::size_t> waiting(jobs.size());
  for (std::size_t i = 0; i < waiting.size(); ++i) waiting[i] = i;
  std::optional<ChildExit> gone;
  while (!waiting.empty() && !watch.stop()) {
    // what it left before it ended still counts
    gone = supervisor.poll();
    const auto first_left = std::remove_if(waiting.begin(), waiting.end(), [&](std::size_t index) {
      const auto end = end_of(jobs, index);
      if (end) watch.ended(*end);
      return end.has_value();
    });
    waiting.erase(first_left, waiting.end());
    if (gone) break;
    watch.look(std::min(at_once, static_cast<int>(waiting.size())));
    std::this_thread::sleep_for(kLookAtWorkers);
  }
  supervisor.stop(kWorkersGrace);
  if (!gone || waiting.empty()) return;
  const std::string text = tail(folder / "dask.log", 15);
  if (WIFEXITED(gone->status) && WEXITSTATUS(gone->status) == kUsage)
    throw UsageError("--engine dask: " + text);
  for (const std::size_t index : waiting) {
    watch.ended({index, kProcessFailed,
                 jobs[index].name + ": Dask's bridge " + gone->reason + "; the end of its log (" +
                     (folder / "dask.log").string() + "):\n" + text,
                 0.0});
  }
}

}  // namespace c3rt::cli::campaign
