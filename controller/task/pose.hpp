#pragma once
// A body is brought to a goal pose, or from one to the next: each is done when the body has stayed
// within its tolerances for a time.
#include "controller/task/source.hpp"
#include "controller/task/task.hpp"

namespace c3rt::task {

struct PoseGoal {
  Eigen::Vector2d at;         // in W [m]
  std::optional<double> yaw;  // about z; none: however it is turned [rad]
  double position_tolerance;  // [m]
  double angle_tolerance;     // [rad]
  double hold;                // it has to stay this long [s]
};

struct Pose {
  static constexpr const char *kKind = "pose", *kUnit = "goals";
  static constexpr bool kRepeats = false;

  int body = 0;
  std::vector<PoseGoal> goals;  // at least one

  static Pose load(Source& source);

  double position_error(const PoseGoal& goal, const Placement& placed) const noexcept;  // [m]
  /// Between the body's orientation and the goal's; 0 of a goal without one [rad].
  double angle_error(const PoseGoal& goal, const Placement& placed) const noexcept;
  bool reached(const PoseGoal& goal, const Placement& placed) const noexcept;
  /// The goal that the state is at; the last one when all are done.
  const PoseGoal& due(const State& state) const noexcept;
  bool done(const State& state) const noexcept;

  std::optional<Goal> goal(const State& state) const noexcept;
  void advance(double elapsed, const Placement& placed, State& state) const noexcept;
  void advance(double elapsed, const scene::Scene& scene, State& state) const noexcept;
  /// Other bodies stay where they are.
  Eigen::Vector2d target(const scene::Scene& scene, int of, const State& state) const noexcept;
  Eigen::Vector2d velocity(double, double) const noexcept { return Eigen::Vector2d::Zero(); }
  /// Distance to the last goal.
  double error(double, const Eigen::Vector2d& at) const noexcept;
  Eigen::Vector2d middle() const;
  /// From goal to goal.
  std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d& tracks) const;
  /// Goals that are done, judged from when the last one was first reached.
  std::unique_ptr<Progress> progress() const;
  std::optional<Along> along(const scene::Scene&, int) const noexcept { return std::nullopt; }
  std::optional<bool> arrived(const Eigen::Vector2d&) const noexcept { return std::nullopt; }
  std::vector<std::pair<std::string, Task>> readings() const { return {}; }
  static std::vector<std::string> criteria() {
    return {"goals_reached", "goal_time_s", "end_position_error_m", "end_angle_error_rad"};
  }
  std::string refusal(const Limits& limits) const;
  std::string describe() const;
};

}  // namespace c3rt::task
