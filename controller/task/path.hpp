#pragma once
// Along way-points in time, x_d^b = x_d^b(t): one an interval, over and over. Its clock starts when
// C3 takes over from the approach [C3, section VII-D].
#include <algorithm>
#include <cmath>

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

namespace path_detail {

/// Between which two way-points the path is, and how far from the first to the second.
struct Place {
  std::size_t from, to;
  double share;
};

inline Place place_at(const Path& path, double elapsed) noexcept {
  const double place = std::fmod(std::max(elapsed, 0.0), path.round_duration()) / path.interval;
  const std::size_t count = path.points.size();
  const std::size_t from = std::min(static_cast<std::size_t>(place), count - 1);
  return {from, (from + 1) % count, place - static_cast<double>(from)};
}

class PathProgress final : public Progress {
 public:
  explicit PathProgress(double round_duration) : round_duration_(round_duration) {}
  void add(double elapsed, const std::vector<Placement>&) override { elapsed_ = elapsed; }
  double amount() const override { return elapsed_ / round_duration_; }
  int completed() const override { return static_cast<int>(amount()); }
  std::vector<double> times() const override { return {}; }
  double judged_from() const override { return kFirstSecond; }

 private:
  static constexpr double kFirstSecond = 1.0;  // [s]

  double round_duration_;
  double elapsed_ = 0.0;
};

}  // namespace path_detail

inline Path Path::load(Source& source) {
  Path path{};
  const Eigen::MatrixXd points = source.rows("points_m", 2, 1000, 2, -1, 1);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    path.points.emplace_back(points.row(i).transpose());
  path.interval = source.number("interval_s", 0.01, 100);
  path.between = source.choice("between", {"hold", "interpolate"}) == 0 ? Between::kHold
                                                                        : Between::kInterpolate;
  path.lead = source.number("lead_s", 0, 10);
  path.preview = source.boolean("preview");
  return path;
}

inline Eigen::Vector2d Path::point(double elapsed) const noexcept {
  const path_detail::Place place = path_detail::place_at(*this, elapsed);
  if (between == Between::kHold) return points[place.from];
  return (1.0 - place.share) * points[place.from] + place.share * points[place.to];
}

inline Eigen::Vector2d Path::velocity(double elapsed, double ahead) const noexcept {
  if (!preview || between == Between::kHold) return Eigen::Vector2d::Zero();
  const path_detail::Place place = path_detail::place_at(*this, elapsed + lead + ahead);
  return (points[place.to] - points[place.from]) / interval;
}

inline Eigen::Vector2d Path::middle() const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

inline std::vector<Eigen::Vector2d> Path::outline(const Eigen::AlignedBox2d&) const {
  std::vector<Eigen::Vector2d> closed = points;
  closed.push_back(points.front());
  return closed;
}

inline std::string Path::describe() const {
  return words("path of %zu points about (%g, %g) m, %g s from one to the next%s", points.size(),
               middle().x(), middle().y(), interval, between == Between::kHold ? ", held" : "");
}

inline std::string Path::refusal(const Limits& limits) const {
  constexpr double kFastest = 0.3;  // from point to point [m/s]
  if (limits.bodies != 1)
    return words("expected a task for %d bodies, got a path, which is for one", limits.bodies);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d& from = points[i];
    if (!limits.holds(from)) {
      return words("expected points with %s, got (%g, %g)", limits.words().c_str(), from.x(),
                   from.y());
    }
    const double speed = (points[(i + 1) % points.size()] - from).norm() / interval;
    if (!(speed <= kFastest)) {
      return words("expected at most %g m/s from point to point, got %g m/s after point %zu",
                   kFastest, speed, i + 1);
    }
  }
  return {};
}

inline std::unique_ptr<Progress> Path::progress() const {
  return std::make_unique<path_detail::PathProgress>(round_duration());
}

inline std::vector<std::pair<std::string, Task>> Path::readings() const {
  Path held = *this, interpolated = *this;
  held.between = Between::kHold;
  interpolated.between = Between::kInterpolate;
  return {{"to_held_points", held}, {"to_interpolated_path", interpolated}};
}

}  // namespace c3rt::task
