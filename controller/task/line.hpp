#pragma once
// Several bodies along one line of constant x, state-based, a pace at a time, each to a place of
// its own past the end: the last body just past it, each one ahead of it farther by the spacing
// [C3, section VII-B, where the balls have no place to stop].
#include <algorithm>
#include <cmath>

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

namespace line_detail {

class LineProgress final : public Progress {
 public:
  explicit LineProgress(const Line& line) : line_(line) {}
  void add(double elapsed, const std::vector<Placement>& bodies) override {
    arrived_ = std::count_if(bodies.begin(), bodies.end(),
                             [&](const Placement& body) { return line_.past_end(body.at.y()); });
    if (arrived_ == static_cast<std::ptrdiff_t>(bodies.size()) && std::isnan(all_arrived_))
      all_arrived_ = elapsed;
  }
  double amount() const override { return static_cast<double>(arrived_); }
  int completed() const override { return std::isnan(all_arrived_) ? 0 : 1; }
  std::vector<double> times() const override {
    return completed() == 0 ? std::vector<double>{} : std::vector<double>{all_arrived_};
  }
  double judged_from() const override { return 0.0; }
  std::vector<std::pair<std::string, double>> results() const override {
    return {{"balls_arrived", amount()}};
  }

 private:
  Line line_;
  std::ptrdiff_t arrived_ = 0;
  double all_arrived_ = kNone;
};

}  // namespace line_detail

inline Line Line::load(Source& source) {
  Line line{};
  line.x = source.number("x_m", -1, 1);
  line.step = source.number("step_m", -0.2, 0.2);
  if (line.step == 0.0) source.fail("step_m", "a step that is not 0", "0");
  line.y_end = source.number("y_end_m", -1, 1);
  line.spacing = source.number("spacing_m", 0, 0.5);
  return line;
}

inline double Line::way_to_go(const Eigen::Vector2d& body, int behind) const noexcept {
  // a step past the end, so that it is passed and not approached
  return forward() * (y_end + step - body.y()) + behind * spacing;
}

inline Eigen::Vector2d Line::next(const Eigen::Vector2d& body, int behind) const noexcept {
  const double pace = std::abs(step);
  const auto paced = [pace](double way) { return std::min(std::max(way, -pace), pace); };
  return body + Eigen::Vector2d(paced(x - body.x()), forward() * paced(way_to_go(body, behind)));
}

inline int Line::behind(const scene::Scene& scene, int body) const noexcept {
  const auto place = [&](int i) { return forward() * scene.body(i).p_WB.y(); };
  int count = 0;
  for (int i = 0; i < scene.body_count; ++i) count += place(i) < place(body) ? 1 : 0;
  return count;
}

inline double Line::error(double, const Eigen::Vector2d& body) const noexcept {
  return std::abs(body.x() - x);
}

inline std::vector<Eigen::Vector2d> Line::outline(const Eigen::AlignedBox2d& tracks) const {
  const double start = tracks.isEmpty() ? 0.0 : step < 0.0 ? tracks.max().y() : tracks.min().y();
  return {{x, start}, {x, y_end}};
}

inline std::string Line::describe() const {
  return words("line x = %g m to y = %g m, %g m a step, places %g m apart", x, y_end, step,
               spacing);
}

inline std::string Line::refusal(const Limits& limits) const {
  const double farthest = y_end + step + forward() * (limits.bodies - 1) * spacing;
  if (limits.holds({x, y_end}) && limits.holds({x, farthest})) return {};
  return words("expected a line and places past its end with %s, got x = %g m, y to %g m",
               limits.words().c_str(), x, farthest);
}

inline std::unique_ptr<Progress> Line::progress() const {
  return std::make_unique<line_detail::LineProgress>(*this);
}

inline std::optional<Along> Line::along(const scene::Scene& scene, int body) const noexcept {
  const Eigen::Vector2d at = scene.body(body).p_WB.head<2>();
  return Along{way_to_go(at, behind(scene, body)), std::abs(at.x() - x), forward() * at.y()};
}

}  // namespace c3rt::task
