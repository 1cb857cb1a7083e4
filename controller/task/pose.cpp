#include "controller/task/pose.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/base/quantile.hpp"
#include "controller/base/random.hpp"

namespace c3rt::task {
namespace {

constexpr double kTurn = 3.15;  // more than any angle between two orientations [rad]
constexpr int kMostGoals = 32, kMostDrawn = 1000;
constexpr State kEnd{std::numeric_limits<int>::max(), kNone};  // all goals are done
constexpr double kSure = 0.8;       // of the tolerances, where something is sensed
constexpr std::uint64_t kSeed = 1;  // of a run that nobody gave one
// what others draw from the same seed shall not be the same numbers
constexpr std::uint64_t kStream = 0x9FB21C651E98DF25;

class PoseProgress final : public Progress {
 public:
  explicit PoseProgress(const Pose& pose) : pose_(pose) { state_.since = 0.0; }

  void add(double elapsed, const std::vector<Placement>& bodies) override {
    if (static_cast<int>(bodies.size()) < pose_.bodies()) return;
    const State before = state_;
    pose_.advance(elapsed, bodies, state_);
    if (state_.goal > before.goal) {
      time_ = elapsed;
      if (state_.missed == before.missed) each_.push_back(elapsed - before.since);
    }
    position_error_ = angle_error_ = 0.0;
    bool reached = true;
    for (int i = 0; i < pose_.bodies(); ++i) {
      const PoseGoal* last = pose_.due(kEnd, i);
      if (last == nullptr) continue;
      const Placement& body = bodies[static_cast<std::size_t>(i)];
      reached = reached && pose_.due(state_, i) == last && pose_.reached(*last, body);
      position_error_ = std::max(position_error_, pose_.position_error(*last, body));
      angle_error_ = std::max(angle_error_, pose_.angle_error(*last, body));
    }
    if (std::isnan(last_reached_) && reached) last_reached_ = elapsed;
  }
  double amount() const override { return static_cast<double>(state_.goal - state_.missed); }
  int completed() const override { return pose_.done(state_) ? 1 : 0; }
  std::vector<double> times() const override {
    return completed() == 0 ? std::vector<double>{} : std::vector<double>{time_};
  }
  double judged_from() const override { return last_reached_; }
  std::vector<std::pair<std::string, double>> results() const override {
    std::vector<double> each = each_;
    std::sort(each.begin(), each.end());
    return {{"goals_reached", amount()},
            {"goals_missed", state_.missed},
            {"goal_time_s", completed() == 0 ? kNone : time_},
            {"goal_time_median_s", each.empty() ? kNone : base::quantile_nearest(each, 0.5)},
            {"goal_time_longest_s", each.empty() ? kNone : each.back()},
            {"end_position_error_m", position_error_},
            {"end_angle_error_rad", angle_error_}};
  }

 private:
  Pose pose_;
  State state_;
  double time_ = kNone;          // of the goals that were done last [s]
  std::vector<double> each_;     // of those that were reached, since they were due [s]
  double last_reached_ = kNone;  // the last goals were, for the first time [s]
  double position_error_ = kNone, angle_error_ = kNone;  // the largest of the last goals
};

Eigen::Vector2d range(Source& source, const std::string& key, double min, double max) {
  const Eigen::VectorXd ends = source.numbers(key, 2, min, max);
  if (ends[0] > ends[1])
    source.fail(key, "the smaller one first", words("%g and %g", ends[0], ends[1]));
  return ends;
}

int whole(Source& source, const std::string& key, double value) {
  if (value != std::floor(value)) source.fail(key, "whole numbers", words("%g", value));
  return static_cast<int>(value);
}

/// An axis of the bodies, which way each goal wants it; none where it is not asked for.
std::vector<AxisGoal> load_axes(Source& source, int count) {
  if (!source.has("axis")) return {};
  const Eigen::Vector3d of_body = Eigen::Vector3d::Unit(source.choice("axis", {"x", "y", "z"}));
  std::vector<AxisGoal> axes(static_cast<std::size_t>(count), {of_body, of_body});
  if (!source.has("axis_to")) return axes;
  const Eigen::MatrixXd to = source.rows("axis_to", 1, count, 3, -1, 1);
  const auto rows = static_cast<int>(to.rows());
  if (rows != 1 && rows != count)
    source.fail("axis_to", words("1 direction or %d", count), words("%d", rows));
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d direction = to.row(rows == 1 ? 0 : i).transpose();
    if (direction.norm() < 1e-3) source.fail("axis_to", "directions", "one without length");
    axes[static_cast<std::size_t>(i)].to = direction.normalized();
  }
  return axes;
}

Eigen::Vector3d turned_by(double yaw, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * axis;
}

}  // namespace

