#include "controller/planner/strategy/sampling.hpp"

#include <algorithm>
#include <cmath>

#include "controller/base/random.hpp"
#include "controller/planner/strategy/free_motion.hpp"
#include "controller/planner/strategy/places.hpp"
#include "controller/planner/strategy/surface_samples.hpp"
#include "controller/planner/strategy/task_at_hand.hpp"

namespace c3rt::planner {
namespace {

constexpr double kNear = 0.01, kMostGain = 30.0;  // of gain_near_goal(): [m²] where it begins
constexpr double kRadian = 0.22;                  // a radian counts as this [m]
constexpr double kThere = 0.5;                    // of the tolerances: it is moved no farther
constexpr double kAboveTop = 0.01;                // the end effector travels over bodies [m]
constexpr double kColumn = 2e-3;                  // beside the way straight down [m]
constexpr double kApart = 0.015;                  // another place is farther than this [m]
constexpr double kFree = 0.03;  // contacts farther apart begin free, see C3Controller [m]
constexpr double kOff = 0.015;  // what is at its goal is left by this [m]
// An arm that comes no nearer to a place by this part within this time cannot reach it [s].
constexpr double kArrivalPart = 0.02, kArrivalTime = 3.0;

enum class Stage { kWait, kHold, kChoose, kMove, kPush, kStand };

double yaw_to(const scene::Body& body, const task::Goal& goal) {
  return goal.yaw ? std::remainder(*goal.yaw - scene::yaw(body), 2.0 * M_PI) : 0.0;
}

/// It goes on by itself, where others lie still.
bool rolls(const scene::Body& body) { return body.shape.kind == scene::ShapeKind::kSphere; }

FreeMotionParameters free_motion_of(const Parameters& parameters) {
  const SamplingParameters& sampling = parameters.sampling;
  return {sampling.speed, sampling.acceleration, sampling.clear, parameters.approach.leash};
}

/// All that the strategy remembers from period to period.
struct State {
  explicit State(const Parameters& parameters)
      : task(parameters.task),
        way(free_motion_of(parameters)),
        places(parameters.sampling),
        headway(parameters.sampling.headway, parameters.sampling.headway_time),
        arrival(kArrivalPart, kArrivalTime),
        random(parameters.sampling.seed) {}
  TaskAtHand task;
  FreeMotion way;
  Places places;
  Headway headway;  // of the body
  Headway arrival;  // of the end effector at the place that it moves to
  base::Random random;
  Stage stage = Stage::kWait;
  double since = 0.0;                                // of the stage [s]
  int drawn = 0;                                     // places, since it began to choose
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  // the place that it moves to [m]
  Worth here, there;                                 // of this period
};

class Sampling final : public Strategy {
 public:
  Sampling(const Parameters& parameters, C3Controller& c3)
      : parameters_(parameters),
        of_(parameters.sampling),
        state_(parameters),
        weights_(of_.weights),
        costs_(c3.add_costs(costs_of(c3.problem(), weights_))) {
    const Geometry& geometry = parameters.geometry;
    rules_.height = geometry.table_height + of_.height;
    rules_.clearance = of_.clearance;
    rules_.column = kColumn;
    rules_.reach = {of_.reach_min, of_.reach_max};
    rules_.reach_radius = of_.reach_radius;
    c3.start_from_free_gaps(kFree);
    // one for where the end effector is or goes to, and one for each place that is drawn
    for (int i = 0; i <= std::max(of_.samples, of_.samples_to_choose); ++i) {
      rooms_.push_back(std::make_unique<Candidate>(parameters, of_.servo));
      rooms_.back()->c3().start_from_free_gaps(kFree);
    }
    tried_.reserve(rooms_.size());
    reset();
  }

  void reset() override {
    state_ = State(parameters_);
    decision_ = {};
    decision_.desired.resize(static_cast<std::size_t>(parameters_.N) + 1);
  }

