#include "cli/invariants/processes.hpp"

#include <algorithm>

namespace c3rt::cli::invariants {
namespace {

// processes are looked at every few seconds: what two looks tell is one violation [s]
constexpr double kEpisode = 15.0;

}  // namespace

void Processes::hear(double time, const ProcessSample& sample) {
  const auto violated = [&](const char* name, double value, double limit, const char* unit) {
    violations_.add(name, sample.name, time, value, limit, unit, kEpisode);
  };
  const auto [found, fresh] = known_.try_emplace(sample.name);
  Course& course = found->second;
  if (sample.pid == 0) {
    violated("lost", 0.0, 1.0, "processes");
    course.newest = sample;
    return;
  }
  if (course.pid != 0 && course.pid != sample.pid) {
    violated("restarted", sample.pid, course.pid, "pid");
    course = {};
  }
  if (course.pid == 0) {
    course.pid = sample.pid;
    course.first = time;
    course.at_first = course.largest = sample;
    course.logged = sample.log;
  } else {
    // a log that became smaller was begun anew
    course.logged += sample.log >= course.newest.log ? sample.log - course.newest.log : sample.log;
  }
  course.last = time;
  course.newest = sample;
  course.largest.memory = std::max(course.largest.memory, sample.memory);
  course.largest.threads = std::max(course.largest.threads, sample.threads);
  course.largest.descriptors = std::max(course.largest.descriptors, sample.descriptors);
  if (!course.settled) {
    if (time - course.first < limits_.settles_after) return;
    course.settled = true;
    course.at_settling = sample;
    course.logged_at_settling = course.logged;
    return;
  }
  const ProcessSample& then = course.at_settling;
  const double memory = static_cast<double>(then.memory) + limits_.memory;
  if (static_cast<double>(sample.memory) > memory)
    violated("memory", static_cast<double>(sample.memory), memory, "bytes");
  if (sample.threads > then.threads) violated("threads", sample.threads, then.threads, "threads");
  if (sample.descriptors > then.descriptors)
    violated("descriptors", sample.descriptors, then.descriptors, "descriptors");
  const double hours = (time - course.first - limits_.settles_after) / 3600.0;
  const double log = static_cast<double>(course.logged_at_settling) + limits_.log +
                     std::max(0.0, hours) * limits_.log_per_hour;
  if (static_cast<double>(course.logged) > log)
    violated("log_growth", static_cast<double>(course.logged), log, "bytes");
}

}  // namespace c3rt::cli::invariants
