#pragma once
// What the first trial of an example decided, as tables.
#include <filesystem>

#include "cli/example/trials.hpp"

namespace c3rt::cli {

/// The cost (14) of what the plant did in the N control steps from each on; kNone where the trial
/// ends before.
Eigen::VectorXd actual_costs(const example::Experiment& experiment,
                             const example::Trajectory& trajectory);

/// decisions.csv, one row per control step: time, cost-to-go (14) of the plan, that of what came,
/// time of the decision; of the exact search also gap and proof, with a trace also the mean time of
/// one projection and how many were not solved.
/// @throws std::runtime_error if the file cannot be written
void write_decisions(const std::filesystem::path& file, const example::Experiment& experiment,
                     const TrialsResult& result);

/// iterates.csv of the first decision's trace, one row per iteration of Algorithm 1 and stage: z by
/// the names of its quantities, and after the forces the gaps E x + F λ + H u + c of them.
/// @throws std::runtime_error if the file cannot be written
void write_iterates(const std::filesystem::path& file, const example::Experiment& experiment,
                    const TrialsResult& result);

}  // namespace c3rt::cli
