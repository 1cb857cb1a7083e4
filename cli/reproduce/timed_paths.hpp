#pragma once
// The runs behind Figures 16 and 18: paths in time, with three cameras.
#include <array>
#include <vector>

#include "cli/reproduce/rolling.hpp"

namespace c3rt::cli::reproduce {

struct TimedPath {
  const char *name, *scenario;
};

/// The three of the paper.
constexpr std::array<TimedPath, 3> kTimedPaths{
    {{"circle", "path_circle"}, {"line", "path_line"}, {"rectangle", "path_rectangle"}}};

/// One run of each, two rounds, seed 1, cameras in the place of the emulated sensor, with logs.
std::vector<Run> timed_path_runs(const Context& context);

/// A table of errors after the first second, one column for each path.
Rows timed_path_rows(const std::vector<Run>& runs);

/// {path: {command, report}}
ordered_json timed_path_results(const char* what, const std::vector<Run>& runs);

}  // namespace c3rt::cli::reproduce
