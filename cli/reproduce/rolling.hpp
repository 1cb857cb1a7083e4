#pragma once
// What the figures of section VII share: a run's object and end effector from its samples.
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cli/report/path_plots.hpp"
#include "cli/reproduce/context.hpp"
#include "config/scenario.hpp"

namespace c3rt::cli::reproduce {

/// The scenario of a run, as it was run.
config::Scenario scenario_of(const RunSpec& spec);

/// The folder of the run's samples as tables, made from its recording when it is first asked for.
/// @throws std::runtime_error if the run has no recording
std::filesystem::path tables_of(const Run& run);

/// When the states were taken that C3 planned from, in phase roll or return; the first is the
/// begin of the task [ns].
/// @throws std::runtime_error if the run has no recording or never began its task
std::vector<double> c3_instants(const Run& run);

/// The true positions of an object from the begin of the task.
struct ObjectTrack {
  std::vector<double> time;               // since the begin of the task [s]
  std::vector<Eigen::Vector2d> position;  // x and y in W [m]
};
/// @throws as c3_instants
ObjectTrack object_track(const Run& run, int object = 0);

/// The end effector and where the plan wanted it, for each command that tracks one.
struct EndEffectorTrack {
  std::vector<double> time;               // since the begin of the task [s]
  std::vector<Eigen::Vector3d> position;  // in W [m]
  std::vector<Eigen::Vector3d> desired;
};
EndEffectorTrack end_effector_track(const Run& run);

/// A run's path beside that of its scenario, for a picture.
PathPlot path_plot(const std::string& title, const Run& run);

/// Of a report by path: figure(report, "judged.in_band_2cm"); NaN where it is not.
double figure(const ordered_json& report, const std::string& path);

/// "19.1, 19.6, 19.0"
std::string loop_times(const ordered_json& report);
/// kNone without a full circle [s].
double mean_loop_time(const ordered_json& report);

}  // namespace c3rt::cli::reproduce