Pose Pose::load(Source& source) {
  Pose pose{};
  Eigen::MatrixXd at;
  if (source.has("random_goals")) {
    for (const char* given : {"goals_m", "yaws_rad", "axis_to"}) {
      if (source.has(given)) source.fail("random_goals", words("no %s beside it", given), "both");
    }
    const int count = whole(source, "random_goals", source.number("random_goals", 1, kMostDrawn));
    at = Eigen::MatrixXd::Zero(count, 2);
    const Eigen::Vector2d x = range(source, "random_x_m", -1, 1),
                          y = range(source, "random_y_m", -1, 1);
    pose.draw = Draw{{Eigen::Vector2d(x[0], y[0]), Eigen::Vector2d(x[1], y[1])}};
    if (source.has("random_yaw_rad"))
      pose.draw->yaw = range(source, "random_yaw_rad", -kTurn, kTurn);
  } else {
    at = source.rows("goals_m", 1, kMostGoals, 2, -1, 1);
  }
  const auto count = static_cast<int>(at.rows());
  const Eigen::VectorXd near = source.one_or_each("position_tolerance_m", count, 1e-4, 1),
                        hold = source.one_or_each("hold_s", count, 0, 60);
  Eigen::VectorXd body = Eigen::VectorXd::Zero(count);
  if (source.has("object")) body = source.one_or_each("object", count, 0, scene::kMaxBodies - 1);
  Eigen::VectorXd limit = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  if (source.has("time_limit_s")) limit = source.one_or_each("time_limit_s", count, 0.1, 1e6);
  const std::vector<AxisGoal> axes = load_axes(source, count);
  // a body that is round has no orientation worth a tolerance
  const bool drawn = pose.draw && pose.draw->yaw, yaws = !pose.draw && source.has("yaws_rad");
  const bool turned = drawn || yaws || !axes.empty() || source.has("angle_tolerance_rad");
  Eigen::VectorXd yaw = Eigen::VectorXd::Zero(count),
                  turn = Eigen::VectorXd::Constant(count, kTurn);
  if (turned) {
    if (yaws || (!drawn && axes.empty()))
      yaw = source.one_or_each("yaws_rad", count, -kTurn, kTurn);
    turn = source.one_or_each("angle_tolerance_rad", count, 1e-3, kTurn);
  }
  if (yaws && source.has("axis_to")) source.fail("axis_to", "no yaws_rad beside it", "both");
  for (int i = 0; i < count; ++i) {
    PoseGoal goal{at.row(i).transpose(), std::nullopt, near[i], turn[i], hold[i]};
    goal.body = whole(source, "object", body[i]);
    goal.time_limit = limit[i];
    if (!axes.empty()) {
      goal.axis = axes[static_cast<std::size_t>(i)];
      if (yaws) goal.axis->to = turned_by(yaw[i], goal.axis->of_body);
    } else if (turned) {
      goal.yaw = yaw[i];
    }
    pose.goals.push_back(goal);
  }
  return pose.seeded(kSeed);
}

