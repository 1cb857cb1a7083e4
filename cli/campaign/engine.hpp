#pragma once
// Who makes the runs of a campaign: the cores of this machine, or Dask.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "cli/progress.hpp"

namespace c3rt::cli::campaign {

/// One call of `c3rt run`.
struct Job {
  std::string name;                // "seed 7"
  std::vector<std::string> words;  // after "c3rt run", without --out
  std::filesystem::path folder;    // of its results
};

struct JobEnd {
  std::size_t job;      // index into the jobs
  int status;           // exit status; kProcessFailed where it was killed
  std::string failure;  // what went wrong, with the end of its log; empty for status 0 and 1
  double wall_s;
};

/// What an engine tells while it works.
struct Watch {
  Stop stop;                                 // asked several times a second
  std::function<void(const JobEnd&)> ended;  // a job's report.json lies in its folder
  std::function<void(int running)> look;     // several times a second
};

/// As many `c3rt run` of this program at once as wanted, each in a DDS domain of its own. Their
/// words are in FOLDER/run.log. Returns when all have ended or a stop is wanted; then all that were
/// running have been ended and are not reported. One thread calls it.
void run_here(const std::vector<Job>& jobs, int at_once, const Watch& watch);

/// Cores that this process may use.
int cores();

}  // namespace c3rt::cli::campaign
