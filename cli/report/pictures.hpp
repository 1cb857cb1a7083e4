#pragma once
// The report's pictures.
#include <filesystem>
#include <string>

#include "cli/report/metrics.hpp"

namespace c3rt::cli {

/// Draws path.png (as Figure 11 of the paper), path_error.png, end_effector_error.png,
/// solve_time.png and latency.png.
/// @return what is missing and why; empty if all are there
std::string draw_pictures(const std::filesystem::path& directory, const Series& series,
                          const task::Task& task, const Figures& figures, const std::string& title);

}  // namespace c3rt::cli