Pose Pose::seeded(std::uint64_t seed) const {
  Pose pose = *this;
  if (!draw) return pose;
  base::Random random(seed ^ kStream);
  const auto between = [&](double from, double to) {
    return from + (to - from) * random.uniform();
  };
  for (PoseGoal& goal : pose.goals) {
    goal.at.x() = between(draw->at.min().x(), draw->at.max().x());
    goal.at.y() = between(draw->at.min().y(), draw->at.max().y());
    if (!draw->yaw) continue;
    const double yaw = between(draw->yaw->x(), draw->yaw->y());
    if (goal.axis) {
      goal.axis->to = turned_by(yaw, goal.axis->of_body);
    } else {
      goal.yaw = yaw;
    }
  }
  return pose;
}

double Pose::position_error(const PoseGoal& goal, const Placement& placed) const noexcept {
  return (placed.at - goal.at).norm();
}

double Pose::angle_error(const PoseGoal& goal, const Placement& placed) const noexcept {
  if (goal.axis) {
    const Eigen::Vector3d now = Eigen::Quaterniond(placed.q) * goal.axis->of_body;
    return std::atan2(now.cross(goal.axis->to).norm(), now.dot(goal.axis->to));
  }
  if (!goal.yaw) return 0.0;
  const Eigen::Quaterniond wanted(Eigen::AngleAxisd(*goal.yaw, Eigen::Vector3d::UnitZ()));
  return wanted.angularDistance(Eigen::Quaterniond(placed.q));
}

bool Pose::reached(const PoseGoal& goal, const Placement& placed) const noexcept {
  return reached(goal, placed, 1.0);
}

bool Pose::reached(const PoseGoal& goal, const Placement& placed, double part) const noexcept {
  return position_error(goal, placed) <= part * goal.position_tolerance &&
         angle_error(goal, placed) <= part * goal.angle_tolerance;
}

bool Pose::done(const State& state) const noexcept {
  return state.goal >= static_cast<int>(goals.size());
}

int Pose::bodies() const noexcept {
  int count = 0;
  for (const PoseGoal& goal : goals) count = std::max(count, goal.body + 1);
  return count;
}

std::size_t Pose::end_of_due(const State& state) const noexcept {
  const auto first = static_cast<std::size_t>(state.goal);
  std::size_t end = std::min(first, goals.size());
  const auto has = [&](int body) {
    return std::any_of(goals.begin() + static_cast<std::ptrdiff_t>(first),
                       goals.begin() + static_cast<std::ptrdiff_t>(end),
                       [&](const PoseGoal& goal) { return goal.body == body; });
  };
  while (end < goals.size() && !has(goals[end].body)) ++end;
  return end;
}

const PoseGoal* Pose::due(const State& state, int body) const noexcept {
  for (std::size_t i = end_of_due(state); i > 0; --i) {
    if (goals[i - 1].body == body) return &goals[i - 1];
  }
  return nullptr;
}

std::optional<Goal> Pose::goal(const State& state, int body) const noexcept {
  const PoseGoal* now = due(state, body);
  if (now == nullptr) return std::nullopt;
  return Goal{now->at, now->yaw, now->position_tolerance, now->angle_tolerance, now->axis};
}

template <typename PlacementOf>
void Pose::advance_with(double elapsed, const PlacementOf& of, double part,
                        State& state) const noexcept {
  if (done(state)) return;
  double hold = 0.0;
  bool all = true;
  for (int i = 0; i < bodies(); ++i) {
    const PoseGoal* now = due(state, i);
    if (now == nullptr) continue;
    all = all && reached(*now, of(i), part);
    hold = std::max(hold, now->hold);
  }
  const auto end = static_cast<int>(end_of_due(state));
  if (all) {
    if (std::isnan(state.reached_since)) state.reached_since = elapsed;
    if (elapsed - state.reached_since >= hold) state = {end, kNone, elapsed, state.missed};
    return;
  }
  state.reached_since = kNone;
  double limit = 0.0;
  for (int i = state.goal; i < end; ++i)
    limit = std::max(limit, goals[static_cast<std::size_t>(i)].time_limit);
  // not before the task has begun, as comparisons with kNone are false
  if (elapsed - state.since >= limit)
    state = {end, kNone, elapsed, state.missed + end - state.goal};
}

