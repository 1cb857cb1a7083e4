#include "cli/report/course.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::cli {
namespace {

constexpr double kFirstSecond = 1.0;  // of a path, which the ball needs to catch up [s]

double wrap(double angle) { return std::remainder(angle, 2.0 * M_PI); }

planner::CircleTask circle_of(const planner::Task& task) {
  const auto* circle = std::get_if<planner::CircleTask>(&task);
  return circle != nullptr ? *circle : planner::CircleTask{};
}

}  // namespace

void LoopCounter::add(double time, const Eigen::Vector2d& p_WB) {
  const Eigen::Vector2d arm = p_WB - circle_.center;
  const double sign = circle_.lead > 0.0 ? 1.0 : -1.0;
  const double alpha = sign * std::atan2(arm.x(), arm.y());
  if (!started_) {
    started_ = true;
    last_alpha_ = alpha;
    last_time_ = loop_start_ = time;
    return;
  }
  const double step = wrap(alpha - last_alpha_);
  // the instant at which the angle passed a mark between the last position and this one
  const auto passed = [&](double mark) {
    return last_time_ + (time - last_time_) * (mark - angle_) / step;
  };
  if (std::isnan(quarter_time_) && angle_ + step >= 0.5 * M_PI) quarter_time_ = passed(0.5 * M_PI);
  const double next_mark = 2.0 * M_PI * (completed() + 1);
  if (angle_ + step >= next_mark) {
    const double at = passed(next_mark);
    times_.push_back(at - loop_start_);
    loop_start_ = at;
  }
  angle_ += step;
  last_alpha_ = alpha;
  last_time_ = time;
}

Course::Course(const planner::Task& task) : task_(task), loops_(circle_of(task)) {}

void Course::add(double elapsed, const SceneRow& row) {
  if (row.ball_count == 0) return;
  elapsed_ = elapsed;
  if (std::holds_alternative<planner::CircleTask>(task_))
    loops_.add(elapsed, row.p_WB[0].head<2>());
  if (const auto* line = std::get_if<planner::LineTask>(&task_)) {
    arrived_ = static_cast<int>(std::count_if(
        row.p_WB.begin(), row.p_WB.begin() + row.ball_count,
        [&](const Eigen::Vector3d& p_WB) { return planner::past_end(*line, p_WB.y()); }));
    if (arrived_ == row.ball_count && std::isnan(all_arrived_)) all_arrived_ = elapsed;
  }
}

double Course::amount() const {
  if (const auto* path = std::get_if<planner::PathTask>(&task_))
    return elapsed_ / planner::round_duration(*path);
  return std::holds_alternative<planner::LineTask>(task_) ? arrived_ : loops_.turns();
}

int Course::completed() const {
  if (std::holds_alternative<planner::PathTask>(task_)) return static_cast<int>(amount());
  if (std::holds_alternative<planner::LineTask>(task_)) return std::isnan(all_arrived_) ? 0 : 1;
  return loops_.completed();
}

std::vector<double> Course::times() const {
  if (!std::isnan(all_arrived_)) return {all_arrived_};
  return loops_.times();
}

double Course::judged_from() const {
  if (std::holds_alternative<planner::PathTask>(task_)) return kFirstSecond;
  return std::holds_alternative<planner::LineTask>(task_) ? 0.0 : loops_.quarter_time();
}

std::string unit(const planner::Task& task) {
  if (std::holds_alternative<planner::PathTask>(task)) return "rounds";
  return std::holds_alternative<planner::LineTask>(task) ? "balls" : "circles";
}

double worst_error(const planner::Task& task, double elapsed, const SceneRow& row) {
  double worst = kNone;
  for (int ball = 0; ball < row.ball_count; ++ball) {
    const Eigen::Vector3d& p_WB = row.p_WB[static_cast<std::size_t>(ball)];
    worst = std::fmax(worst, planner::path_error(task, elapsed, p_WB.head<2>()));
  }
  return worst;
}

std::optional<std::int64_t> task_start_ns(const Series& series) {
  const auto first = std::find_if(series.plan.begin(), series.plan.end(),
                                  [](const PlanRow& plan) { return plan.rolling; });
  if (first == series.plan.end()) return std::nullopt;
  return first->state_ns;
}

PathErrors path_errors(const Series& series, const planner::Task& task, int ball) {
  PathErrors errors;
  const auto start = task_start_ns(series);
  if (!start) return errors;
  for (const SceneRow& row : series.scene) {
    if (row.time_ns < *start || ball >= row.ball_count) continue;
    const double elapsed = static_cast<double>(row.time_ns - *start) * 1e-9;
    const Eigen::Vector3d& p_WB = row.p_WB[static_cast<std::size_t>(ball)];
    errors.time.push_back(elapsed);
    errors.error.push_back(planner::path_error(task, elapsed, p_WB.head<2>()));
  }
  return errors;
}

std::vector<Eigen::Vector2d> outline(const planner::Task& task, double y_start) {
  if (const auto* line = std::get_if<planner::LineTask>(&task))
    return {{line->x, y_start}, {line->x, line->y_end}};
  std::vector<Eigen::Vector2d> points;
  if (const auto* path = std::get_if<planner::PathTask>(&task)) {
    points = path->points;
  } else {
    const planner::CircleTask circle = circle_of(task);
    for (int i = 0; i < 240; ++i) {
      const double angle = 2.0 * M_PI * i / 240.0;
      points.push_back(circle.center +
                       circle.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  points.push_back(points.front());
  return points;
}

}  // namespace c3rt::cli
