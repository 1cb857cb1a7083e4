#pragma once
// What /proc tells of a process.
#include <filesystem>
#include <string>

#include "cli/invariants/processes.hpp"

namespace c3rt::cli::soak {

/// @param log its file; empty: it has none
/// @return with pid 0 where there is no such process
invariants::ProcessSample look_at_process(const std::string& name, int pid,
                                          const std::filesystem::path& log = {});

}  // namespace c3rt::cli::soak
