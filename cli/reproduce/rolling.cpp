#include "cli/reproduce/rolling.hpp"

#include <limits>
#include <map>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "cli/report/course.hpp"
#include "config/scenario.hpp"
#include "idl/topics.hpp"

namespace c3rt::cli::reproduce {
namespace {

double seconds(double nanoseconds) { return 1e-9 * nanoseconds; }

/// [ns]
double task_start(const campaign::RunResult& run) {
  const auto plans = campaign::read_columns(run.folder / "log" / "plan.csv", {"phase", "state_ns"});
  for (const auto& plan : plans) {
    const int phase = static_cast<int>(plan[0]);
    if (phase == c3rt_v1_PHASE_ROLL || phase == c3rt_v1_PHASE_RETURN) return plan[1];
  }
  throw std::runtime_error(run.folder.string() + ": the run never began its task");
}

}  // namespace

BallTrack ball_track(const campaign::RunResult& run, int ball) {
  const double start = task_start(run);
  const auto rows = campaign::read_columns(
      run.folder / "log" / "sim_scene.csv",
      {"time_ns", fmt::format("p_WB_m_{}_0", ball), fmt::format("p_WB_m_{}_1", ball)});
  BallTrack track;
  for (const auto& row : rows) {
    if (row[0] < start) continue;
    track.time.push_back(seconds(row[0] - start));
    track.position.emplace_back(row[1], row[2]);
  }
  return track;
}

EndEffectorTrack end_effector_track(const campaign::RunResult& run) {
  const double start = task_start(run);
  std::map<double, Eigen::Vector3d> states;  // by time [ns]
  for (const auto& row : campaign::read_columns(run.folder / "log" / "robot_state.csv",
                                                {"time_ns", "p_WE_m_0", "p_WE_m_1", "p_WE_m_2"}))
    states.emplace(row[0], Eigen::Vector3d(row[1], row[2], row[3]));
  EndEffectorTrack track;
  for (const auto& row : campaign::read_columns(
           run.folder / "log" / "robot_command.csv",
           {"state_ns", "mode", "p_WE_desired_m_0", "p_WE_desired_m_1", "p_WE_desired_m_2"})) {
    const auto state = states.find(row[0]);
    if (static_cast<int>(row[1]) != c3rt_v1_IMPEDANCE_TRACK || state == states.end() ||
        row[0] < start)
      continue;
    track.time.push_back(seconds(row[0] - start));
    track.position.push_back(state->second);
    track.desired.emplace_back(row[2], row[3], row[4]);
  }
  return track;
}

PathPlot path_plot(const std::string& title, const campaign::RunResult& run) {
  const config::Scenario scenario =
      config::load_scenario(scenario_path(run.spec.scenario).string(), run.spec.overrides);
  const BallTrack track = ball_track(run);
  const double y_start = track.position.empty() ? 0.0 : track.position.front().y();
  return {title, outline(scenario.task.motion, y_start), track.position};
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

}  // namespace c3rt::cli::reproduce
