// Figure 14: how well the end effector follows C3, in the experiment with vision.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cli/reproduce/rolling.hpp"

namespace c3rt::cli::reproduce {
namespace {

constexpr double kPaperLimit = 0.003;         // "consistently lower than" [m]
constexpr double kFrom = 1.0, kUntil = 21.0;  // what is drawn, since the begin of the task [s]
constexpr const char* kAxes[] = {"x", "y", "z"};
constexpr const char* kAxisColors[] = {"#d04020", "#1b7837", "#1f5fd0"};

}  // namespace

void fig14(const Context& context) {
  RunSpec spec{"vision", "circle_vision"};
  spec.logs = true;
  const Run run = context.runs({spec}).front();
  const EndEffectorTrack track = end_effector_track(run);

  std::vector<double> errors;
  std::vector<std::size_t> drawn;
  std::size_t below = 0;
  for (std::size_t i = 0; i < track.time.size(); ++i) {
    if (track.time[i] < kFrom) continue;
    errors.push_back((track.position[i] - track.desired[i]).norm());
    below += errors.back() < kPaperLimit ? 1 : 0;
    if (track.time[i] <= kUntil) drawn.push_back(i);
  }
  const double share = static_cast<double>(below) / static_cast<double>(errors.size());
  const Spread measured = spread(errors);

  const auto count = static_cast<Eigen::Index>(drawn.size());
  Eigen::VectorXd times(count), error(count);
  Eigen::MatrixX3d desired(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t i = drawn[static_cast<std::size_t>(k)];
    times[k] = track.time[i];
    error[k] = 1e3 * (track.position[i] - track.desired[i]).norm();
    desired.row(k) = track.desired[i].transpose();
  }
  Panel upper{"", "", "end effector to x_d [mm]", {}}, lower{"", "time [s]", "x_d of C3 [m]", {}};
  upper.curves.push_back({"|error|", "#1f5fd0", times, error});
  upper.curves.push_back({"3 mm: the paper's bound", "#d04020", times,
                          Eigen::VectorXd::Constant(count, 1e3 * kPaperLimit), true});
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    lower.curves.push_back({kAxes[axis], kAxisColors[axis], times, desired.col(axis)});
  }
  fmt::print(
      "Figure 14: the end effector's tracking error in circle_vision, lockstep, seed 1, from "
      "{:g} s after the begin of the task; the paper: hardware\n\n",
      kFrom);
  print_table({{"", "here", "paper"},
               {"error, p50 [mm]", shown(1e3 * measured.p50), "-"},
               {"error, p95 [mm]", shown(1e3 * measured.p95), "-"},
               {"error, p99 [mm]", shown(1e3 * measured.p99), "-"},
               {"error, largest [mm]", shown(1e3 * measured.max), "< 3"},
               {"below 3 mm [% of the time]", shown(100.0 * share), "100"}});
  const ordered_json results{{"what", "fig14"},
                             {"command", run.command},
                             {"paper", {{"bound_m", kPaperLimit}}},
                             {"tracking_error_m", quantiles(measured)},
                             {"share_below_3mm", share},
                             {"report", run.report}};
  context.finish(results, "Figure 14: end effector tracking error and desired locations",
                 {upper, lower});
}

}  // namespace c3rt::cli::reproduce
