#pragma once
// The time series that a report's figures are made of, as tables.
#include <filesystem>

#include "cli/report/series.hpp"
#include "controller/task/task.hpp"

namespace c3rt::cli {

/// Writes, all from the task's begin on and in W: objects.csv, where each object truly was and how
/// far from where it should be, by the task and by its other readings; end_effector.csv, where it
/// was and where the plan wanted it, for each command that tracks one; path.csv, the corners of the
/// desired path. Without a beginning of the task they have a head alone.
/// @param task as the run's seed made it
/// @throws std::runtime_error if they cannot be written
void write_series(const std::filesystem::path& folder, const Series& series,
                  const task::Task& task);

}  // namespace c3rt::cli
