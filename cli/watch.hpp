#pragma once
// Four processes that run, until their goal or until something ends them.
#include <functional>
#include <string>

#include "cli/recorder.hpp"
#include "cli/supervisor.hpp"

namespace c3rt::cli {

/// How a run ended before its goal.
struct Ending {
  bool interrupted = false;
  std::string failed;   // one line: the process and how it ended
  std::string details;  // with the end of its log
};

/// Watches until the recorder's goal is reached or something ends the run.
/// @param show gets what is seen, twenty times a second
Ending watch(Supervisor& supervisor, const Recorder& recorder,
             const std::function<void(const Live&)>& show);
/// The same until something else is so.
Ending watch_until(const std::function<bool()>& over, Supervisor& supervisor,
                   const Recorder& recorder, const std::function<void(const Live&)>& show);

}  // namespace c3rt::cli
