#pragma once
// From the command line that the processes share to the bus.
#include "config/process_options.hpp"
#include "idl/dds.hpp"

namespace c3rt::wire {

inline BusSettings bus_settings(const config::ProcessOptions& options, Process process) {
  BusSettings settings;
  settings.domain = options.domain;
  settings.profile_uri = options.dds_profile;
  settings.identity = process_name(process);
  settings.clock =
      options.clock == config::Clock::kLockstep ? ClockMode::kLockstep : ClockMode::kRealtime;
  settings.session_id = options.session;
  return settings;
}

}  // namespace c3rt::wire
