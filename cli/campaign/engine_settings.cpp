#include "cli/campaign/engine_settings.hpp"

#include "cli/campaign/dask.hpp"
#include "cli/paths.hpp"

namespace c3rt::cli::campaign {

RunSettings run_settings(const EngineSettings& settings, const Stop& stop) {
  RunSettings how;
  how.stop = stop;
  how.fresh = settings.fresh;
  if (settings.at_once > 0) how.at_once = settings.at_once;
  if (settings.engine == "dask") {
    how.engine = [&settings](const std::vector<Job>& jobs, int at_once, const Watch& watch) {
      run_on_dask(jobs, settings.address, at_once, watch);
    };
  } else if (!settings.address.empty()) {
    throw UsageError("--address: only with --engine dask");
  }
  return how;
}

}  // namespace c3rt::cli::campaign
