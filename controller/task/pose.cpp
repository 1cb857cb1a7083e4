#include "controller/task/pose.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::task {
namespace {

constexpr double kTurn = 3.15;  // more than any angle between two orientations [rad]
constexpr int kMostGoals = 32;

class PoseProgress final : public Progress {
 public:
  explicit PoseProgress(const Pose& pose) : pose_(pose) {}

  void add(double elapsed, const std::vector<Placement>& bodies) override {
    if (pose_.body >= static_cast<int>(bodies.size())) return;
    const Placement& body = bodies[static_cast<std::size_t>(pose_.body)];
    const int before = state_.goal;
    pose_.advance(elapsed, body, state_);
    if (state_.goal > before) times_.push_back(elapsed);
    if (std::isnan(last_reached_) && state_.goal + 1 >= static_cast<int>(pose_.goals.size()) &&
        pose_.reached(pose_.goals.back(), body))
      last_reached_ = elapsed;
    position_error_ = pose_.position_error(pose_.goals.back(), body);
    angle_error_ = pose_.angle_error(pose_.goals.back(), body);
  }
  double amount() const override { return static_cast<double>(state_.goal); }
  int completed() const override { return pose_.done(state_) ? 1 : 0; }
  std::vector<double> times() const override {
    return completed() == 0 ? std::vector<double>{} : std::vector<double>{times_.back()};
  }
  double judged_from() const override { return last_reached_; }
  std::vector<std::pair<std::string, double>> results() const override {
    return {{"goals_reached", amount()},
            {"goal_time_s", times_.empty() || completed() == 0 ? kNone : times_.back()},
            {"end_position_error_m", position_error_},
            {"end_angle_error_rad", angle_error_}};
  }

 private:
  Pose pose_;
  State state_;
  std::vector<double> times_;    // of each goal [s]
  double last_reached_ = kNone;  // the last goal was, for the first time [s]
  double position_error_ = kNone, angle_error_ = kNone;
};

}  // namespace

Pose Pose::load(Source& source) {
  Pose pose{};
  if (source.has("object")) {
    const double object = source.number("object", 0, scene::kMaxBodies - 1);
    pose.body = static_cast<int>(object);
    if (object != pose.body) source.fail("object", "a whole number", std::to_string(object));
  }
  const Eigen::MatrixXd at = source.rows("goals_m", 1, kMostGoals, 2, -1, 1);
  const auto count = static_cast<int>(at.rows());
  const Eigen::VectorXd near = source.one_or_each("position_tolerance_m", count, 1e-4, 1),
                        hold = source.one_or_each("hold_s", count, 0, 60);
  // a body that is round has no orientation worth a tolerance
  const bool turned = source.has("yaws_rad") || source.has("angle_tolerance_rad");
  Eigen::VectorXd yaw, turn = Eigen::VectorXd::Constant(count, kTurn);
  if (turned) {
    yaw = source.one_or_each("yaws_rad", count, -kTurn, kTurn);
    turn = source.one_or_each("angle_tolerance_rad", count, 1e-3, kTurn);
  }
  for (int i = 0; i < count; ++i) {
    pose.goals.push_back({at.row(i).transpose(),
                          turned ? std::optional<double>(yaw[i]) : std::nullopt, near[i], turn[i],
                          hold[i]});
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

const PoseGoal& Pose::due(const State& state) const noexcept {
  return done(state) ? goals.back() : goals[static_cast<std::size_t>(state.goal)];
}

std::optional<Goal> Pose::goal(const State& state) const noexcept {
  const PoseGoal& now = due(state);
  return Goal{body, now.at, now.yaw, now.position_tolerance, now.angle_tolerance};
}

void Pose::advance(double elapsed, const Placement& placed, State& state) const noexcept {
  if (done(state)) return;
  const PoseGoal& now = due(state);
  if (!reached(now, placed)) {
    state.reached_since = kNone;
    return;
  }
  if (std::isnan(state.reached_since)) state.reached_since = elapsed;
  if (elapsed - state.reached_since >= now.hold) state = {state.goal + 1, kNone};
}

void Pose::advance(double elapsed, const scene::Scene& scene, State& state) const noexcept {
  if (body >= scene.body_count) return;
  const scene::Body& moved = scene.body(body);
  advance(elapsed, Placement(moved.p_WB.head<2>(), moved.q_WB), state);
}

Eigen::Vector2d Pose::target(const scene::Scene& scene, int of, const State& state) const noexcept {
  return of == body ? due(state).at : Eigen::Vector2d(scene.body(of).p_WB.head<2>());
}

double Pose::error(double, const Eigen::Vector2d& at) const noexcept {
  return (at - goals.back().at).norm();
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
  const std::string more = goals.size() > 1 ? words(", then %zu more", goals.size() - 1) : "";
  return words("pose (%g, %g) m%s%s", first.at.x(), first.at.y(), yaw.c_str(), more.c_str());
}

std::string Pose::refusal(const Limits& limits) const {
  if (body >= limits.bodies)
    return words("expected an object of 0 to %d, got %d", limits.bodies - 1, body);
  if (limits.bodies != 1)
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
