#include "controller/planner/task.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::planner {

Eigen::Vector2d circle_target(const CircleTask& task, const Eigen::Vector2d& ball) noexcept {
  const Eigen::Vector2d from_center = ball - task.center;
  const double alpha = std::atan2(from_center.x(), from_center.y()) + task.lead;
  return task.center + task.radius * Eigen::Vector2d(std::sin(alpha), std::cos(alpha));
}

namespace {

/// Between which two way-points the path is, and how far from the first to the second.
struct Place {
  std::size_t from, to;
  double share;
};

Place place_at(const PathTask& task, double elapsed) noexcept {
  const double place = std::fmod(std::max(elapsed, 0.0), round_duration(task)) / task.interval;
  const std::size_t count = task.points.size();
  const std::size_t from = std::min(static_cast<std::size_t>(place), count - 1);
  return {from, (from + 1) % count, place - static_cast<double>(from)};
}

}  // namespace

Eigen::Vector2d path_point(const PathTask& task, double elapsed) noexcept {
  const Place place = place_at(task, elapsed);
  if (task.between == Between::kHold) return task.points[place.from];
  return (1.0 - place.share) * task.points[place.from] + place.share * task.points[place.to];
}

Eigen::Vector2d path_velocity(const PathTask& task, double elapsed) noexcept {
  if (task.between == Between::kHold) return Eigen::Vector2d::Zero();
  const Place place = place_at(task, elapsed);
  return (task.points[place.to] - task.points[place.from]) / task.interval;
}

double round_duration(const PathTask& task) noexcept {
  return task.interval * static_cast<double>(task.points.size());
}

double forward(const LineTask& task) noexcept { return task.step < 0.0 ? -1.0 : 1.0; }

bool past_end(const LineTask& task, double y) noexcept {
  return forward(task) * y >= forward(task) * task.y_end;
}

double way_to_go(const LineTask& task, const Eigen::Vector2d& ball, int behind) noexcept {
  // a step past the end, so that it is passed and not approached
  return forward(task) * (task.y_end + task.step - ball.y()) + behind * task.spacing;
}

Eigen::Vector2d line_target(const LineTask& task, const Eigen::Vector2d& ball,
                            int behind) noexcept {
  const double pace = std::abs(task.step);
  const auto paced = [pace](double way) { return std::min(std::max(way, -pace), pace); };
  return ball + Eigen::Vector2d(paced(task.x - ball.x()),
                                forward(task) * paced(way_to_go(task, ball, behind)));
}

Eigen::Vector2d target(const Task& task, double elapsed, double ahead,
                       const Eigen::Vector2d& ball) noexcept {
  if (const auto* circle = std::get_if<CircleTask>(&task)) return circle_target(*circle, ball);
  if (const auto* path = std::get_if<PathTask>(&task))
    return path_point(*path, elapsed + path->lead + (path->preview ? ahead : 0.0));
  const auto& line = *std::get_if<LineTask>(&task);
  return line_target(line, ball, 0);
}

Eigen::Vector2d target_velocity(const Task& task, double elapsed, double ahead) noexcept {
  const auto* path = std::get_if<PathTask>(&task);
  if (path == nullptr || !path->preview) return Eigen::Vector2d::Zero();
  return path_velocity(*path, elapsed + path->lead + ahead);
}

double path_error(const Task& task, double elapsed, const Eigen::Vector2d& ball) noexcept {
  if (const auto* circle = std::get_if<CircleTask>(&task))
    return std::abs((ball - circle->center).norm() - circle->radius);
  if (const auto* path = std::get_if<PathTask>(&task))
    return (ball - path_point(*path, elapsed)).norm();
  return std::abs(ball.x() - std::get_if<LineTask>(&task)->x);
}

Eigen::Vector2d middle(const Task& task) noexcept {
  if (const auto* circle = std::get_if<CircleTask>(&task)) return circle->center;
  if (const auto* path = std::get_if<PathTask>(&task)) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& point : path->points) sum += point;
    return sum / static_cast<double>(path->points.size());
  }
  return {std::get_if<LineTask>(&task)->x, 0.0};
}

}  // namespace c3rt::planner
