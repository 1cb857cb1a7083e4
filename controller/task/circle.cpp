#include "controller/task/circle.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::task {
namespace {

constexpr double kDegree = M_PI / 180.0;  // [rad]
// of a client's circle, what was shown to hold the ball
constexpr double kMinRadius = 0.06, kMaxRadius = 0.15;                  // [m]
constexpr double kMinLead = 10.0 * kDegree, kMaxLead = 30.0 * kDegree;  // either way [rad]
// what is told as the limit is within it, whatever the rounding
constexpr double kRounding = 1e-9;

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

}  // namespace

Circle Circle::load(Source& source) {
  Circle circle{};
  circle.center = source.numbers("center_m", 2, -1, 1);
  circle.radius = source.number("radius_m", 0.01, 0.5);
  circle.lead = source.number("lead_rad", -3.14, 3.14);
  return circle;
}

Eigen::Vector2d Circle::next(const Eigen::Vector2d& body) const noexcept {
  const Eigen::Vector2d from_center = body - center;
  const double alpha = std::atan2(from_center.x(), from_center.y()) + lead;
  return center + radius * Eigen::Vector2d(std::sin(alpha), std::cos(alpha));
}

double Circle::error(double, const Eigen::Vector2d& body) const noexcept {
  return std::abs((body - center).norm() - radius);
}

std::vector<Eigen::Vector2d> Circle::outline(const Eigen::AlignedBox2d&) const {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 240; ++i) {
    const double angle = 2.0 * M_PI * i / 240.0;
    points.push_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  points.push_back(points.front());
  return points;
}

std::string Circle::describe() const {
  return words("circle about (%g, %g) m, radius %g m, lead %g deg", center.x(), center.y(), radius,
               lead / kDegree);
}

std::string Circle::refusal(const Limits& limits) const {
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

std::unique_ptr<Progress> Circle::progress() const {
  return std::make_unique<CircleProgress>(*this);
}

}  // namespace c3rt::task
