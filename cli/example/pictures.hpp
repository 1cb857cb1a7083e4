#pragma once
// The trajectory of an example as a table and as a picture.
#include <filesystem>
#include <string>
#include <vector>

#include "cli/report/figure.hpp"
#include "controller/example/closed_loop.hpp"

namespace c3rt::cli {

/// One row per simulation step: time, state, and the input and forces of the step that follows.
/// @throws std::runtime_error if the file cannot be written
void write_trajectory(const std::filesystem::path& file, const example::Experiment& experiment,
                      const example::Trajectory& trajectory);

/// Positions with their limits and goals, inputs and contact forces, over time; the examples with
/// fingers are shaded where a finger pushes, as Figures 3 and 5 of the paper.
std::vector<Panel> trajectory_panels(const example::Experiment& experiment,
                                     const example::Trajectory& trajectory);

}  // namespace c3rt::cli
