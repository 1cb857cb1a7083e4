#pragma once
// Several bodies along one line of constant x, state-based, a pace at a time, each to a place of
// its own past the end: the last body just past it, each one ahead of it farther by the spacing
// [C3, section VII-B, where the balls have no place to stop].
#include "controller/task/source.hpp"
#include "controller/task/task.hpp"

namespace c3rt::task {

struct Line {
  static constexpr const char *kKind = "line", *kUnit = "balls";
  static constexpr bool kRepeats = false;

  double x;        // of the line, in W [m]
  double step;     // of y from where the body is; its sign is the line's direction [m]
  double y_end;    // where a body has arrived [m]
  double spacing;  // of the places where the bodies come to rest, positive [m]

  static Line load(Source& source);

  /// Along y: 1 or −1.
  double forward() const noexcept { return step < 0.0 ? -1.0 : 1.0; }
  bool past_end(double y) const noexcept { return forward() * y >= forward() * y_end; }
  /// How far the body has to go along the line, negative if it is past its place [m].
  /// @param behind how many bodies are behind it
  double way_to_go(const Eigen::Vector2d& body, int behind) const noexcept;
  /// x_d^b of the body: no farther than a pace away, along the line and towards it.
  Eigen::Vector2d next(const Eigen::Vector2d& body, int behind) const noexcept;
  int behind(const scene::Scene& scene, int body) const noexcept;

  Eigen::Vector2d target(const scene::Scene& scene, int body, double, double) const noexcept {
    return next(scene.body(body).p_WB.head<2>(), behind(scene, body));
  }
  Eigen::Vector2d velocity(double, double) const noexcept { return Eigen::Vector2d::Zero(); }
  double error(double, const Eigen::Vector2d& body) const noexcept;
  Eigen::Vector2d middle() const { return {x, 0.0}; }
  /// From where the farthest body began to the end.
  std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d& tracks) const;
  /// Bodies that have arrived; completed when all are there at once.
  std::unique_ptr<Progress> progress() const;
  std::optional<Along> along(const scene::Scene& scene, int body) const noexcept;
  std::optional<bool> arrived(const Eigen::Vector2d& body) const noexcept {
    return past_end(body.y());
  }
  std::vector<std::pair<std::string, Task>> readings() const { return {}; }
  static std::vector<std::string> criteria() {
    return {"loops_completed", "max_loop_time_s", "balls_arrived", "arrival_error_max_m",
            "end_error_max_m"};
  }
  std::string refusal(const Limits& limits) const;
  std::string describe() const;
};

}  // namespace c3rt::task
