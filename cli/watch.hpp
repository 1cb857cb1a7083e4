#pragma once
// A run, until its goal or until something ends it: of four processes, or of their nodes in this
// one.
#include <cstdint>
#include <functional>
#include <string>

#include "cli/recorder.hpp"
#include "cli/supervisor.hpp"
#include "config/scenario.hpp"
#include "idl/process.hpp"

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
/// As watch(), with the nodes in this process.
/// @param tell gets what they say  @param show gets what is seen, every 0.2 s of simulated time
Ending watch_in_process(
    const config::Scenario& scenario, std::uint64_t seed, const wire::BusSettings& bus,
    Recorder& recorder,
    const std::function<void(wire::Process, bool attention, const std::string&)>& tell,
    const std::function<void(const Live&)>& show);

/// Stops the processes, and tells a person which of them had to be killed.
void stop(Supervisor& supervisor);

}  // namespace c3rt::cli