  const Decision& decide(const Situation& now, C3Controller& c3) override {
    const Input& input = *now.input;
    State& s = state_;
    s.task.take(input.target);
    const std::optional<task::Goal> goal = goal_of(now);
    const Stage before = s.stage;
    const bool goes = ready(now, goal);
    if (goes) {
      want(now.scene, *goal, c3);
      s.stage = next(now, *goal);
    }
    decision_.body_lost = before == Stage::kPush && !now.available.all();
    decision_.body = goal ? goal->body : 0;
    decision_.cause = Cause::kNone;
    decision_.v_WE.setZero();
    const bool free = s.stage != Stage::kPush && s.stage != Stage::kWait;
    const bool was_free = before != Stage::kPush && before != Stage::kWait;
    if (s.stage != before) s.since = input.now;
    if ((free && !was_free) || now.interrupted)
      s.way.begin(input.effector.p_WE,
                  now.interrupted ? Eigen::Vector3d::Zero() : input.effector.v_WE);
    decision_.plans_with_c3 = s.stage == Stage::kPush;
    switch (s.stage) {
      case Stage::kWait:
        decision_.mode = Mode::kWait;
        break;
      case Stage::kHold: {
        decision_.mode = Mode::kHold;
        decision_.cause = s.task.done() ? Cause::kAtTarget : Cause::kAsked;
        const Eigen::Vector3d& at = s.way.reference();
        const double up = parameters_.geometry.table_height + parameters_.approach.safe_height;
        move(now, {at.x(), at.y(), std::max(up, at.z())});
        break;
      }
      case Stage::kChoose:
        decision_.mode = s.task.begun() ? Mode::kTask : Mode::kApproach;
        decision_.phase = "choose";
        move(now, s.way.reference());
        break;
      case Stage::kMove:
        decision_.mode = s.task.begun() ? Mode::kTask : Mode::kApproach;
        decision_.phase = "move";
        move(now, s.target);
        break;
      case Stage::kStand:
        decision_.mode = Mode::kTask;
        decision_.phase = "stand";
        move(now, off(now.scene, goal->body));
        break;
      case Stage::kPush:
        decision_.mode = Mode::kTask;
        decision_.phase = "push";
        s.task.begin(input.now);
        break;
    }
    return decision_;
  }

 private:
  /// Whether it can go about its task; else the stage is one of those without a body.
  bool ready(const Situation& now, const std::optional<task::Goal>& goal) {
    const Input& input = *now.input;
    State& s = state_;
    const bool asked = input.stopped || std::holds_alternative<HoldTarget>(input.target);
    bool ready = now.available.state() && !asked && goal && now.available.all() && !now.robot_left;
    if (ready) {
      s.task.advance(input.now, now.scene);
      ready = !s.task.done();
    }
    if (!ready) s.stage = now.available.state() ? Stage::kHold : Stage::kWait;
    return ready;
  }

  /// Where the body is to come to rest; of a task without goals where it should be next, which it
  /// never reaches.
  std::optional<task::Goal> goal_of(const Situation& now) const {
    const TaskAtHand& task = state_.task;
    if (auto goal = task.goal()) return goal;
    if (now.scene.body_count == 0) return std::nullopt;
    return task::Goal{0, task.target(now.scene, 0, now.input->now, 0.0), std::nullopt, 0.0, 0.0};
  }

