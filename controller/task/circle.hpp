#pragma once
// Round a circle, state-based: always a lead ahead of where the body is [C3, eq. (25)].
#include <algorithm>
#include <cmath>

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
  /// Of a client's circle beyond what was shown to hold the ball.
  std::string refusal(const Limits& limits) const;
  std::string describe() const;

 private:
  static constexpr double kDegree = M_PI / 180.0;  // [rad]
};

namespace circle_detail {

/// Counts circles by the angle that the body has gone about the centre in the task's direction.
class CircleProgress final : public Progress {
 public:
  explicit CircleProgress(const Circle& circle) : circle_(circle) {}

  /// The first position starts the count.
  void add(double elapsed, const std::vector<Placement>& bodies) override {
    const Eigen::Vector2d arm = bodies.front().at - circle_.center;
    const double sign = circle_.lead > 0.0 ? 1.0 : -1.0;
    const double alpha = sign * std::atan2(arm.x(), arm.y());
    if (!started_) {
      started_ = true;
      last_alpha_ = alpha;
      last_time_ = loop_start_ = elapsed;
      return;
    }
    const double step = std::remainder(alpha - last_alpha_, 2.0 * M_PI);
    // the instant at which the angle passed a mark between the last position and this one
    const auto passed = [&](double mark) {
      return last_time_ + (elapsed - last_time_) * (mark - angle_) / step;
    };
    if (std::isnan(quarter_time_) && angle_ + step >= 0.5 * M_PI)
      quarter_time_ = passed(0.5 * M_PI);
    const double next_mark = 2.0 * M_PI * (completed() + 1);
    if (angle_ + step >= next_mark) {
      const double at = passed(next_mark);
      times_.push_back(at - loop_start_);
      loop_start_ = at;
    }
    angle_ += step;
    last_alpha_ = alpha;
    last_time_ = elapsed;
  }
  double amount() const override { return angle_ / (2.0 * M_PI); }
  int completed() const override { return static_cast<int>(times_.size()); }
  std::vector<double> times() const override { return times_; }
  double judged_from() const override { return quarter_time_; }

 private:
  Circle circle_;
  bool started_ = false;
  double angle_ = 0.0;       // since the start [rad]
  double last_alpha_ = 0.0;  // [rad]
  double last_time_ = 0.0;   // [s]
  double loop_start_ = 0.0;  // [s]
  double quarter_time_ = kNone;
  std::vector<double> times_;
};

}  // namespace circle_detail

inline Circle Circle::load(Source& source) {
  Circle circle{};
  circle.center = source.numbers("center_m", 2, -1, 1);
  circle.radius = source.number("radius_m", 0.01, 0.5);
  circle.lead = source.number("lead_rad", -3.14, 3.14);
  return circle;
}

inline Eigen::Vector2d Circle::next(const Eigen::Vector2d& body) const noexcept {
  const Eigen::Vector2d from_center = body - center;
  const double alpha = std::atan2(from_center.x(), from_center.y()) + lead;
  return center + radius * Eigen::Vector2d(std::sin(alpha), std::cos(alpha));
}

inline double Circle::error(double, const Eigen::Vector2d& body) const noexcept {
  return std::abs((body - center).norm() - radius);
}

inline std::vector<Eigen::Vector2d> Circle::outline(const Eigen::AlignedBox2d&) const {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 240; ++i) {
    const double angle = 2.0 * M_PI * i / 240.0;
    points.emplace_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  points.push_back(points.front());
  return points;
}

inline std::string Circle::describe() const {
  return words("circle about (%g, %g) m, radius %g m, lead %g deg", center.x(), center.y(), radius,
               lead / kDegree);
}

inline std::string Circle::refusal(const Limits& limits) const {
  constexpr double kMinRadius = 0.06, kMaxRadius = 0.15;                  // [m]
  constexpr double kMinLead = 10.0 * kDegree, kMaxLead = 30.0 * kDegree;  // either way [rad]
  // what is told as the limit is within it, whatever the rounding
  constexpr double kRounding = 1e-9;
  if (limits.bodies != 1)
    return words("expected a task for %d bodies, got a circle, which is for one", limits.bodies);
  if (!center.allFinite() || !std::isfinite(radius) || !std::isfinite(lead))
    return "expected finite numbers, got a " + describe();
  if (radius < kMinRadius - kRounding || radius > kMaxRadius + kRounding) {
    return words("expected a radius of %g to %g m, got %g m", kMinRadius, kMaxRadius, radius);
  }
  const double size = std::abs(lead);
  if (size < kMinLead - kRounding || size > kMaxLead + kRounding) {
    return words("expected a lead of %.0f to %.0f deg, or -%.0f to -%.0f deg, got %g deg",
                 kMinLead / kDegree, kMaxLead / kDegree, kMinLead / kDegree, kMaxLead / kDegree,
                 lead / kDegree);
  }
  const Eigen::Vector2d corner = Eigen::Vector2d::Constant(radius);
  if (!limits.holds(center - corner) || !limits.holds(center + corner)) {
    return words("expected a centre with %s for a circle of radius %g m, got (%g, %g)",
                 limits.words(radius).c_str(), radius, center.x(), center.y());
  }
  return {};
}

inline std::unique_ptr<Progress> Circle::progress() const {
  return std::make_unique<circle_detail::CircleProgress>(*this);
}

}  // namespace c3rt::task
