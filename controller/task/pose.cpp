#include "controller/task/pose.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::task {
namespace {

constexpr double kTurn = 3.15;  // more than any angle between two orientations [rad]
constexpr int kMostGoals = 32;
constexpr State kEnd{kMostGoals, kNone};  // all goals are done

class PoseProgress final : public Progress {
 public:
  explicit PoseProgress(const Pose& pose) : pose_(pose) {}

  void add(double elapsed, const std::vector<Placement>& bodies) override {
    if (static_cast<int>(bodies.size()) < pose_.bodies()) return;
    const int before = state_.goal;
    pose_.advance(elapsed, bodies, state_);
    if (state_.goal > before) time_ = elapsed;
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
  double amount() const override { return static_cast<double>(state_.goal); }
  int completed() const override { return pose_.done(state_) ? 1 : 0; }
  std::vector<double> times() const override {
    return completed() == 0 ? std::vector<double>{} : std::vector<double>{time_};
  }
  double judged_from() const override { return last_reached_; }
  std::vector<std::pair<std::string, double>> results() const override {
    return {{"goals_reached", amount()},
            {"goal_time_s", completed() == 0 ? kNone : time_},
            {"end_position_error_m", position_error_},
            {"end_angle_error_rad", angle_error_}};
  }

 private:
  Pose pose_;
  State state_;
  double time_ = kNone;          // of the goals that were done last [s]
  double last_reached_ = kNone;  // the last goals were, for the first time [s]
  double position_error_ = kNone, angle_error_ = kNone;  // the largest of the last goals
};

}  // namespace

Pose Pose::load(Source& source) {
  Pose pose{};
  const Eigen::MatrixXd at = source.rows("goals_m", 1, kMostGoals, 2, -1, 1);
  const auto count = static_cast<int>(at.rows());
  const Eigen::VectorXd near = source.one_or_each("position_tolerance_m", count, 1e-4, 1),
                        hold = source.one_or_each("hold_s", count, 0, 60);
  Eigen::VectorXd body = Eigen::VectorXd::Zero(count);
  if (source.has("object")) body = source.one_or_each("object", count, 0, scene::kMaxBodies - 1);
  // a body that is round has no orientation worth a tolerance
  const bool turned = source.has("yaws_rad") || source.has("angle_tolerance_rad");
  Eigen::VectorXd yaw, turn = Eigen::VectorXd::Constant(count, kTurn);
  if (turned) {
    yaw = source.one_or_each("yaws_rad", count, -kTurn, kTurn);
    turn = source.one_or_each("angle_tolerance_rad", count, 1e-3, kTurn);
  }
  for (int i = 0; i < count; ++i) {
    if (body[i] != std::floor(body[i]))
      source.fail("object", "whole numbers", words("%g", body[i]));
    pose.goals.push_back({at.row(i).transpose(),
                          turned ? std::optional<double>(yaw[i]) : std::nullopt, near[i], turn[i],
                          hold[i], static_cast<int>(body[i])});
  }
  return pose;
}

double Pose::position_error(const PoseGoal& goal, const Placement& placed) const noexcept {
  return (placed.at - goal.at).norm();
}

double Pose::angle_error(const PoseGoal& goal, const Placement& placed) const noexcept {
  if (!goal.yaw) return 0.0;
  const Eigen::Quaterniond wanted(Eigen::AngleAxisd(*goal.yaw, Eigen::Vector3d::UnitZ()));
  return wanted.angularDistance(Eigen::Quaterniond(placed.q));
}

bool Pose::reached(const PoseGoal& goal, const Placement& placed) const noexcept {
  return position_error(goal, placed) <= goal.position_tolerance &&
         angle_error(goal, placed) <= goal.angle_tolerance;
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
  return Goal{now->at, now->yaw, now->position_tolerance, now->angle_tolerance};
}

template <typename PlacementOf>
void Pose::advance_with(double elapsed, const PlacementOf& of, State& state) const noexcept {
  if (done(state)) return;
  double hold = 0.0;
  bool all = true;
  for (int i = 0; i < bodies(); ++i) {
    const PoseGoal* now = due(state, i);
    if (now == nullptr) continue;
    all = all && reached(*now, of(i));
    hold = std::max(hold, now->hold);
  }
  if (!all) {
    state.reached_since = kNone;
    return;
  }
  if (std::isnan(state.reached_since)) state.reached_since = elapsed;
  if (elapsed - state.reached_since >= hold) state = {static_cast<int>(end_of_due(state)), kNone};
}

void Pose::advance(double elapsed, const std::vector<Placement>& placed,
                   State& state) const noexcept {
  if (static_cast<int>(placed.size()) < bodies()) return;
  const auto of = [&](int i) { return placed[static_cast<std::size_t>(i)]; };
  advance_with(elapsed, of, state);
}

void Pose::advance(double elapsed, const scene::Scene& scene, State& state) const noexcept {
  if (scene.body_count < bodies()) return;
  const auto of = [&](int i) {
    return Placement(scene.body(i).p_WB.head<2>(), scene.body(i).q_WB);
  };
  advance_with(elapsed, of, state);
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
  const PoseGoal& first = goals.front();
  const std::string yaw = first.yaw ? words(", yaw %g deg", *first.yaw * 180.0 / M_PI) : "";
  const std::string more = goals.size() > 1 ? words(", and %zu more", goals.size() - 1) : "";
  return words("pose (%g, %g) m%s%s", first.at.x(), first.at.y(), yaw.c_str(), more.c_str());
}

std::string Pose::refusal(const Limits& limits) const {
  if (bodies() > limits.bodies)
    return words("expected objects of 0 to %d, got %d", limits.bodies - 1, bodies() - 1);
  if (limits.bodies != 1 && !limits.goals_of_several)
    return words("expected a task for %d bodies, got a pose, which is for one", limits.bodies);
  for (const PoseGoal& goal : goals) {
    if (!limits.holds(goal.at)) {
      return words("expected a goal with %s, got (%g, %g)", limits.words().c_str(), goal.at.x(),
                   goal.at.y());
    }
  }
  return {};
}

}  // namespace c3rt::task
