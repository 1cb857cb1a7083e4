#include "controller/planner/strategy/sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>

#include "controller/base/random.hpp"
#include "controller/planner/strategy/free_motion.hpp"
#include "controller/planner/strategy/places.hpp"
#include "controller/planner/strategy/surface_samples.hpp"
#include "controller/planner/strategy/task_at_hand.hpp"

namespace c3rt::planner {
namespace {

// what the plant draws from the same seed shall not be the same numbers
constexpr std::uint64_t kStream = 0xA24BAED4963EE407;
constexpr double kNear = 0.01, kMostGain = 30.0;  // of gain_near_goal(): [m²] where it begins
constexpr double kRadian = 0.22;                  // a radian counts as this [m]
constexpr double kThere = 0.5;                    // of the tolerances: it is moved no farther
constexpr double kAboveTop = 0.01;                // the end effector travels over bodies [m]
constexpr double kColumn = 2e-3;                  // beside the way straight down [m]
constexpr double kApart = 0.015;                  // another place is farther than this [m]
constexpr double kFree = 0.03;      // contacts farther apart begin free, see C3Controller [m]
constexpr double kLeaveBy = 0.015;  // what is at its goal is left by this [m]
constexpr double kUnmoved = 0.99;   // a body with more left than this part has not come nearer
// A body that is tilted by this is let go, before it falls onto another side [rad].
constexpr double kTilted = 0.1;
// What lies still and is promised nothing for so long, from where the end effector is, is left [s],
constexpr double kPatience = 0.1;
constexpr double kPatientPeriods = 2.5;  // and for more periods than this
// An arm that comes no nearer to a place by this part within this time cannot reach it [s].
constexpr double kArrivalPart = 0.02, kArrivalTime = 3.0;

enum class Stage { kWait, kHold, kChoose, kMove, kPush, kStand };

/// It goes on by itself, where others lie still.
bool rolls(const scene::Body& body) { return body.shape.kind == scene::ShapeKind::kSphere; }

FreeMotionParameters free_motion_of(const Parameters& parameters) {
  const SamplingParameters& sampling = parameters.sampling;
  return {sampling.speed, sampling.acceleration,
          sampling.clear, parameters.approach.leash,
          sampling.over,  {sampling.reach_min, sampling.reach_max}};
}

/// All that the strategy remembers from period to period.
struct State {
  explicit State(const Parameters& parameters)
      : task(parameters.task),
        way(free_motion_of(parameters)),
        places(parameters.sampling),
        headway(parameters.sampling.headway, parameters.sampling.headway_time),
        arrival(kArrivalPart, kArrivalTime),
        random(parameters.sampling.seed ^ kStream) {}
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
  int body = 0;                                      // beside which that is; it is worked on
  // when it came there: see left_of() [m²], and of the body which axis points upwards, in B
  double left_on_arrival = 0.0;
  double promised = 0.0;  // when it was last worth something to be where it is [s]
  Eigen::Vector3d up_on_arrival = Eigen::Vector3d::UnitZ();
  // within its tolerances since it was within a part of them
  std::array<bool, scene::kMaxBodies> settled{};
  Worth here, there;  // of this period
};

class Sampling final : public Strategy {
 public:
  Sampling(const Parameters& parameters, C3Controller& c3)
      : parameters_(parameters),
        of_(parameters_.sampling),
        state_(parameters),
        given_(of_.weights),
        weights_(given_),
        costs_(c3.add_costs(costs_of(c3.problem(), weights_))) {
    goals_.reserve(static_cast<std::size_t>(parameters.model.bodies));
    const Geometry& geometry = parameters.geometry;
    rules_.height = geometry.table_height + of_.height;
    rules_.clearance = of_.clearance;
    rules_.column = kColumn;
    rules_.reach = {of_.reach_min, of_.reach_max};
    rules_.reach_radius = of_.reach_radius;
    rules_.radian = kRadian;
    c3.start_from_free_gaps(kFree);
    // one for where the end effector is or goes to, and one for each place that is drawn
    for (int i = 0; i <= std::max(of_.samples, of_.samples_to_choose); ++i) {
      rooms_.push_back(std::make_unique<Candidate>(parameters, of_.servo));
      rooms_.back()->c3().start_from_free_gaps(kFree);
    }
    tried_.reserve(rooms_.size());
    froms_.resize(rooms_.size());
    costs_tried_.resize(rooms_.size());
    failures_.resize(rooms_.size());
    prepared_.reserve(rooms_.size() + 1);  // they stay where they are
    reset();
  }

