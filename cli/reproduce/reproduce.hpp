#pragma once
// `c3rt reproduce`: the tables and figures of section VI, our numbers beside the paper's.
#include <string>
#include <vector>

#include "cli/progress.hpp"

namespace c3rt::cli::reproduce {

struct Settings {
  std::string what;
  std::string out;             // folder; empty: out/reproduce
  bool quick = false;          // short loops: for a look, not for numbers
  bool fresh = false;          // compute everything anew
  std::string seeds = "1..5";  // of comparison and push_anything
  double miqp_limit = 15.0;    // of one monolithic MIQP [s]
};

/// table1, table2, …
std::vector<std::string> names();

/// Prints the table and writes WHAT.png and WHAT.json; finished parts are kept in parts/ and used
/// again by the next call with equal settings.
/// @return an exit status: kDone, or kCriterionFailed where it was interrupted
/// @throws config::ConfigError, UsageError
int reproduce(const Settings& settings, const Stop& stop);

}  // namespace c3rt::cli::reproduce
