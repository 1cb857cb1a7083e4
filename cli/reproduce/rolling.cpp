#include "cli/reproduce/rolling.hpp"

#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "cli/recording/export.hpp"
#include "cli/report/course.hpp"
#include "idl/text.hpp"

namespace c3rt::cli::reproduce {
namespace {

double seconds(double nanoseconds) { return 1e-9 * nanoseconds; }

}  // namespace

config::Scenario scenario_of(const RunSpec& spec) {
  return config::load_scenario(scenario_path(spec.scenario).string(), spec.overrides);
}

std::filesystem::path tables_of(const Run& run) {
  std::filesystem::path folder = run.folder / "tables";
  if (!std::filesystem::is_directory(folder)) {
    // whole or not at all: what is left of an interrupted one is begun again
    const std::filesystem::path part = run.folder / "tables.part";
    std::filesystem::remove_all(part);
    std::filesystem::create_directory(part);
    (void)write_csv(run.folder / kRecordingName, {}, part);
    std::filesystem::rename(part, folder);
  }
  return folder;
}

std::vector<double> c3_instants(const Run& run) {
  std::vector<double> instants;
  for (const auto& plan : read_cells(tables_of(run) / "plan.csv", {"phase", "state_ns"})) {
    if (wire::is_at_task(plan[0])) instants.push_back(std::strtod(plan[1].c_str(), nullptr));
  }
  if (instants.empty())
    throw std::runtime_error(run.folder.string() + ": the run never began its task");
  return instants;
}

ObjectTrack object_track(const Run& run, int object) {
  const double start = c3_instants(run).front();
  const auto rows = read_columns(tables_of(run) / "sim_scene.csv",
                                 {"time_ns", fmt::format("objects_{}_p_WB_m_0", object),
                                  fmt::format("objects_{}_p_WB_m_1", object)});
  ObjectTrack track;
  for (const auto& row : rows) {
    if (row[0] < start) continue;
    track.time.push_back(seconds(row[0] - start));
    track.position.emplace_back(row[1], row[2]);
  }
  return track;
}

EndEffectorTrack end_effector_track(const Run& run) {
  const double start = c3_instants(run).front();
  std::map<double, Eigen::Vector3d> states;  // by time [ns]
  for (const auto& row : read_columns(tables_of(run) / "robot_state.csv",
                                      {"time_ns", "p_WE_m_0", "p_WE_m_1", "p_WE_m_2"}))
    states.emplace(row[0], Eigen::Vector3d(row[1], row[2], row[3]));
  EndEffectorTrack track;
  for (const auto& row : read_columns(
           tables_of(run) / "robot_command.csv",
           {"state_ns", "mode", "p_WE_desired_m_0", "p_WE_desired_m_1", "p_WE_desired_m_2"})) {
    const auto state = states.find(row[0]);
    if (static_cast<int>(row[1]) != c3rt_v2_IMPEDANCE_TRACK || state == states.end() ||
        row[0] < start)
      continue;
    track.time.push_back(seconds(row[0] - start));
    track.position.push_back(state->second);
    track.desired.emplace_back(row[2], row[3], row[4]);
  }
  return track;
}

PathPlot path_plot(const std::string& title, const Run& run) {
  const config::Scenario scenario = scenario_of(run.spec);
  const ObjectTrack track = object_track(run);
  Eigen::AlignedBox2d start;
  if (!track.position.empty()) start.extend(track.position.front());
  return {title, scenario.task.motion.outline(start), track.position};
}

double figure(const ordered_json& report, const std::string& path) {
  const ordered_json* place = &report;
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    const std::string name = path.substr(from, dot - from);
    if (place->is_array() && std::stoul(name) < place->size()) {
      place = &place->at(std::stoul(name));
    } else if (place->is_object() && place->contains(name)) {
      place = &place->at(name);
    } else {
      return kNone;
    }
    from = dot + 1;
  }
  return place->is_number() ? place->get<double>() : kNone;
}

std::string loop_times(const ordered_json& report) {
  std::string text;
  for (const ordered_json& time : report.at("loop_times_s"))
    text += fmt::format("{}{:.1f}", text.empty() ? "" : ", ", time.get<double>());
  return text.empty() ? "-" : text;
}

double mean_loop_time(const ordered_json& report) {
  const std::vector<double> times = report.at("loop_times_s");
  if (times.empty()) return kNone;
  return std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
}

}  // namespace c3rt::cli::reproduce
