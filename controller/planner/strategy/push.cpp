#include "controller/planner/strategy/push.hpp"

#include <algorithm>
#include <cmath>

#include "controller/planner/strategy/approach.hpp"
#include "controller/planner/strategy/task_at_hand.hpp"

namespace c3rt::planner {
namespace {

constexpr double kNear = 0.01, kMostGain = 30.0;  // of near_goal_gain(): [m²] where it begins
constexpr double kRadian = 0.22;                  // a radian counts as this [m]
constexpr double kBehind = 0.5;      // cosine between its way and that of the end effector to it
constexpr double kThere = 0.5;       // of the position tolerance: it is pushed no farther
constexpr double kAngleAhead = 0.7;  // the goal's orientation is no farther away than this [rad]

enum class Stage { kWait, kHold, kApproach, kPush, kStand };

double yaw_to(const scene::Body& body, const task::Goal& goal) {
  return goal.yaw ? std::remainder(*goal.yaw - scene::yaw(body), 2.0 * M_PI) : 0.0;
}

/// All that the strategy remembers from period to period.
struct PushState {
  explicit PushState(const Parameters& parameters)
      : task(parameters.task), approach(parameters.approach, parameters.geometry.table_height) {}
  TaskAtHand task;
  Approach approach;
  Stage stage = Stage::kWait;
  Eigen::Vector3d stands = Eigen::Vector3d::Zero();  // the end effector, in W [m]
};

class Push final : public Strategy {
 public:
  Push(const Parameters& parameters, C3Controller& c3)
      : parameters_(parameters),
        state_(parameters),
        weights_(parameters.push.weights),
        costs_(c3.add_costs(costs_of(c3.problem(), weights_))),
        height_(parameters.geometry.table_height + parameters.push.height) {
    reset();
  }

  void reset() override {
    state_ = PushState(parameters_);
    decision_ = {};
    decision_.desired.resize(static_cast<std::size_t>(parameters_.N) + 1);
  }

  const Decision& decide(const Situation& now, C3Controller& c3) override {
    const Input& input = *now.input;
    PushState& s = state_;
    s.task.take(input.target);
    const std::optional<task::Goal> goal = s.task.goal();
    const Stage before = s.stage;
    s.stage = next(now, goal);
    if (s.stage != before || now.interrupted) {
      s.approach.begin(input.effector.p_WE);
      s.stands = input.effector.p_WE;
    }
    decision_.body_lost = before == Stage::kPush && !now.available.all();
    decision_.body = goal ? goal->body : 0;
    decision_.plans_with_c3 = s.stage == Stage::kPush;
    decision_.phase = "push";
    decision_.v_WE.setZero();
    decision_.cause = Cause::kNone;
    const ApproachInput way{input.now, now.period, input.effector.p_WE, input.robot_follows};
    switch (s.stage) {
      case Stage::kWait:
        decision_.mode = Mode::kWait;
        break;
      case Stage::kHold:
        decision_.mode = Mode::kHold;
        decision_.cause = s.task.done() ? Cause::kAtTarget : Cause::kAsked;
        s.approach.out_of_the_way(way);
        decision_.p_WE = s.approach.reference();
        break;
      case Stage::kApproach: {
        decision_.mode = Mode::kApproach;
        const scene::Body& body = now.scene.body(goal->body);
        Eigen::Vector3d start = behind(body, goal->at, parameters_.push,
                                       parameters_.geometry.end_effector_radius, height_);
        start.z() -= parameters_.approach.start_height;
        s.approach.to_body(way, start);
        decision_.p_WE = s.approach.reference();
        decision_.v_WE = s.approach.velocity();
        decision_.body_target << goal->at, body.p_WB.z();
        break;
      }
      case Stage::kPush:
        decision_.mode = Mode::kTask;
        s.task.begin(input.now);
        push(now.scene, *goal, c3);
        break;
      case Stage::kStand:
        decision_.mode = Mode::kTask;
        decision_.p_WE = s.stands;
        break;
    }
    return decision_;
  }

