#pragma once
// How runs are made, as a person says it: the same words for every command that makes many.
#include <optional>
#include <string>

#include "cli/campaign/runs.hpp"

namespace c3rt::cli::campaign {

struct EngineSettings {
  std::optional<double> duration;  // of each run [s]; nothing: the scenario's
  int at_once = 0;                 // runs; 0: as many as there are cores
  bool fresh = false;
  std::string engine = "local";  // or "dask"
  std::string address;           // of Dask's scheduler; empty: a cluster of its own on this machine
};

/// For run_all, without folder and title. @param settings outlive it
/// @throws UsageError for an address without Dask
RunSettings run_settings(const EngineSettings& settings, const Stop& stop);

}  // namespace c3rt::cli::campaign
