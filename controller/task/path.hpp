#pragma once
// Along way-points in time, x_d^b = x_d^b(t): one an interval, over and over. Its clock starts when
// C3 takes over from the approach [C3, section VII-D].
#include "controller/task/source.hpp"
#include "controller/task/task.hpp"

namespace c3rt::task {

enum class Between {
  kHold,         // x_d^b jumps from way-point to way-point (zero-order hold)
  kInterpolate,  // and moves between them at constant speed
};

struct Path {
  static constexpr const char *kKind = "path", *kUnit = "rounds";
  static constexpr bool kRepeats = true;

  std::vector<Eigen::Vector2d> points;  // in W, at least two [m]
  double interval;                      // between way-points [s]
  Between between;
  double lead;   // the planner aims at where the body should be this much later [s]
  bool preview;  // stage k of the horizon has x_d^b(t + lead + k Δt) and its velocity, not x_d^b(t
                 // + lead) at rest

  static Path load(Source& source);

  /// x_d^b(t), in W [m]. @param elapsed t since the task began [s]; before it, the first way-point
  Eigen::Vector2d point(double elapsed) const noexcept;
  /// How long one round of all way-points takes [s].
  double round_duration() const noexcept { return interval * static_cast<double>(points.size()); }

  Eigen::Vector2d target(const scene::Scene&, int, double elapsed, double ahead) const noexcept {
    return point(elapsed + lead + (preview ? ahead : 0.0));
  }
  Eigen::Vector2d velocity(double elapsed, double ahead) const noexcept;
  double error(double elapsed, const Eigen::Vector2d& body) const noexcept {
    return (body - point(elapsed)).norm();
  }
  Eigen::Vector2d middle() const;
  std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d&) const;
  /// Rounds by the clock, judged from the first second on, which the body needs to catch up.
  std::unique_ptr<Progress> progress() const;
  std::optional<Along> along(const scene::Scene&, int) const noexcept { return std::nullopt; }
  std::optional<bool> arrived(const Eigen::Vector2d&) const noexcept { return std::nullopt; }
  /// "to_held_points" and "to_interpolated_path".
  std::vector<std::pair<std::string, Task>> readings() const;
  static std::vector<std::string> criteria() { return {"loops_completed", "max_loop_time_s"}; }
  std::string refusal(const Limits& limits) const;
  std::string describe() const;
};

}  // namespace c3rt::task
