#pragma once
// Bodies are brought to goal poses, or from one to the next. Goals of different bodies that follow
// one another are due together, and a body's next goal comes after them. They are done when every
// body has stayed within the tolerances of its goal for a time, those of earlier goals as well, or
// given up when their time is over. Goals can be drawn from the seed of the run.
#include "controller/task/source.hpp"
#include "controller/task/task.hpp"

namespace c3rt::task {

struct PoseGoal {
  Eigen::Vector2d at;         // in W [m]
  std::optional<double> yaw;  // about z; none: however it is turned [rad]
  double position_tolerance;  // [m]
  double angle_tolerance;     // [rad]
  double hold;                // it has to stay this long [s]
  int body = 0;
  std::optional<AxisGoal> axis = std::nullopt;  // in the place of a yaw
  // those that are due together have the longest of their times, then they are missed [s]
  double time_limit = std::numeric_limits<double>::infinity();
};

/// Where goals are drawn, evenly.
struct Draw {
  Eigen::AlignedBox2d at;                   // in W [m]
  std::optional<Eigen::Vector2d> yaw = {};  // from the one to the other [rad]
};

struct Pose {
  static constexpr const char *kKind = "pose", *kUnit = "goals";
  static constexpr bool kRepeats = false;

  std::vector<PoseGoal> goals;    // at least one
  std::optional<Draw> draw = {};  // the goals' places and yaws are of seed 1, or of seeded()

  static Pose load(Source& source);
  /// The same with the goals that this seed draws, if it draws any.
  Pose seeded(std::uint64_t seed) const;

  double position_error(const PoseGoal& goal, const Placement& placed) const noexcept;  // [m]
  /// Between the body's orientation, or its axis, and the goal's; 0 of a goal without one [rad].
  double angle_error(const PoseGoal& goal, const Placement& placed) const noexcept;
  bool reached(const PoseGoal& goal, const Placement& placed) const noexcept;
  /// The goal of a body that the state is at, of those that are due or done; nullptr: none.
  const PoseGoal* due(const State& state, int body) const noexcept;
  bool done(const State& state) const noexcept;

  std::optional<Goal> goal(const State& state, int body) const noexcept;
  /// How many bodies a scene has to have.
  int bodies() const noexcept;
  /// By the truth. @param placed at least bodies() of them, else nothing happens
  void advance(double elapsed, const std::vector<Placement>& placed, State& state) const noexcept;
  /// By what is sensed, whose noise must not make a goal of several look done before it is: its
  /// tolerances are smaller by a part.
  void advance(double elapsed, const scene::Scene& scene, State& state) const noexcept;
  /// Bodies without a goal stay where they are.
  Eigen::Vector2d target(const scene::Scene& scene, int of, const State& state) const noexcept;
  Eigen::Vector2d velocity(double, double) const noexcept { return Eigen::Vector2d::Zero(); }
  /// Distance to the body's last goal; 0 of one without.
  double error(double, const Eigen::Vector2d& at, int body) const noexcept;
  Eigen::Vector2d middle() const;
  /// From goal to goal.
  std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d& tracks) const;
  /// Goals that are reached, judged from when the last one was first reached.
  std::unique_ptr<Progress> progress() const;
  std::optional<Along> along(const scene::Scene&, int) const noexcept { return std::nullopt; }
  std::optional<bool> arrived(const Eigen::Vector2d&) const noexcept { return std::nullopt; }
  std::vector<std::pair<std::string, Task>> readings() const { return {}; }
  static std::vector<std::string> criteria() {
    return {"goals_reached",      "goals_missed",        "goal_time_s",
            "goal_time_median_s", "goal_time_longest_s", "end_position_error_m",
            "end_angle_error_rad"};
  }
  std::string refusal(const Limits& limits) const;
  std::string describe() const;

 private:
  std::size_t end_of_due(const State& state) const noexcept;
  /// Whether there are goals that come after others.
  bool in_turn() const noexcept { return end_of_due(State{}) < goals.size(); }
  bool reached(const PoseGoal& goal, const Placement& placed, double part) const noexcept;
  template <typename PlacementOf>
  void advance_with(double elapsed, const PlacementOf& of, double part,
                    State& state) const noexcept;
};

}  // namespace c3rt::task
