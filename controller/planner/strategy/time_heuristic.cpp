#include "controller/planner/strategy/time_heuristic.hpp"

#include <algorithm>
#include <cmath>

#include "controller/scene/scene.hpp"

namespace c3rt::planner {
namespace {

constexpr double kHeightDoubt = 5e-4;  // of the cameras, of a sphere [m]
// When the end effector is on a sphere: between their surfaces, and beside the sphere's top [m].
constexpr double kOnSphereGap = 1.5e-3;
constexpr double kOnSphereBeside = 0.025 / 0.0315;  // of its radius
constexpr double kStoppingLimit = 8.0;  // a sphere that is not at rest after this is left [s]
constexpr double kStoppingRate = 1.0;   // of a sphere below an end effector that brakes [m/s²]
// A sphere that stops this near to its point is carried there [m]
constexpr double kNearPoint = 0.01;
constexpr double kAstray = 6e-3;     // and one that is farther away than this [m]
constexpr double kAstrayTime = 0.3;  // for this long is brought back [s]

// The tool points down; the tilt leans it about the axis (e_y, −e_x, 0).
Eigen::Quaterniond tool_orientation(double tilt, const Eigen::Vector2d& e) {
  Eigen::Quaterniond down(0.0, 1.0, 0.0, 0.0);
  if (tilt == 0.0 || e.norm() < 1e-9) return down;
  const Eigen::Vector2d direction = e.normalized();
  return Eigen::AngleAxisd(tilt, Eigen::Vector3d(direction.y(), -direction.x(), 0.0)) * down;
}

// No farther away than a pace.
Eigen::Vector2d paced(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double pace) {
  const Eigen::Vector2d way = to - from;
  if (way.norm() <= pace) return to;
  return from + pace * way.normalized();
}

// How far a sphere that nobody touches gets in a time.
Eigen::Vector2d rolled_on(const scene::Body& sphere, double time) {
  return time * sphere.v_WB.head<2>() + 0.5 * time * time * sphere.a_WB;
}

Mode told(TimeHeuristicMode mode) {
  switch (mode) {
    case TimeHeuristicMode::kWait:
      return Mode::kWait;
    case TimeHeuristicMode::kApproach:
      return Mode::kApproach;
    case TimeHeuristicMode::kRoll:
    case TimeHeuristicMode::kReturn:
      return Mode::kTask;
    case TimeHeuristicMode::kRest:
      return Mode::kRest;
    case TimeHeuristicMode::kHold:
      return Mode::kHold;
  }
  return Mode::kHold;
}

bool in_c3(TimeHeuristicMode mode) {
  return mode == TimeHeuristicMode::kRoll || mode == TimeHeuristicMode::kReturn;
}

}  // namespace

TimeHeuristicMode next(TimeHeuristicMode mode, const Known& known) {
  if (!known.state_fresh) return TimeHeuristicMode::kWait;
  if (known.hold_requested) return TimeHeuristicMode::kHold;
  if (mode == TimeHeuristicMode::kRest && known.sphere_left) return TimeHeuristicMode::kHold;
  if (known.rest_wanted) return TimeHeuristicMode::kRest;
  if (!known.spheres_at_hand) return TimeHeuristicMode::kHold;
  switch (mode) {
    case TimeHeuristicMode::kWait:
    case TimeHeuristicMode::kHold:
      return TimeHeuristicMode::kApproach;
    case TimeHeuristicMode::kRest:
      return known.robot_left ? TimeHeuristicMode::kApproach : TimeHeuristicMode::kReturn;
    case TimeHeuristicMode::kApproach:
      return known.start_pose_reached ? TimeHeuristicMode::kReturn : TimeHeuristicMode::kApproach;
    case TimeHeuristicMode::kRoll:
    case TimeHeuristicMode::kReturn:
      if (known.other_sphere || known.robot_left) return TimeHeuristicMode::kApproach;
      return known.returning ? TimeHeuristicMode::kReturn : TimeHeuristicMode::kRoll;
  }
  return TimeHeuristicMode::kHold;
}

TimeHeuristicState::TimeHeuristicState(const Parameters& parameters)
    : task(parameters.task),
      approach(parameters.approach, parameters.geometry.table_height),
      rest(parameters.geometry.end_effector_radius, parameters.approach.leash) {}

TimeHeuristic::TimeHeuristic(const Parameters& parameters, C3Controller& c3)
    : parameters_(parameters), state_(parameters) {
  for (int active = 0; active < parameters.model.bodies; ++active) {
    back_.push_back(c3.add_costs(costs_of(c3.problem(), parameters.back, active)));
    roll_.push_back(c3.add_costs(costs_of(c3.problem(), parameters.roll, active)));
  }
  reset();
}

void TimeHeuristic::reset() {
  state_ = TimeHeuristicState(parameters_);
  decision_ = {};
  decision_.desired.resize(static_cast<std::size_t>(parameters_.N) + 1);
}

void TimeHeuristic::set_weights(const Parameters& parameters, C3Controller& c3) {
  for (std::size_t active = 0; active < roll_.size(); ++active) {
    const int body = static_cast<int>(active);
    c3.replace_costs(back_[active], costs_of(c3.problem(), parameters.back, body));
    c3.replace_costs(roll_[active], costs_of(c3.problem(), parameters.roll, body));
  }
}

const Decision& TimeHeuristic::decide(const Situation& now, C3Controller&) {
  const Input& input = *now.input;
  const bool was_in_c3 = in_c3(state_.mode);
  advance_phase(input.now, now.scene, was_in_c3 && state_.c3_since >= 0.0);
  state_.task.take(input.target);
  Known known{};
  known.state_fresh = now.available.state();
  known.spheres_at_hand = now.available.all();
  known.robot_left = now.robot_left;
  known.start_pose_reached = state_.approach.settled(input.now);
  known.returning = state_.phase != Phase::kRoll;
  // one sphere for a whole cycle: half-way to another one nothing is gained
  const int worked = state_.sphere;
  const bool cycle_ended = state_.mode == TimeHeuristicMode::kRoll && state_.phase != Phase::kRoll;
  const bool stopping = std::holds_alternative<HoldTarget>(input.target);
  if (known.spheres_at_hand && !stopping &&
      (state_.mode == TimeHeuristicMode::kWait || state_.mode == TimeHeuristicMode::kHold ||
       cycle_ended)) {
    state_.sphere =
        sphere_to_work_on(parameters_.heuristic, state_.task.task(), now.scene, state_.sphere);
  }
  known.other_sphere = was_in_c3 && state_.sphere != worked;
  decide_rest(now, known);

  const TimeHeuristicMode previous = state_.mode;
  state_.mode = next(state_.mode, known);
  decision_.body_lost = false;
  if (state_.mode != previous || now.interrupted) {
    if (state_.mode == TimeHeuristicMode::kApproach || state_.mode == TimeHeuristicMode::kHold)
      state_.approach.begin(input.effector.p_WE);
    if (state_.mode == TimeHeuristicMode::kRest) state_.rest.begin(rest_input(now));
    if (!was_in_c3 && state_.mode == TimeHeuristicMode::kReturn) {
      state_.c3_since = input.now;
      state_.phase = phase_at(parameters_.heuristic, 0.0);
    }
    decision_.body_lost = was_in_c3 && !known.spheres_at_hand;
  }

  decision_.mode = told(state_.mode);
  decision_.phase = state_.mode == TimeHeuristicMode::kRoll ? "roll" : "return";
  decision_.body = state_.sphere;
  decision_.cause = cause(input);
  decision_.plans_with_c3 = in_c3(state_.mode);
  decision_.force_bias.setZero();
  if (decision_.plans_with_c3) {
    state_.task.begin(input.now);
    move_with_c3(now);
  } else {
    move_without_c3(now);
  }
  return decision_;
}

void TimeHeuristic::move_without_c3(const Situation& now) {
  const Input& input = *now.input;
  const ApproachInput way{input.now, now.period, input.effector.p_WE, input.robot_follows};
  decision_.q_WE = tool_orientation(0.0, Eigen::Vector2d::Zero());
  decision_.v_WE.setZero();
  switch (state_.mode) {
    case TimeHeuristicMode::kRest:
      state_.rest.step(rest_input(now));
      decision_.p_WE = state_.rest.reference();
      decision_.v_WE = state_.rest.velocity();
      decision_.force_bias.z() = state_.rest.press();
      break;
    case TimeHeuristicMode::kHold:
      state_.approach.out_of_the_way(way);
      decision_.p_WE = state_.approach.reference();
      break;
    case TimeHeuristicMode::kApproach: {
      const Eigen::Vector3d& p_WB = input.bodies[static_cast<std::size_t>(state_.sphere)].body.p_WB;
      state_.approach.to_body(way, p_WB);
      decision_.p_WE = state_.approach.reference();
      decision_.v_WE = state_.approach.velocity();
      decision_.body_target << target(input, 0.0, now.scene, state_.sphere), p_WB.z();
      break;
    }
    case TimeHeuristicMode::kWait:
    case TimeHeuristicMode::kRoll:
    case TimeHeuristicMode::kReturn:
      break;
  }
}

void TimeHeuristic::move_with_c3(const Situation& now) {
  const Input& input = *now.input;
  decision_.x_hat = now.scene;
  scene::Scene& x_hat = decision_.x_hat;
  decision_.raised = parameters_.table_below_object ? lowered(x_hat) : 0.0;
  const scene::Scene seen = x_hat;
  const Eigen::Vector2d target_now = target(input, 0.0, seen, state_.sphere);
  const Eigen::Vector2d e = target_now - x_hat.body(state_.sphere).p_WB.head<2>();

  // Algorithm 3, step 1: x̂
  if (parameters_.separate_overlap) {
    for (int i = 0; i < x_hat.body_count; ++i) {
      scene::Body& sphere = x_hat.body(i);
      const Eigen::Vector2d way = target(input, 0.0, seen, i) - sphere.p_WB.head<2>();
      scene::separate(x_hat.effector, Eigen::Vector3d(way.x(), way.y(), 0.0), sphere);
    }
  }
  const scene::Body& rolled = x_hat.body(state_.sphere);
  const bool rolling = state_.phase == Phase::kRoll;
  const bool follows = !rolling && parameters_.heuristic.return_follows;
  Eigen::Vector3d meeting = rolled.p_WB;
  if (!rolling && !follows)
    meeting.head<2>() += rolled_on(rolled, parameters_.heuristic.return_lead);
  const Eigen::Vector3d drawn =
      end_effector_target(parameters_.heuristic, parameters_.geometry, state_.phase,
                          x_hat.effector.p_WE, rolled.shape.radius, meeting, target_now);

  // what is wanted: the spheres at their targets and the end effector where the heuristic draws it
  for (int k = 0; k <= parameters_.N; ++k) {
    const double ahead = k * parameters_.dt;
    scene::Scene& desired = decision_.desired[static_cast<std::size_t>(k)];
    desired.body_count = x_hat.body_count;
    desired.effector.p_WE = drawn;
    if (follows) {
      desired.effector.p_WE.head<2>() +=
          rolled_on(rolled, parameters_.heuristic.return_lead + ahead);
    }
    for (int i = 0; i < x_hat.body_count; ++i) {
      scene::Body& sphere = desired.body(i);
      const double radius = x_hat.body(i).shape.radius;
      sphere.p_WB << target(input, ahead, seen, i), height(x_hat.body(i));
      const Eigen::Vector2d v = state_.task.velocity(input.now, ahead);
      sphere.v_WB << v, 0.0;
      // rolling without slipping
      sphere.omega_WB << -v.y() / radius, v.x() / radius, 0.0;
    }
  }
  decision_.body_target << target_now, height(rolled);
  decision_.q_WE = tool_orientation(parameters_.tilt, e);
  decision_.costs = (rolling ? roll_ : back_)[static_cast<std::size_t>(state_.sphere)];
  // A plan that stands on the sphere does not hold it: over a tenth of a millimetre of gap, which
  // the cameras cannot tell from contact, no force acts.
  if (rolling) decision_.force_bias.z() = parameters_.heuristic.roll_press;
}

Cause TimeHeuristic::cause(const Input& input) const {
  if (std::holds_alternative<HoldTarget>(input.target))
    return state_.not_brought_to_rest ? Cause::kNotBroughtToRest : Cause::kAsked;
  return state_.delivered ? Cause::kAtTarget : Cause::kNone;
}

RestInput TimeHeuristic::rest_input(const Situation& now) const {
  const Input& input = *now.input;
  const scene::Body& sphere = now.scene.body(state_.sphere);
  return {input.now,
          now.period,
          input.effector.p_WE,
          input.effector.v_WE,
          in_view(parameters_, input.bodies[static_cast<std::size_t>(state_.sphere)]),
          sphere.shape.radius,
          sphere.p_WB,
          sphere.v_WB,
          resting_place(input)};
}

std::optional<Eigen::Vector2d> TimeHeuristic::resting_place(const Input& input) const {
  const std::optional<task::Goal> goal = state_.task.goal(state_.sphere);
  if (!goal || std::holds_alternative<HoldTarget>(input.target)) return std::nullopt;
  return goal->at;
}

void TimeHeuristic::decide_rest(const Situation& now, Known& known) {
  const Input& input = *now.input;
  TimeHeuristicState& s = state_;
  const scene::Body& sphere = now.scene.body(s.sphere);
  const bool seen = in_view(parameters_, input.bodies[static_cast<std::size_t>(s.sphere)]);
  // what is not seen is where it was: an end effector that stood on it still does
  if (seen) {
    s.task.advance(input.now, now.scene);
    const double gap = scene::gap(now.scene.effector, sphere).distance;
    const double beside = (now.scene.effector.p_WE - sphere.p_WB).head<2>().norm();
    s.on_sphere = gap < kOnSphereGap && beside < kOnSphereBeside * sphere.shape.radius;
  }
  const bool working = in_c3(s.mode) || s.mode == TimeHeuristicMode::kRest;

  const bool hold = std::holds_alternative<HoldTarget>(input.target);
  if (!hold) {
    s.stopping_since = -1.0;
    s.not_brought_to_rest = false;
  } else if (working && s.stopping_since < 0.0) {
    s.stopping_since = input.now;
  }
  if (hold && working && input.now - s.stopping_since > kStoppingLimit)
    s.not_brought_to_rest = true;

  const std::optional<Eigen::Vector2d> to = resting_place(input);
  bool delivers = false;
  if (!to || (s.delivered && *s.delivered != *to)) {
    s.delivered.reset();
  } else if (s.delivered) {
    const bool astray = seen && (sphere.p_WB.head<2>() - *to).norm() > kAstray;
    if (!astray) s.astray_since = input.now;
    if (input.now - s.astray_since > kAstrayTime) s.delivered.reset();
  }
  if (to && !s.delivered && known.spheres_at_hand) {
    const Eigen::Vector2d v = sphere.v_WB.head<2>();
    const Eigen::Vector2d stops = sphere.p_WB.head<2>() + v * v.norm() / kStoppingRate;
    delivers = s.mode == TimeHeuristicMode::kRest || (stops - *to).norm() < kNearPoint;
  }

  const Rest::Stage stage = s.rest.stage();
  if (s.mode == TimeHeuristicMode::kRest) {
    known.rest_wanted =
        stage != Rest::Stage::kFailed && (hold || delivers || !known.spheres_at_hand);
    known.sphere_left = stage == Rest::Stage::kLeft;
  } else if (working) {
    known.rest_wanted =
        hold || delivers ||
        (s.mode == TimeHeuristicMode::kRoll && s.on_sphere && !known.spheres_at_hand);
  } else {
    known.rest_wanted =
        delivers && s.mode == TimeHeuristicMode::kHold;  // it has crept away a little
  }
  const bool there = to && seen && (sphere.p_WB.head<2>() - *to).norm() < kAstray;
  if (known.sphere_left && delivers && there) {
    s.delivered = *to;
    s.astray_since = input.now;
  }
  known.hold_requested = input.stopped || (hold && (!working || s.not_brought_to_rest)) ||
                         (s.delivered && s.mode == TimeHeuristicMode::kHold);
  if (known.robot_left) {
    known.rest_wanted = false;
    known.hold_requested = known.hold_requested || hold;
  }
}

void TimeHeuristic::advance_phase(double now, const scene::Scene& scene, bool in_c3) {
  TimeHeuristicState& s = state_;
  s.phase = phase_at(parameters_.heuristic, in_c3 ? now - s.c3_since : 0.0);
  if (!in_c3 || s.phase != Phase::kRoll) {
    s.touched = false;
    return;
  }
  const Eigen::Vector3d& p_WB = scene.body(s.sphere).p_WB;
  const double gap = scene::gap(scene.effector, scene.body(s.sphere)).distance;
  s.touched = s.touched || gap < 0.5 * parameters_.heuristic.return_gap;
  const bool slipped_off =
      (scene.effector.p_WE - p_WB).head<2>().norm() > parameters_.heuristic.roll_reach;
  if ((s.touched && gap > parameters_.heuristic.return_gap) || slipped_off) {
    s.c3_since = now;
    s.phase = Phase::kReturnUp;
  }
}

double TimeHeuristic::height(const scene::Body& sphere) const {
  return parameters_.geometry.table_height + sphere.shape.radius;
}

double TimeHeuristic::lowered(scene::Scene& scene) const {
  const scene::Body& worked = scene.body(state_.sphere);
  double rise = worked.p_WB.z() - height(worked);
  // A sphere that is seen too high would be planned to hold the end effector up, and the press on
  // it, some newtons a millimetre, be lost: where the two seem to overlap, the table is lower by as
  // much.
  const double touching = worked.shape.radius + scene.effector.radius;
  const Eigen::Vector3d above = scene.effector.p_WE - worked.p_WB;
  const double over_square = touching * touching - above.head<2>().squaredNorm();
  if (over_square > 0.0 && above.z() > 0.0) {
    const double overlap = std::sqrt(over_square) - above.z();
    rise -= std::min(std::max(overlap, 0.0), kHeightDoubt);
  }
  scene.effector.p_WE.z() -= rise;
  for (scene::Body& sphere : scene.bodies) sphere.p_WB.z() -= rise;
  return rise;
}

Eigen::Vector2d TimeHeuristic::target(const Input& input, double ahead, const scene::Scene& scene,
                                      int sphere) const {
  const Eigen::Vector2d at = scene.body(sphere).p_WB.head<2>();
  const double reach = parameters_.heuristic.target_reach;
  const bool near = state_.task.clients() || state_.task.goal(sphere);
  return paced(at, state_.task.target(scene, sphere, input.now, ahead),
               near ? std::min(reach, kTargetPace) : reach);
}

std::unique_ptr<Strategy> make_time_heuristic(const Parameters& parameters, C3Controller& c3) {
  return std::make_unique<TimeHeuristic>(parameters, c3);
}

}  // namespace c3rt::planner
