#pragma once
// Runs of a campaign on the machines of a Dask cluster.
#include <string>
#include <vector>

#include "cli/campaign/engine.hpp"

namespace c3rt::cli::campaign {

/// Like run_here, through dask_runs.py: needs Python 3 with the package distributed when it is
/// called, and c3rt of the same build on every worker.
/// @param address of a scheduler, tcp://host:port; empty: a cluster of at_once workers on this
/// machine. With an address the cluster's own workers decide how many run at once
/// @throws UsageError if Python, the package or the scheduler is not there
void run_on_dask(const std::vector<Job>& jobs, const std::string& address, int at_once,
                 const Watch& watch);

}  // namespace c3rt::cli::campaign