 private:
  Stage next(const Situation& now, const std::optional<task::Goal>& goal) {
    const Input& input = *now.input;
    if (!now.available.state()) return Stage::kWait;
    const bool hold = input.stopped || std::holds_alternative<HoldTarget>(input.target);
    if (hold || !goal || !now.available.all() || now.robot_left) return Stage::kHold;
    state_.task.advance(input.now, now.scene);
    if (state_.task.done()) return Stage::kHold;
    const scene::Body& body = now.scene.body(goal->body);
    const Eigen::Vector2d way = goal->at - body.p_WB.head<2>();
    const Eigen::Vector2d to_body = (body.p_WB - now.scene.effector.p_WE).head<2>();
    const bool is_behind = way.dot(to_body) > kBehind * way.norm() * to_body.norm();
    const bool reached = state_.task.reached();
    switch (state_.stage) {
      case Stage::kWait:
      case Stage::kHold:
        return Stage::kApproach;
      case Stage::kApproach:
        return state_.approach.settled(input.now) ? Stage::kPush : Stage::kApproach;
      case Stage::kPush:
        if (reached && way.norm() < kThere * goal->position_tolerance) return Stage::kStand;
        if (reached && !is_behind) return Stage::kStand;
        return is_behind ? Stage::kPush : Stage::kApproach;
      case Stage::kStand:
        return reached ? Stage::kStand : is_behind ? Stage::kPush : Stage::kApproach;
    }
    return Stage::kHold;
  }

  /// Algorithm 3, step 1, and what is wanted at each stage.
  void push(const scene::Scene& scene, const task::Goal& goal, C3Controller& c3) {
    decision_.x_hat = scene;
    scene::Body& body = decision_.x_hat.body(goal.body);
    // what lies on the table moves no farther than it is pushed; its measured velocity is noise
    body.v_WB.setZero();
    body.omega_WB.setZero();
    const Eigen::Vector2d way = goal.at - body.p_WB.head<2>();
    const double turn = yaw_to(body, goal);
    scene::Scene wanted = decision_.x_hat;
    scene::Body& there = wanted.body(goal.body);
    const double ahead = std::min(1.0, parameters_.push.look_ahead / std::max(way.norm(), 1e-9));
    there.p_WB.head<2>() += ahead * way;
    const double turned = std::clamp(turn, -kAngleAhead, kAngleAhead);
    const Eigen::AngleAxisd about_z(turned, Eigen::Vector3d::UnitZ());
    there.q_WB = Eigen::Quaterniond(about_z) * Eigen::Quaterniond(body.q_WB);
    wanted.effector.p_WE.z() = height_;
    wanted.effector.v_WE.setZero();
    std::fill(decision_.desired.begin(), decision_.desired.end(), wanted);
    decision_.body_target << goal.at, body.p_WB.z();

    const model::Layout& layout = c3.model().layout();
    const double gain = near_goal_gain(way.norm(), turn);
    for (const auto& [name, values] : parameters_.push.weights.Q) {
      std::vector<double>& now = weights_.Q[name];
      const bool of_body = layout.bodies(name).front() >= 0;
      for (std::size_t i = 0; i < values.size(); ++i) now[i] = (of_body ? gain : 1.0) * values[i];
    }
    c3.replace_costs(costs_, costs_of(c3.problem(), weights_));
    decision_.costs = costs_;
  }

  const Parameters parameters_;
  PushState state_;
  PhaseWeights weights_;  // of this period
  int costs_;
  double height_;  // of the end effector that pushes, in W [m]
  Decision decision_;
};

}  // namespace

Eigen::Vector3d behind(const scene::Body& body, const Eigen::Vector2d& goal,
                       const PushParameters& parameters, double end_effector_radius,
                       double height) {
  const Eigen::Vector2d way = goal - body.p_WB.head<2>();
  const Eigen::Vector2d forward =
      way.norm() > 1e-9 ? Eigen::Vector2d(way.normalized()) : Eigen::Vector2d::UnitX();
  // from far enough away straight towards the surface
  const double away = body.shape.half_sizes.head<2>().norm() + body.shape.radius +
                      end_effector_radius + parameters.gap;
  scene::Effector effector;
  effector.radius = end_effector_radius;
  effector.p_WE << body.p_WB.head<2>() - away * forward, height;
  const scene::Gap gap = scene::gap(effector, body);
  Eigen::Vector3d start = effector.p_WE - (gap.distance - parameters.gap) * gap.normal;
  start.z() = height;
  return start;
}

double near_goal_gain(double distance, double angle) {
  const double cost = distance * distance + kRadian * kRadian * angle * angle;
  return std::clamp(kNear / std::max(cost, 1e-12), 1.0, kMostGain);
}

std::unique_ptr<Strategy> make_push(const Parameters& parameters, C3Controller& c3) {
  return std::make_unique<Push>(parameters, c3);
}

}  // namespace c3rt::planner
