#include "controller/task/line.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::task {
namespace {

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

}  // namespace

Line Line::load(Source& source) {
  Line line{};
  line.x = source.number("x_m", -1, 1);
  line.step = source.number("step_m", -0.2, 0.2);
  if (line.step == 0.0) source.fail("step_m", "a step that is not 0", "0");
  line.y_end = source.number("y_end_m", -1, 1);
  line.spacing = source.number("spacing_m", 0, 0.5);
  return line;
}

double Line::way_to_go(const Eigen::Vector2d& body, int behind) const noexcept {
  // a step past the end, so that it is passed and not approached
  return forward() * (y_end + step - body.y()) + behind * spacing;
}

Eigen::Vector2d Line::next(const Eigen::Vector2d& body, int behind) const noexcept {
  const double pace = std::abs(step);
  const auto paced = [pace](double way) { return std::min(std::max(way, -pace), pace); };
  return body + Eigen::Vector2d(paced(x - body.x()), forward() * paced(way_to_go(body, behind)));
}

int Line::behind(const scene::Scene& scene, int body) const noexcept {
  const auto place = [&](int i) { return forward() * scene.body(i).p_WB.y(); };
  int count = 0;
  for (int i = 0; i < scene.body_count; ++i) count += place(i) < place(body) ? 1 : 0;
  return count;
}

double Line::error(double, const Eigen::Vector2d& body) const noexcept {
  return std::abs(body.x() - x);
}

std::vector<Eigen::Vector2d> Line::outline(const Eigen::AlignedBox2d& tracks) const {
  const double start = tracks.isEmpty() ? 0.0 : step < 0.0 ? tracks.max().y() : tracks.min().y();
  return {{x, start}, {x, y_end}};
}

std::string Line::describe() const {
  return words("line x = %g m to y = %g m, %g m a step, places %g m apart", x, y_end, step,
               spacing);
}

std::string Line::refusal(const Limits& limits) const {
  const double farthest = y_end + step + forward() * (limits.bodies - 1) * spacing;
  if (limits.holds({x, y_end}) && limits.holds({x, farthest})) return {};
  return words("expected a line and places past its end with %s, got x = %g m, y to %g m",
               limits.words().c_str(), x, farthest);
}

std::unique_ptr<Progress> Line::progress() const { return std::make_unique<LineProgress>(*this); }

std::optional<Along> Line::along(const scene::Scene& scene, int body) const noexcept {
  const Eigen::Vector2d at = scene.body(body).p_WB.head<2>();
  return Along{way_to_go(at, behind(scene, body)), std::abs(at.x() - x), forward() * at.y()};
}

}  // namespace c3rt::task