  Stage next(const Situation& now, const task::Goal& goal) {
    const Input& input = *now.input;
    State& s = state_;
    const scene::Body& body = now.scene.body(goal.body);
    const Eigen::Vector3d& p_WE = input.effector.p_WE;
    const double left = left_of(body, goal);
    s.places.look(body);
    rules_.top = top_of(now.scene) + now.scene.effector.radius + kAboveTop;
    if (s.task.reached() && (s.stage == Stage::kStand || nearly(body, goal))) return Stage::kStand;
    switch (s.stage) {
      case Stage::kWait:
      case Stage::kHold:
      case Stage::kStand:
        return choose();
      case Stage::kChoose: {
        draw(now, goal.body, of_.samples_to_choose, nullptr);
        const Place* best = s.places.best(p_WE, 0.0);
        if (s.drawn < of_.least_drawn) return Stage::kChoose;
        if (best == nullptr) return choose();
        return move_to(best->p_WE, now);
      }
      case Stage::kMove: {
        // what rolls takes the place with it, and the way there
        Eigen::Vector3d carried = now.period * decision_.x_hat.body(goal.body).v_WB;
        carried.z() = 0.0;
        s.target += carried;
        s.way.carry(carried);
        draw(now, goal.body, of_.samples, &s.target);
        const Place* best = s.places.best(s.target, kApart);
        if (best != nullptr && best->worth.cost < of_.retarget * s.there.cost)
          move_to(best->p_WE, now);
        const double away = (p_WE - s.target).norm();
        if (!s.way.there() || away > parameters_.approach.tolerance) {
          if (s.arrival.made(input.now, away)) return Stage::kMove;
          s.places.fail(s.target);
          return choose();
        }
        s.headway.begin(input.now, left);
        return Stage::kPush;
      }
      case Stage::kPush: {
        draw(now, goal.body, of_.samples, &p_WE);
        const bool made = s.headway.made(input.now, left);
        if (!made) s.places.fail(p_WE);
        const Place* best = s.places.best(p_WE, kApart);
        if (!made && best == nullptr) return choose();
        const bool leaves = !made || (input.now - s.since >= of_.least_time && best != nullptr &&
                                      worth_leaving(of_, s.here, best->worth));
        if (!leaves) return Stage::kPush;
        return move_to(best->p_WE, now);
      }
    }
    return Stage::kHold;
  }

  Stage move_to(const Eigen::Vector3d& place, const Situation& now) {
    const Input& input = *now.input;
    state_.target = place;
    state_.arrival.begin(input.now, (input.effector.p_WE - place).norm());
    return Stage::kMove;
  }

  Stage choose() {
    state_.drawn = 0;
    return Stage::kChoose;
  }

  double left_of(const scene::Body& body, const task::Goal& goal) const {
    const double turn = kRadian * yaw_to(body, goal);
    return (goal.at - body.p_WB.head<2>()).squaredNorm() + turn * turn;
  }

  bool nearly(const scene::Body& body, const task::Goal& goal) const {
    return (goal.at - body.p_WB.head<2>()).norm() < kThere * goal.position_tolerance &&
           std::abs(yaw_to(body, goal)) < kThere * goal.angle_tolerance;
  }

  /// Algorithm 3, step 1, and what is wanted at each stage: no farther than can be looked ahead.
  void want(const scene::Scene& scene, const task::Goal& goal, C3Controller& c3) {
    decision_.x_hat = scene;
    scene::Body& body = decision_.x_hat.body(goal.body);
    // what lies on the table moves no farther than it is pushed; its measured velocity is noise
    if (!rolls(body)) {
      body.v_WB.setZero();
      body.omega_WB.setZero();
    }
    const Eigen::Vector2d way = goal.at - body.p_WB.head<2>();
    const double turn = yaw_to(body, goal);
    wanted_ = decision_.x_hat;
    scene::Body& there = wanted_.body(goal.body);
    const double ahead = std::min(1.0, of_.look_ahead / std::max(way.norm(), 1e-9));
    there.p_WB.head<2>() += ahead * way;
    const double turned = std::clamp(turn, -of_.look_ahead_angle, of_.look_ahead_angle);
    const Eigen::AngleAxisd about_z(turned, Eigen::Vector3d::UnitZ());
    there.q_WB = Eigen::Quaterniond(about_z) * Eigen::Quaterniond(body.q_WB);
    wanted_.effector.p_WE.z() = rules_.height;
    wanted_.effector.v_WE.setZero();
    std::fill(decision_.desired.begin(), decision_.desired.end(), wanted_);
    if (rolls(body)) {
      const Eigen::Vector2d step = ahead / parameters_.N * way;
      for (int k = 0; k <= parameters_.N; ++k) {
        scene::Body& rolling = decision_.desired[static_cast<std::size_t>(k)].body(goal.body);
        rolling.p_WB.head<2>() = body.p_WB.head<2>() + k * step;
        rolling.v_WB << step / parameters_.dt, 0.0;
      }
    }
    decision_.body_target << goal.at, body.p_WB.z();

    const model::Layout& layout = c3.model().layout();
    const double gain = gain_near_goal(way.norm(), turn);
    for (const auto& [name, values] : of_.weights.Q) {
      std::vector<double>& now = weights_.Q[name];
      const bool of_body = layout.bodies(name).front() >= 0;
      for (std::size_t i = 0; i < values.size(); ++i) now[i] = (of_body ? gain : 1.0) * values[i];
    }
    const c3::Costs costs = costs_of(c3.problem(), weights_);
    c3.replace_costs(costs_, costs);
    for (const auto& room : rooms_) room->set_costs(costs);
    decision_.costs = costs_;
  }

