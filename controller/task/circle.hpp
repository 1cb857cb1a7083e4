#pragma once
// Round a circle, state-based: always a lead ahead of where the body is [C3, eq. (25)].
#include "controller/task/source.hpp"
#include "controller/task/task.hpp"

namespace c3rt::task {

struct Circle {
  static constexpr const char *kKind = "circle", *kUnit = "circles";
  static constexpr bool kRepeats = true;

  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // in W [m]
  double radius = 0.0;                               // [m]
  double lead = 0.0;  // α^l of (25); positive is clockwise seen from above [rad]

  static Circle load(Source& source);

  /// The next desired position of a body at this place:
  ///
  ///   α = atan2(x − x_c, y − y_c),  x_d = x_c + r sin(α + α^l),  y_d = y_c + r cos(α + α^l)
  ///
  /// Source: [C3, eq. (25)].
  Eigen::Vector2d next(const Eigen::Vector2d& body) const noexcept;

  Eigen::Vector2d target(const scene::Scene& scene, int body, double, double) const noexcept {
    return next(scene.body(body).p_WB.head<2>());
  }
  Eigen::Vector2d velocity(double, double) const noexcept { return Eigen::Vector2d::Zero(); }
  double error(double, const Eigen::Vector2d& body) const noexcept;
  Eigen::Vector2d middle() const { return center; }
  std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d&) const;
  /// Circles of the first body, judged from its first quarter circle on; going back does not undo
  /// one.
  std::unique_ptr<Progress> progress() const;
  std::optional<Along> along(const scene::Scene&, int) const noexcept { return std::nullopt; }
  std::optional<bool> arrived(const Eigen::Vector2d&) const noexcept { return std::nullopt; }
  std::vector<std::pair<std::string, Task>> readings() const { return {}; }
  static std::vector<std::string> criteria() { return {"loops_completed", "max_loop_time_s"}; }
  std::string refusal(const Limits& limits) const;
  std::string describe() const;
};

}  // namespace c3rt::task
