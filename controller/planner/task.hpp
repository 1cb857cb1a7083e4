#pragma once
// What the balls are to do: a value of three kinds.
#include <variant>
#include <vector>

#include <Eigen/Core>

namespace c3rt::planner {

/// State-based: round a circle, always a lead ahead of where the ball is. Source: [C3, eq. (25)].
struct CircleTask {
  Eigen::Vector2d center;  // in W [m]
  double radius;           // [m]
  double lead;             // α^l of (25); positive is clockwise seen from above [rad]
};

enum class Between {
  kHold,         // x_d^b jumps from way-point to way-point (zero-order hold)
  kInterpolate,  // and moves between them at constant speed
};

/// Time-based, x_d^b = x_d^b(t): way-points, one an interval, over and over. Its clock starts when
/// C3 takes over from the approach. Source: [C3, section VII-D].
struct PathTask {
  std::vector<Eigen::Vector2d> points;  // in W, at least two [m]
  double interval;                      // between way-points [s]
  Between between;
  double lead;   // the planner draws the ball to where it should be this much later [s]
  bool preview;  // stage k of the horizon has x_d^b(t + lead + k Δt) and its velocity, not x_d^b(t
                 // + lead) at rest
};

/// State-based, for several balls: every ball along one line of constant x, a pace at a time, to a
/// place of its own past the end: the last ball just past it, each one ahead of it farther by the
/// spacing. Source: [C3, section VII-B], where the balls have no place to stop.
struct LineTask {
  double x;        // of the line, in W [m]
  double step;     // of y from where the ball is; its sign is the line's direction [m]
  double y_end;    // where a ball has arrived [m]
  double spacing;  // of the places where the balls come to rest, positive [m]
};

using Task = std::variant<CircleTask, PathTask, LineTask>;

/// The ball's next desired position on the circle, (x, y) in W [m]:
///
///   α = atan2(x − x_c, y − y_c),  x_d = x_c + r sin(α + α^l),  y_d = y_c + r cos(α + α^l)
///
/// Source: [C3, eq. (25)].
Eigen::Vector2d circle_target(const CircleTask& task, const Eigen::Vector2d& ball) noexcept;

/// x_d^b(t), in W [m]. @param elapsed t since the task began [s]; before it, the first way-point
Eigen::Vector2d path_point(const PathTask& task, double elapsed) noexcept;

/// ẋ_d^b(t), in W [m/s]; 0 of held way-points.
Eigen::Vector2d path_velocity(const PathTask& task, double elapsed) noexcept;

/// How long one round of all way-points takes [s].
double round_duration(const PathTask& task) noexcept;

/// The line's direction along y: 1 or −1.
double forward(const LineTask& task) noexcept;

/// Whether a ball at y has arrived.
bool past_end(const LineTask& task, double y) noexcept;

/// How far the ball has to go along the line, negative if it is past its place [m].
/// @param behind how many balls are behind it
double way_to_go(const LineTask& task, const Eigen::Vector2d& ball, int behind) noexcept;

/// x_d^b of the ball: no farther than a pace away, along the line and towards it.
Eigen::Vector2d line_target(const LineTask& task, const Eigen::Vector2d& ball, int behind) noexcept;

/// Where the planner draws a ball to at a stage of its horizon, in W [m].
/// @param elapsed since the task began [s]  @param ahead of the stage [s]
Eigen::Vector2d target(const Task& task, double elapsed, double ahead,
                       const Eigen::Vector2d& ball) noexcept;

/// And with which velocity: that of a path that is previewed, else at rest, in W [m/s].
Eigen::Vector2d target_velocity(const Task& task, double elapsed, double ahead) noexcept;

/// How far the ball is from where it should be [m]: of a state-based task the distance to its line,
/// of one in time the distance to the point x_d^b(t).
double path_error(const Task& task, double elapsed, const Eigen::Vector2d& ball) noexcept;

/// A point about which the task takes place, in W [m].
Eigen::Vector2d middle(const Task& task) noexcept;

}  // namespace c3rt::planner