  /// Draws so many places, and looks what they are worth; and what another one is: where the end
  /// effector is, or where it goes.
  void draw(const Situation& now, int body, int count, const Eigen::Vector3d* other) {
    State& s = state_;
    tried_.clear();
    if (other != nullptr) tried_.push_back({*other, {}});
    for (int i = 0; i < count; ++i) {
      const auto place = surface_sample(now.scene, body, rules_, s.random);
      if (place) tried_.push_back({*place, {}});
    }
    s.drawn += count;
    for (std::size_t i = 0; i < tried_.size(); ++i) {
      scene::Scene from = decision_.x_hat;
      const bool stays = other == &now.input->effector.p_WE && i == 0;
      if (!stays) {
        from.effector.p_WE = tried_[i].p_WE;
        from.effector.v_WE.setZero();
      }
      tried_[i].worth = rooms_[i]->worth(from, decision_.desired);
    }
    const std::size_t first = other == nullptr ? 0 : 1;
    if (other == &now.input->effector.p_WE) s.here = tried_[0].worth;
    if (other == &s.target) s.there = tried_[0].worth;
    for (std::size_t i = first; i < tried_.size(); ++i) s.places.add(tried_[i]);
  }

  void move(const Situation& now, const Eigen::Vector3d& goal) {
    const Input& input = *now.input;
    const ApproachInput way{input.now, now.period, input.effector.p_WE, input.robot_follows};
    const double safe = state_.stage == Stage::kHold
                            ? parameters_.geometry.table_height + parameters_.approach.safe_height
                            : rules_.top;
    state_.way.step(way, now.scene, goal, safe);
    decision_.p_WE = state_.way.reference();
    decision_.v_WE = state_.way.velocity();
  }

  /// Beside the body that is at its goal.
  Eigen::Vector3d off(const scene::Scene& scene, int body) const {
    scene::Effector effector = scene.effector;
    effector.p_WE = state_.way.reference();
    const scene::Gap gap = scene::gap(effector, scene.body(body));
    if (gap.distance >= kOff) return effector.p_WE;
    Eigen::Vector3d out(gap.normal.x(), gap.normal.y(), 0.0);
    if (out.norm() < 0.1) return effector.p_WE;
    return effector.p_WE + (kOff - gap.distance) * out.normalized();
  }

  const Parameters parameters_;
  const SamplingParameters& of_;
  State state_;
  PhaseWeights weights_;  // of this period
  int costs_;
  SampleRules rules_{};
  std::vector<std::unique_ptr<Candidate>> rooms_;
  std::vector<Place> tried_;
  scene::Scene wanted_;
  Decision decision_;
};

}  // namespace

double gain_near_goal(double distance, double angle) {
  const double cost = distance * distance + kRadian * kRadian * angle * angle;
  return std::clamp(kNear / std::max(cost, 1e-12), 1.0, kMostGain);
}

std::unique_ptr<Strategy> make_sampling(const Parameters& parameters, C3Controller& c3) {
  return std::make_unique<Sampling>(parameters, c3);
}

}  // namespace c3rt::planner