  void reset() override {
    state_ = State(parameters_);
    decision_ = {};
    decision_.desired.resize(static_cast<std::size_t>(parameters_.N) + 1);
  }

  void set_weights(const Parameters& parameters, C3Controller& c3) override {
    const PhaseWeights& weights = parameters.sampling.weights;
    c3.replace_costs(costs_, costs_of(c3.problem(), weights));
    weights_ = given_ = weights;
  }

  const Decision& decide(const Situation& now, C3Controller& c3) override {
    const Input& input = *now.input;
    State& s = state_;
    s.task.take(input.target);
    const Stage before = s.stage;
    decision_.weighed.clear();
    if (ready(now)) {
      look(now.scene);
      want(now.scene);
      s.stage = next(now);
      decision_.costs = costs_;
      c3.replace_costs(costs_, costs_about(decision_.x_hat, c3));
    }
    decision_.body_lost = before == Stage::kPush && !now.available.all();
    decision_.body = s.body;
    decision_.cause = Cause::kNone;
    decision_.v_WE.setZero();
    const bool free = s.stage != Stage::kPush && s.stage != Stage::kWait;
    const bool was_free = before != Stage::kPush && before != Stage::kWait;
    if (s.stage != before) s.since = input.now;
    if ((free && !was_free) || now.interrupted)
      s.way.begin(input.effector.p_WE,
                  now.interrupted ? Eigen::Vector3d::Zero() : input.effector.v_WE);
    decision_.plans_with_c3 = s.stage == Stage::kPush;
    decision_.place.reset();
    if (s.stage == Stage::kMove || s.stage == Stage::kPush) decision_.place = s.target;
    switch (s.stage) {
      case Stage::kWait:
        decision_.mode = Mode::kWait;
        break;
      case Stage::kHold: {
        decision_.mode = Mode::kHold;
        if (s.task.done()) {
          decision_.cause = Cause::kAtTarget;
        } else if (std::holds_alternative<HoldTarget>(input.target)) {
          decision_.cause = Cause::kAsked;
        }
        const Eigen::Vector3d& at = s.way.reference();
        const double up = parameters_.geometry.table_height + parameters_.approach.safe_height;
        move(now, {at.x(), at.y(), of_.over ? std::max(up, at.z()) : at.z()});
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
        move(now, off(now.scene));
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
  /// A goal that is due, with its body.
  struct Due {
    int body;
    task::Goal goal;
  };

  /// Whether it can go about its task; else the stage is one of those without a body.
  bool ready(const Situation& now) {
    const Input& input = *now.input;
    State& s = state_;
    const bool asked = input.stopped || std::holds_alternative<HoldTarget>(input.target);
    find_goals(now);
    bool ready = now.available.state() && !asked && !goals_.empty() && now.available.all() &&
                 !now.robot_left;
    if (ready) {
      const int behind = s.task.goals_behind();
      s.task.advance(input.now, now.scene);
      ready = !s.task.done();
      find_goals(now);
      if (s.task.goals_behind() != behind) {
        s.places.clear();  // what a place was worth was for another goal
        if (s.stage == Stage::kMove || s.stage == Stage::kPush) s.stage = choose();
      }
    }
    if (!ready) s.stage = now.available.state() ? Stage::kHold : Stage::kWait;
    return ready;
  }

  /// Of a task without goals where the first body should be next, which it never reaches.
  void find_goals(const Situation& now) {
    goals_.clear();
    for (int i = 0; i < parameters_.model.bodies; ++i) {
      const std::optional<task::Goal> goal = state_.task.goal(i);
      if (goal) goals_.push_back({i, *goal});
    }
    if (goals_.empty() && now.scene.body_count > 0) {
      const Eigen::Vector2d at = state_.task.target(now.scene, 0, now.input->now, 0.0);
      goals_.push_back({0, {at, std::nullopt, 0.0, 0.0}});
    }
    const auto worked_on = [&](const Due& due) { return due.body == state_.body; };
    if (!goals_.empty() && std::none_of(goals_.begin(), goals_.end(), worked_on))
      state_.body = goals_.front().body;
  }

  const task::Goal& goal_of(int body) const {
    return std::find_if(goals_.begin(), goals_.end(),
                        [&](const Due& due) { return due.body == body; })
        ->goal;
  }

  /// What has settled at its goal, and which places still count.
  void look(const scene::Scene& scene) {
    State& s = state_;
    work_.clear();
    for (const auto& [i, goal] : goals_) {
      const scene::Body& body = scene.body(i);
      bool& settled = s.settled[static_cast<std::size_t>(i)];
      settled = within(body, goal, settled ? 1.0 : kThere);
      s.places.look(i, body);
      if (settled) s.places.forget(i);
      if (!settled) work_.push_back(i);
    }
    // all are, but for what only the task sees
    if (work_.empty() && !s.task.reached()) {
      for (const Due& due : goals_) work_.push_back(due.body);
    }
    rules_.top = of_.over ? top_of(scene) + scene.effector.radius + kAboveTop : rules_.height;
  }

  Stage next(const Situation& now) {
    const Input& input = *now.input;
    State& s = state_;
    if (work_.empty()) return Stage::kStand;
    const Eigen::Vector3d& p_WE = input.effector.p_WE;
    const double left = left_of(now.scene.body(s.body), goal_of(s.body));
    const bool works = s.stage == Stage::kMove || s.stage == Stage::kPush;
    if (works && std::find(work_.begin(), work_.end(), s.body) == work_.end()) return choose();
    switch (s.stage) {
      case Stage::kWait:
      case Stage::kHold:
      case Stage::kStand:
        return choose();
      case Stage::kChoose: {
        draw(now, work_, of_.samples_to_choose, nullptr);
        const Place* best = s.places.best(p_WE, 0.0);
        if (s.drawn < of_.least_drawn * static_cast<int>(work_.size())) return Stage::kChoose;
        if (best == nullptr) {
          // all that could be of use have failed: better once more than to stand
          for (const int body : work_) s.places.forget(body);
          return choose();
        }
        return move_to(*best, now);
      }
      case Stage::kMove: {
        // what rolls takes the place with it, and the way there
        Eigen::Vector3d carried = now.period * decision_.x_hat.body(s.body).v_WB;
        carried.z() = 0.0;
        s.target += carried;
        s.way.carry(carried);
        draw(now, {s.body}, of_.samples, &s.target);
        const Place* best = s.places.best_of(s.body, s.target, kApart);
        if (best != nullptr && best->worth.cost < of_.retarget * s.there.cost) move_to(*best, now);
        const double away = (p_WE - s.target).norm();
        if (!s.way.there() || away > parameters_.approach.tolerance) {
          if (!s.way.blocked() && s.arrival.made(input.now, away)) return Stage::kMove;
          s.places.fail(s.body, s.target);
          const bool wedged = s.way.blocked() && nearest_gap(now.scene, p_WE).distance < of_.clear;
          if (!wedged) return choose();
        }
        // also where it is wedged: what it touches has to move
        s.headway.begin(input.now, left);
        s.promised = input.now;
        s.left_on_arrival = left;
        s.up_on_arrival = now.scene.body(s.body).q_WB.conjugate() * Eigen::Vector3d::UnitZ();
        return Stage::kPush;
      }
      case Stage::kPush: {
        // one body is finished before another, as a way between them takes time
        draw(now, {s.body}, of_.samples, &p_WE);
        // nor is it where there is no plan, or only one that pushes a body out of reach
        const scene::Body& body = now.scene.body(s.body);
        if (rolls(body) || s.here.gain() > of_.margin * s.here.still) s.promised = input.now;
        const bool made =
            s.headway.made(input.now, left) && s.here.known && !tilted(body) &&
            input.now - s.promised < std::max(kPatience, kPatientPeriods * now.period);
        if (!made) s.places.fail(s.body, p_WE);
        const auto best = [&] { return s.places.best_of(s.body, p_WE, kApart); };
        const bool leaves = !made || (input.now - s.since >= of_.least_time && best() != nullptr &&
                                      worth_leaving(of_, s.here, best()->worth));
        if (!leaves) return Stage::kPush;
        // else two places that each promise more than the other keeps take turns for ever
        if (left > kUnmoved * s.left_on_arrival) s.places.fail(s.body, s.target);
        if (best() == nullptr || (!made && work_.size() > 1)) return choose();
        return move_to(*best(), now);
      }
    }
    return Stage::kHold;
  }

  Stage move_to(const Place& place, const Situation& now) {
    const Input& input = *now.input;
    state_.target = place.p_WE;
    state_.body = place.body;
    state_.arrival.begin(input.now, (input.effector.p_WE - place.p_WE).norm());
    return Stage::kMove;
  }

  Stage choose() {
    state_.drawn = 0;
    return Stage::kChoose;
  }

  bool tilted(const scene::Body& body) const {
    const double up = (body.q_WB * state_.up_on_arrival).z();
    return !rolls(body) && up < std::cos(kTilted);
  }

  double left_of(const scene::Body& body, const task::Goal& goal) const {
    const double turn = kRadian * goal.turn_about_z(body);
    return (goal.at - body.p_WB.head<2>()).squaredNorm() + turn * turn;
  }

  bool within(const scene::Body& body, const task::Goal& goal, double part) const {
    return (goal.at - body.p_WB.head<2>()).norm() < part * goal.position_tolerance &&
           std::abs(goal.turn_about_z(body)) < part * goal.angle_tolerance;
  }

  /// The part of a way that can be looked ahead.
  double ahead(const Eigen::Vector2d& way) const {
    return std::min(1.0, of_.look_ahead / std::max(way.norm(), 1e-9));
  }

  /// Algorithm 3, step 1, and what is wanted at each stage: no body farther than can be looked
  /// ahead, and one without a goal where it is.
  void want(const scene::Scene& scene) {
    decision_.x_hat = scene;
    for (int i = 0; i < scene.body_count; ++i) {
      scene::Body& body = decision_.x_hat.body(i);
      if (rolls(body)) continue;
      // what lies on the table moves no farther than it is pushed; its measured velocity is noise
      body.v_WB.setZero();
      body.omega_WB.setZero();
    }
    wanted_ = decision_.x_hat;
    gains_.fill(1.0);
    prepared_.clear();
    for (const auto& [i, goal] : goals_) {
      const scene::Body& body = decision_.x_hat.body(i);
      const Eigen::Vector2d way = goal.at - body.p_WB.head<2>();
      const double turn = goal.turn_about_z(body);
      scene::Body& there = wanted_.body(i);
      there.p_WB.head<2>() += ahead(way) * way;
      const double turned = std::clamp(turn, -of_.look_ahead_angle, of_.look_ahead_angle);
      const Eigen::AngleAxisd about_z(turned, Eigen::Vector3d::UnitZ());
      there.q_WB = Eigen::Quaterniond(about_z) * Eigen::Quaterniond(body.q_WB);
      Eigen::Vector3d& moves = moves_wanted_[static_cast<std::size_t>(i)];
      moves << ahead(way) * way, kRadian * turned;
      // what rolls goes on by itself: where it is to rest, a push against its way may be what it
      // needs
      if (rolls(body) && goal.position_tolerance > 0.0) moves.setZero();
      gains_[static_cast<std::size_t>(i)] = gain_near_goal(way.norm(), turn);
      if (i == state_.body) decision_.body_target << goal.at, body.p_WB.z();
    }
    wanted_.effector.p_WE.z() = rules_.height;
    wanted_.effector.v_WE.setZero();
    std::fill(decision_.desired.begin(), decision_.desired.end(), wanted_);
    for (const Due& due : goals_) {
      const scene::Body& body = decision_.x_hat.body(due.body);
      if (!rolls(body)) continue;
      const Eigen::Vector2d way = due.goal.at - body.p_WB.head<2>();
      const Eigen::Vector2d step = ahead(way) / parameters_.N * way;
      for (int k = 0; k <= parameters_.N; ++k) {
        scene::Body& rolling = decision_.desired[static_cast<std::size_t>(k)].body(due.body);
        rolling.p_WB.head<2>() = body.p_WB.head<2>() + k * step;
        rolling.v_WB << step / parameters_.dt, 0.0;
      }
    }
  }

  /// Of this period, with more weight on a body that is near its goal.
  const c3::Costs& costs_about(const scene::Scene& scene, const C3Controller& c3) {
    const model::PlanningModel& model = c3.model();
    const model::Layout& layout = model.layout();
    std::array<int, scene::kMaxBodies> bodies{};
    for (const model::StateBlock& block : layout.x) {
      if (block.body >= 0)
        bodies[static_cast<std::size_t>(block.body)] = model.body(block.body, scene);
    }
    for (const auto& [of, costs] : prepared_) {
      if (of == bodies) return costs;
    }
    for (const auto& [name, values] : given_.Q) {
      std::vector<double>& now = weights_.Q[name];
      now.clear();
      for (const int i : layout.bodies(name)) {
        if (i < 0) {
          now = values;
          break;
        }
        const auto of = static_cast<std::size_t>(i);
        const auto body = static_cast<std::size_t>(bodies[of]);
        now.push_back(gains_[body] * values.at(values.size() == 1 ? 0 : of));
      }
    }
    prepared_.emplace_back(bodies, costs_of(c3.problem(), weights_));
    return prepared_.back().second;
  }

  /// Draws so many places beside these bodies in turn, and looks what they are worth; and what
  /// another one is: where the end effector is, or where it goes.
  void draw(const Situation& now, const std::vector<int>& bodies, int count,
            const Eigen::Vector3d* other) {
    State& s = state_;
    tried_.clear();
    if (other != nullptr) tried_.push_back({*other, {}, s.body});
    for (int i = 0; i < count; ++i, ++s.drawn) {
      const int body = bodies[static_cast<std::size_t>(s.drawn) % bodies.size()];
      rules_.wanted = moves_wanted_[static_cast<std::size_t>(body)];
      const auto place = surface_sample(now.scene, body, rules_, s.random);
      if (place) tried_.push_back({*place, {}, body});
    }
    for (std::size_t i = 0; i < tried_.size(); ++i) {
      scene::Scene& from = froms_[i];
      from = decision_.x_hat;
      const bool stays = other == &now.input->effector.p_WE && i == 0;
      if (!stays) {
        from.effector.p_WE = tried_[i].p_WE;
        from.effector.v_WE.setZero();
      }
      costs_tried_[i] = &costs_about(from, rooms_[i]->c3());
    }
    try_all(now.parallel);
    const std::size_t first = other == nullptr ? 0 : 1;
    if (other == &now.input->effector.p_WE) s.here = tried_[0].worth;
    if (other == &s.target) s.there = tried_[0].worth;
    for (std::size_t i = first; i < tried_.size(); ++i) s.places.add(tried_[i]);
    for (const Place& place : tried_) {
      const Worth& worth = place.worth;
      decision_.weighed.push_back({place.p_WE, place.body, worth.known, worth.cost, worth.still});
    }
  }

  /// What is drawn is worth, each in a room of its own: the same whatever thread does it.
  void try_all(const c3::Parallel& parallel) {
    const auto count = static_cast<int>(tried_.size());
    const auto one = [](void* context, int index, int) noexcept {
      auto& self = *static_cast<Sampling*>(context);
      const auto i = static_cast<std::size_t>(index);
      self.failures_[i] = nullptr;
      try {
        self.tried_[i].worth =
            self.rooms_[i]->worth(*self.costs_tried_[i], self.froms_[i], self.decision_.desired);
      } catch (...) {
        self.failures_[i] = std::current_exception();
      }
    };
    if (parallel.run != nullptr) {
      parallel.run(parallel.pool, count, one, this);
    } else {
      for (int i = 0; i < count; ++i) one(this, i, 0);
    }
    for (std::size_t i = 0; i < tried_.size(); ++i) {
      if (failures_[i]) std::rethrow_exception(failures_[i]);
    }
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

  /// Beside the bodies that are at their goals.
  Eigen::Vector3d off(const scene::Scene& scene) const {
    const Eigen::Vector3d& p_WE = state_.way.reference();
    const scene::Gap gap = nearest_gap(scene, p_WE);
    if (gap.distance >= kLeaveBy) return p_WE;
    Eigen::Vector3d out(gap.normal.x(), gap.normal.y(), 0.0);
    if (out.norm() < 0.1) return p_WE;
    return p_WE + (kLeaveBy - gap.distance) * out.normalized();
  }

  const Parameters parameters_;
  const SamplingParameters& of_;
  State state_;
  PhaseWeights given_;    // by the scenario or a client
  PhaseWeights weights_;  // of this period
  int costs_;
  SampleRules rules_{};
  std::vector<std::unique_ptr<Candidate>> rooms_;
  std::vector<Place> tried_;
  std::vector<scene::Scene> froms_;            // of each that is tried: with the end effector there
  std::vector<const c3::Costs*> costs_tried_;  // and by what it is judged
  std::vector<std::exception_ptr> failures_;
  // of this period: goals that are due, bodies that have to be moved, what is wanted of all
  std::vector<Due> goals_;
  std::vector<int> work_;
  scene::Scene wanted_;
  std::array<Eigen::Vector3d, scene::kMaxBodies> moves_wanted_{};  // SampleRules::wanted of each
  std::array<double, scene::kMaxBodies> gains_{};
  // costs by the bodies that the model has
  std::vector<std::pair<std::array<int, scene::kMaxBodies>, c3::Costs>> prepared_;
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