void Pose::advance(double elapsed, const std::vector<Placement>& placed,
                   State& state) const noexcept {
  if (static_cast<int>(placed.size()) < bodies()) return;
  const auto of = [&](int i) { return placed[static_cast<std::size_t>(i)]; };
  advance_with(elapsed, of, 1.0, state);
}

void Pose::advance(double elapsed, const scene::Scene& scene, State& state) const noexcept {
  if (scene.body_count < bodies()) return;
  const auto of = [&](int i) {
    return Placement(scene.body(i).p_WB.head<2>(), scene.body(i).q_WB);
  };
  advance_with(elapsed, of, in_turn() ? kSure : 1.0, state);
}

Eigen::Vector2d Pose::target(const scene::Scene& scene, int of, const State& state) const noexcept {
  const PoseGoal* now = due(state, of);
  return now != nullptr ? now->at : Eigen::Vector2d(scene.body(of).p_WB.head<2>());
}

double Pose::error(double, const Eigen::Vector2d& at, int body) const noexcept {
  const PoseGoal* last = due(kEnd, body);
  return last == nullptr ? 0.0 : (at - last->at).norm();
}

Eigen::Vector2d Pose::middle() const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const PoseGoal& goal : goals) sum += goal.at;
  return sum / static_cast<double>(goals.size());
}

std::vector<Eigen::Vector2d> Pose::outline(const Eigen::AlignedBox2d&) const {
  std::vector<Eigen::Vector2d> points;
  for (const PoseGoal& goal : goals) points.push_back(goal.at);
  // a line has two ends, even where it has no length
  if (points.size() == 1) points.push_back(points.front());
  return points;
}

std::unique_ptr<Progress> Pose::progress() const { return std::make_unique<PoseProgress>(*this); }

std::string Pose::describe() const {
  if (draw) {
    const Eigen::Vector2d &min = draw->at.min(), &max = draw->at.max();
    const std::string yaw = draw->yaw ? words(", yaw %g to %g deg", draw->yaw->x() * 180.0 / M_PI,
                                              draw->yaw->y() * 180.0 / M_PI)
                                      : "";
    return words("%zu poses drawn in x %g to %g, y %g to %g m%s", goals.size(), min.x(), max.x(),
                 min.y(), max.y(), yaw.c_str());
  }
  const PoseGoal& first = goals.front();
  std::string turned = first.yaw ? words(", yaw %g deg", *first.yaw * 180.0 / M_PI) : "";
  if (first.axis) {
    const Eigen::Vector3d &axis = first.axis->of_body, &to = first.axis->to;
    turned = words(", axis %c to (%.2g, %.2g, %.2g)",
                   axis.x() == 1   ? 'x'
                   : axis.y() == 1 ? 'y'
                                   : 'z',
                   to.x(), to.y(), to.z());
  }
  const std::string more = goals.size() > 1 ? words(", and %zu more", goals.size() - 1) : "";
  return words("pose (%g, %g) m%s%s", first.at.x(), first.at.y(), turned.c_str(), more.c_str());
}

std::string Pose::refusal(const Limits& limits) const {
  if (bodies() > limits.bodies)
    return words("expected objects of 0 to %d, got %d", limits.bodies - 1, bodies() - 1);
  if (limits.bodies != 1 && !limits.goals_of_several)
    return words("expected a task for %d bodies, got a pose, which is for one", limits.bodies);
  const auto outside = [&](const Eigen::Vector2d& at) {
    return limits.holds(at) ? std::string()
                            : words("expected a goal with %s, got (%g, %g)", limits.words().c_str(),
                                    at.x(), at.y());
  };
  // whatever the seed
  if (draw) {
    const std::string least = outside(draw->at.min());
    return least.empty() ? outside(draw->at.max()) : least;
  }
  for (const PoseGoal& goal : goals) {
    std::string refused = outside(goal.at);
    if (!refused.empty()) return refused;
  }
  return {};
}

}  // namespace c3rt::task
