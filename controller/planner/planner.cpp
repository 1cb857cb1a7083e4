#include "controller/planner/planner.hpp"

#include <algorithm>
#include <cmath>

#include "controller/model/ball_model.hpp"
#include "controller/task/circle.hpp"

namespace c3rt::planner {
namespace {

constexpr double kHeightDoubt = 5e-4;  // of the cameras, of a ball [m]
constexpr double kStateTimeout = 0.1;  // [s]
// Without plans, or without a robot that follows them, for this long: what was going on is over
// [s].
constexpr double kLeft = 0.2;
// When the end effector is on a ball: between their surfaces, and beside the ball's top [m].
constexpr double kOnBallGap = 1.5e-3;
constexpr double kOnBallBeside = 0.025 / 0.0315;  // of its radius
constexpr double kStoppingLimit = 8.0;  // a ball that is not at rest after this is left [s]
constexpr double kStoppingRate = 1.0;   // of a ball below an end effector that brakes [m/s²]
constexpr double kNearPoint =
    0.01;                         // a ball that stops this near to its point is carried there [m]
constexpr double kAstray = 6e-3;  // and one that is farther away than this [m]
constexpr double kAstrayTime = 0.3;  // for this long is brought back [s]

// The tool points down; the tilt leans it about the axis (e_y, −e_x, 0).
Eigen::Quaterniond tool_orientation(double tilt, const Eigen::Vector2d& e) {
  const Eigen::Quaterniond down(0.0, 1.0, 0.0, 0.0);
  if (tilt == 0.0 || e.norm() < 1e-9) return down;
  const Eigen::Vector2d direction = e.normalized();
  return Eigen::AngleAxisd(tilt, Eigen::Vector3d(direction.y(), -direction.x(), 0.0)) * down;
}

bool finite(const scene::Body& ball) {
  return ball.p_WB.allFinite() && ball.v_WB.allFinite() && ball.omega_WB.allFinite() &&
         ball.q_WB.coeffs().allFinite();
}

bool within(const ApproachParameters& reach, const Eigen::Vector2d& ball) {
  return (ball.array() >= reach.reach_min.array()).all() &&
         (ball.array() <= reach.reach_max.array()).all();
}

bool of_state(Cause cause) {
  return cause == Cause::kNoState || cause == Cause::kStateLate || cause == Cause::kStateNotFinite;
}

// Between the surfaces of end effector and ball [m].
double gap_between(const Geometry& geometry, const scene::Scene& scene, int ball) {
  const double distance = (scene.body(ball).p_WB - scene.effector.p_WE).norm();
  return distance - geometry.ball_radius - geometry.end_effector_radius;
}

// No farther away than a pace.
Eigen::Vector2d paced(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double pace) {
  const Eigen::Vector2d way = to - from;
  if (way.norm() <= pace) return to;
  return from + pace * way.normalized();
}

// How far a ball that nobody touches gets in a time.
Eigen::Vector2d rolled_on(const scene::Body& ball, double time) {
  return time * ball.v_WB.head<2>() + 0.5 * time * time * ball.a_WB;
}

}  // namespace

Mode next(Mode mode, const Situation& situation) {
  if (!situation.state_fresh) return Mode::kWait;
  if (situation.hold_requested) return Mode::kHold;
  if (mode == Mode::kRest && situation.ball_left) return Mode::kHold;
  if (situation.rest_wanted) return Mode::kRest;
  if (!situation.balls_at_hand) return Mode::kHold;
  switch (mode) {
    case Mode::kWait:
    case Mode::kHold:
      return Mode::kApproach;
    case Mode::kRest:
      return situation.robot_left ? Mode::kApproach : Mode::kReturn;
    case Mode::kApproach:
      return situation.start_pose_reached ? Mode::kReturn : Mode::kApproach;
    case Mode::kRoll:
    case Mode::kReturn:
      if (situation.other_ball || situation.robot_left) return Mode::kApproach;
      return situation.returning ? Mode::kReturn : Mode::kRoll;
  }
  return Mode::kHold;
}

Planner::Planner(const Parameters& parameters)
    : parameters_(parameters),
      step_(parameters),
      approach_(parameters.approach, parameters.geometry.table_height),
      rest_(parameters.geometry, parameters.approach.leash) {
  if (parameters.disturbance) disturbance_.emplace(*parameters.disturbance);
  plan_.lambda_d = Eigen::VectorXd::Zero(step_.n_lambda_d());
  plan_.x = Eigen::MatrixXd::Zero(step_.n_x(), parameters.N);
  plan_.lambda = Eigen::MatrixXd::Zero(step_.n_lambda(), parameters.N);
  plan_.u = Eigen::MatrixXd::Zero(step_.n_u(), parameters.N);
  plan_.primal_residual = Eigen::VectorXd::Zero(parameters.c3.admm_iterations);
  plan_.ball = 0;
  plan_.ball_target.setZero();
  hold(Eigen::Vector3d::Zero());
}

Cause Planner::hindrance(const BodyInput& ball) const noexcept {
  if (std::isinf(ball.age)) return Cause::kNoVision;
  if (ball.age > parameters_.estimate_timeout) return Cause::kVisionSilent;
  if (!ball.seen) return Cause::kBallNotInView;
  if (!finite(ball.body)) return Cause::kBallNotFinite;
  if (!within(parameters_.approach, ball.body.p_WB.head<2>())) return Cause::kBallOutOfReach;
  return Cause::kNone;
}

Cause Planner::hindrance(const Input& input, int& ball) const noexcept {
  if (std::isinf(input.state_age)) return Cause::kNoState;
  if (input.state_age > kStateTimeout) return Cause::kStateLate;
  if (!input.effector.p_WE.allFinite() || !input.effector.v_WE.allFinite())
    return Cause::kStateNotFinite;
  for (ball = 0; ball < parameters_.model.bodies; ++ball) {
    const Cause cause = hindrance(input.bodies[static_cast<std::size_t>(ball)]);
    if (cause != Cause::kNone) return cause;
  }
  return Cause::kNone;
}

Situation Planner::situation(const Input& input) const noexcept {
  Situation situation{};
  int ball = 0;
  const Cause cause = hindrance(input, ball);
  situation.state_fresh = !of_state(cause);
  situation.balls_at_hand = cause == Cause::kNone;
  situation.robot_left = input.now - followed_ > kLeft;
  situation.start_pose_reached = approach_.settled(input.now);
  situation.returning = phase_ != Phase::kRoll;
  return situation;
}

bool Planner::in_view(const BodyInput& ball) const noexcept {
  const Cause cause = hindrance(ball);
  return cause == Cause::kNone || cause == Cause::kBallOutOfReach;
}

RestInput Planner::rest_input(const Input& input, const scene::Scene& scene,
                              double period) const noexcept {
  const auto worked = static_cast<std::size_t>(ball_);
  const scene::Body& ball = scene.bodies[worked];
  const auto* to = std::get_if<PointTarget>(&input.target);
  return {input.now,
          period,
          input.effector.p_WE,
          input.effector.v_WE,
          in_view(input.bodies[worked]),
          ball.p_WB,
          ball.v_WB,
          to != nullptr ? std::optional<Eigen::Vector2d>(to->point) : std::nullopt};
}

void Planner::decide_rest(const Input& input, const scene::Scene& scene,
                          Situation& known) noexcept {
  const auto worked = static_cast<std::size_t>(ball_);
  const scene::Body& ball = scene.bodies[worked];
  const bool seen = in_view(input.bodies[worked]);
  // what is not seen is where it was: an end effector that stood on it still does
  if (seen) {
    const double gap = gap_between(parameters_.geometry, scene, ball_);
    const double beside = (scene.effector.p_WE - ball.p_WB).head<2>().norm();
    on_ball_ = gap < kOnBallGap && beside < kOnBallBeside * parameters_.geometry.ball_radius;
  }
  const bool working = mode_ == Mode::kRoll || mode_ == Mode::kReturn || mode_ == Mode::kRest;

  const bool hold = std::holds_alternative<HoldTarget>(input.target);
  if (!hold) {
    stopping_since_ = -1.0;
    not_brought_to_rest_ = false;
  } else if (working && stopping_since_ < 0.0) {
    stopping_since_ = input.now;
  }
  if (hold && working && input.now - stopping_since_ > kStoppingLimit) not_brought_to_rest_ = true;

  const auto* to = std::get_if<PointTarget>(&input.target);
  bool delivers = false;
  if (to == nullptr || (delivered_ && *delivered_ != to->point)) {
    delivered_.reset();
  } else if (delivered_) {
    const bool astray = seen && (ball.p_WB.head<2>() - to->point).norm() > kAstray;
    if (!astray) astray_since_ = input.now;
    if (input.now - astray_since_ > kAstrayTime) delivered_.reset();
  }
  if (to != nullptr && !delivered_ && known.balls_at_hand) {
    const Eigen::Vector2d v = ball.v_WB.head<2>();
    const Eigen::Vector2d stops = ball.p_WB.head<2>() + v * v.norm() / kStoppingRate;
    delivers = mode_ == Mode::kRest || (stops - to->point).norm() < kNearPoint;
  }

  const Rest::Stage stage = rest_.stage();
  if (mode_ == Mode::kRest) {
    known.rest_wanted = stage != Rest::Stage::kFailed && (hold || delivers || !known.balls_at_hand);
    known.ball_left = stage == Rest::Stage::kLeft;
  } else if (working) {
    known.rest_wanted =
        hold || delivers || (mode_ == Mode::kRoll && on_ball_ && !known.balls_at_hand);
  } else {
    known.rest_wanted = delivers && mode_ == Mode::kHold;  // it has crept away a little
  }
  const bool there = to != nullptr && seen && (ball.p_WB.head<2>() - to->point).norm() < kAstray;
  if (known.ball_left && delivers && there) {
    delivered_ = to->point;
    astray_since_ = input.now;
  }
  known.hold_requested = input.stopped || (hold && (!working || not_brought_to_rest_)) ||
                         (delivered_ && mode_ == Mode::kHold);
  if (known.robot_left) {
    known.rest_wanted = false;
    known.hold_requested = known.hold_requested || hold;
  }
}

void Planner::tell(const Input& input, const scene::Scene& scene) noexcept {
  int ball = ball_;
  Cause cause = hindrance(input, ball);
  if (cause == Cause::kNone) ball = ball_;
  const bool hold = std::holds_alternative<HoldTarget>(input.target);
  if (!of_state(cause)) {
    if (input.stopped) {
      cause = Cause::kStopped;
    } else if (hold) {
      cause = not_brought_to_rest_ ? Cause::kNotBroughtToRest : Cause::kAsked;
    } else if (cause == Cause::kNone && delivered_) {
      cause = Cause::kAtTarget;
    }
  }
  if (mode_ != activity_.mode || cause != activity_.cause || ball != activity_.ball)
    activity_.since = input.now;
  activity_.mode = mode_;
  activity_.cause = cause;
  activity_.ball = std::min(ball, parameters_.model.bodies - 1);
  const auto meant = static_cast<std::size_t>(activity_.ball);
  activity_.age = of_state(cause) ? input.state_age : input.bodies[meant].age;
  activity_.ball_at = scene.bodies[meant].p_WB.head<2>();
  activity_.ball_speed = scene.bodies[meant].v_WB.head<2>().norm();
}

const Plan& Planner::step(const Input& input, c3::Deadline deadline) noexcept {
  double period = previous_now_ < 0.0 ? 1.0 / parameters_.rate : input.now - previous_now_;
  // a process that was stopped goes on with nothing, least of all with a step of that length
  const bool was_away = period > kLeft;
  if (was_away) period = 1.0 / parameters_.rate;
  previous_now_ = input.now;
  if (input.robot_follows && !was_away) followed_ = input.now;
  if (period_count_ == kPeriodsAveraged) {
    std::copy(periods_.begin() + 1, periods_.end(), periods_.begin());
    --period_count_;
  }
  periods_[static_cast<std::size_t>(period_count_++)] = period;

  const bool in_c3 = mode_ == Mode::kRoll || mode_ == Mode::kReturn;
  scene::Scene scene = estimate(input);
  observe_ball(input, scene, in_c3 && c3_since_ >= 0.0);
  for (scene::Body& ball : scene.bodies) ball.a_WB = disturbance();
  advance_phase(input.now, scene, in_c3 && c3_since_ >= 0.0);
  Situation known = situation(input);
  // one ball for a whole cycle: half-way to another one nothing is gained
  const int worked = ball_;
  const bool cycle_ended = mode_ == Mode::kRoll && phase_ != Phase::kRoll;
  const bool stopping = std::holds_alternative<HoldTarget>(input.target);
  if (known.balls_at_hand && !stopping &&
      (mode_ == Mode::kWait || mode_ == Mode::kHold || cycle_ended))
    ball_ = ball_to_work_on(parameters_.heuristic, parameters_.task, scene, ball_);
  known.other_ball = in_c3 && ball_ != worked;
  decide_rest(input, scene, known);

  const Mode previous = mode_;
  mode_ = next(mode_, known);
  if (mode_ != previous || was_away) {
    if (mode_ == Mode::kApproach || mode_ == Mode::kHold) approach_.begin(input.effector.p_WE);
    if (mode_ == Mode::kRest) rest_.begin(rest_input(input, scene, period));
    if (!in_c3 && mode_ == Mode::kReturn) {
      c3_since_ = input.now;
      phase_ = phase_at(parameters_.heuristic, 0.0);
      if (task_since_ < 0.0) task_since_ = input.now;
    }
    if (in_c3 && !known.balls_at_hand) ++counters_.ball_lost;
  }

  switch (mode_) {
    case Mode::kWait:
      hold(known.state_fresh ? input.effector.p_WE : Eigen::Vector3d::Zero());
      plan_.status = PlanStatus::kFallback;
      break;
    case Mode::kRest:
      rest_.step(rest_input(input, scene, period));
      hold(rest_.reference());
      plan_.v_WE = rest_.velocity();
      plan_.force_E.z() = rest_.press();
      break;
    case Mode::kHold:
      approach_.out_of_the_way({input.now, period, input.effector.p_WE, input.robot_follows});
      hold(approach_.reference());
      break;
    case Mode::kApproach: {
      const Eigen::Vector3d& p_WB = input.bodies[static_cast<std::size_t>(ball_)].body.p_WB;
      approach_.to_ball({input.now, period, input.effector.p_WE, input.robot_follows}, p_WB);
      hold(approach_.reference());
      plan_.v_WE = approach_.velocity();
      plan_.ball_target << target(input, 0.0, scene, ball_), p_WB.z();
      break;
    }
    case Mode::kRoll:
    case Mode::kReturn:
      plan_with_c3(input, scene, deadline);
      break;
  }
  plan_.mode = mode_;
  plan_.ball = ball_;
  tell(input, scene);
  return plan_;
}

void Planner::observe_ball(const Input& input, const scene::Scene& scene, bool in_c3) noexcept {
  if (!disturbance_) return;
  // before C3 has touched it somebody may hold the ball
  if (!in_c3) ball_touched_ = -1.0;
  if (!in_c3 || !in_view(input.bodies[0])) return;
  const double gap = gap_between(parameters_.geometry, scene, 0);
  if (gap < parameters_.disturbance->gap) ball_touched_ = input.now;
  if (ball_touched_ < 0.0) return;
  const double exposure = input.now - input.bodies[0].age;
  disturbance_->observe(exposure, input.bodies[0].body.p_WB.head<2>(),
                        exposure < ball_touched_ + parameters_.disturbance->settle);
}

void Planner::advance_phase(double now, const scene::Scene& scene, bool in_c3) noexcept {
  phase_ = phase_at(parameters_.heuristic, in_c3 ? now - c3_since_ : 0.0);
  if (!in_c3 || phase_ != Phase::kRoll) {
    touched_ = false;
    return;
  }
  const Eigen::Vector3d& p_WB = scene.body(ball_).p_WB;
  const double gap = gap_between(parameters_.geometry, scene, ball_);
  touched_ = touched_ || gap < 0.5 * parameters_.heuristic.return_gap;
  const bool slipped_off =
      (scene.effector.p_WE - p_WB).head<2>().norm() > parameters_.heuristic.roll_reach;
  if ((touched_ && gap > parameters_.heuristic.return_gap) || slipped_off) {
    c3_since_ = now;
    phase_ = Phase::kReturnUp;
  }
}

double Planner::lowered(scene::Scene& scene, std::size_t worked) const noexcept {
  const double ball_height = parameters_.geometry.table_height + parameters_.geometry.ball_radius;
  double rise = scene.bodies[worked].p_WB.z() - ball_height;
  // A ball that is seen too high would be planned to hold the end effector up, and the press on it,
  // some newtons a millimetre, be lost: where the two seem to overlap, the table is lower by as
  // much.
  const double touching =
      parameters_.geometry.ball_radius + parameters_.geometry.end_effector_radius;
  const Eigen::Vector3d above = scene.effector.p_WE - scene.bodies[worked].p_WB;
  const double over_square = touching * touching - above.head<2>().squaredNorm();
  if (over_square > 0.0 && above.z() > 0.0) {
    const double overlap = std::sqrt(over_square) - above.z();
    rise -= std::min(std::max(overlap, 0.0), kHeightDoubt);
  }
  scene.effector.p_WE.z() -= rise;
  for (scene::Body& ball : scene.bodies) ball.p_WB.z() -= rise;
  return rise;
}

Eigen::Vector2d Planner::target(const Input& input, double ahead, const scene::Scene& scene,
                                int ball) const noexcept {
  const Eigen::Vector2d at = scene.body(ball).p_WB.head<2>();
  const double reach = parameters_.heuristic.target_reach;
  if (const auto* circle = std::get_if<task::Circle>(&input.target))
    return paced(at, circle->next(at), std::min(reach, kTargetPace));
  if (const auto* point = std::get_if<PointTarget>(&input.target))
    return paced(at, point->point, std::min(reach, kTargetPace));
  return paced(at, parameters_.task.target(scene, ball, elapsed(input), ahead), reach);
}

double Planner::elapsed(const Input& input) const noexcept {
  return task_since_ < 0.0 ? 0.0 : input.now - task_since_;
}

void Planner::hold(const Eigen::Vector3d& p_WE) noexcept {
  plan_.status = PlanStatus::kOk;
  plan_.p_WE = p_WE;
  plan_.v_WE.setZero();
  plan_.q_WE = tool_orientation(0.0, Eigen::Vector2d::Zero());
  plan_.force_E.setZero();
  plan_.delta_t_c = 0.0;
  plan_.u_c3.setZero();
  plan_.lambda_d.setZero();
  // nothing was predicted: no horizon of an earlier solve goes out with it
  plan_.x.setZero();
  plan_.lambda.setZero();
  plan_.u.setZero();
  plan_.admm_iterations = 0;
  plan_.complementarity_violation = 0.0;
}

scene::Scene Planner::estimate(const Input& input) const noexcept {
  scene::Scene scene{};
  scene.effector.p_WE = input.effector.p_WE;
  scene.effector.v_WE = input.effector.v_WE;
  scene.body_count = parameters_.model.bodies;
  for (int i = 0; i < parameters_.model.bodies; ++i) {
    const BodyInput& seen = input.bodies[static_cast<std::size_t>(i)];
    scene::Body& ball = scene.body(i);
    ball = seen.body;
    // the camera saw the ball a while ago; the arm's state is of now
    if (parameters_.predict_ball) {
      const double age = std::min(seen.age, parameters_.estimate_timeout);
      ball.p_WB = seen.body.p_WB + age * seen.body.v_WB;
    }
  }
  return scene;
}

double Planner::delta_t_c(const Input& input) const noexcept {
  double result = input.solve_time;
  if (parameters_.delta_t_c_source == DeltaTcSource::kPeriod) {
    double sum = 0.0;
    for (int i = 0; i < period_count_; ++i) sum += periods_[static_cast<std::size_t>(i)];
    result = sum / static_cast<double>(period_count_);
  }
  // a stalled process must not turn into a huge step when it comes back
  return std::min(std::max(result, 1e-3), parameters_.dt);
}

void Planner::plan_with_c3(const Input& input, const scene::Scene& scene,
                           c3::Deadline deadline) noexcept {
  const auto worked = static_cast<std::size_t>(ball_);
  scene::Scene x_hat = scene;
  const double rise = parameters_.table_below_ball ? lowered(x_hat, worked) : 0.0;
  const scene::Scene seen = x_hat;
  const Eigen::Vector2d target_now = target(input, 0.0, seen, ball_);
  const Eigen::Vector2d e = target_now - x_hat.bodies[worked].p_WB.head<2>();

  // what is wanted: the balls at their targets and the end effector where the heuristic draws it
  const double ball_height = parameters_.geometry.table_height + parameters_.geometry.ball_radius;
  scene::Scene desired{};
  desired.body_count = x_hat.body_count;

  // Algorithm 3, step 1: x̂
  if (parameters_.separate_overlap) {
    for (int i = 0; i < x_hat.body_count; ++i) {
      scene::Body& ball = x_hat.body(i);
      const Eigen::Vector2d way = target(input, 0.0, seen, i) - ball.p_WB.head<2>();
      model::separate(parameters_.geometry.ball_radius + parameters_.geometry.end_effector_radius,
                      Eigen::Vector3d(way.x(), way.y(), 0.0), x_hat.effector, ball);
    }
  }
  const scene::Body& rolled = x_hat.bodies[worked];
  const bool follows = phase_ != Phase::kRoll && parameters_.heuristic.return_follows;
  Eigen::Vector3d meeting = rolled.p_WB;
  if (phase_ != Phase::kRoll && !follows)
    meeting.head<2>() += rolled_on(rolled, parameters_.heuristic.return_lead);
  const Eigen::Vector3d drawn =
      end_effector_target(parameters_.heuristic, parameters_.geometry, phase_, x_hat.effector.p_WE,
                          meeting, target_now);
  for (int k = 0; k <= parameters_.N; ++k) {
    desired.effector.p_WE = drawn;
    if (follows) {
      desired.effector.p_WE.head<2>() +=
          rolled_on(rolled, parameters_.heuristic.return_lead + k * parameters_.dt);
    }
    for (int i = 0; i < x_hat.body_count; ++i) {
      const auto ball = static_cast<std::size_t>(i);
      const double ahead = k * parameters_.dt;
      desired.bodies[ball].p_WB << target(input, ahead, seen, i), ball_height;
      const Eigen::Vector2d v = std::holds_alternative<ScenarioTarget>(input.target)
                                    ? parameters_.task.velocity(elapsed(input), ahead)
                                    : Eigen::Vector2d(Eigen::Vector2d::Zero());
      desired.bodies[ball].v_WB << v, 0.0;
      // rolling without slipping
      desired.bodies[ball].omega_WB << -v.y() / parameters_.geometry.ball_radius,
          v.x() / parameters_.geometry.ball_radius, 0.0;
    }
    step_.want(k, desired);
  }

  hold(input.effector.p_WE);
  plan_.ball_target << target_now, ball_height;
  plan_.q_WE = tool_orientation(parameters_.tilt, e);
  plan_.delta_t_c = delta_t_c(input);

  // steps 2 to 5
  const StepStatus status =
      step_.step(x_hat, phase_ == Phase::kRoll, ball_, plan_.delta_t_c, deadline);
  const StepResult& result = step_.result();
  if (result.solution != nullptr)
    counters_.branch_nodes += static_cast<std::uint64_t>(result.solution->branch_nodes);
  if (status == StepStatus::kFailed || status == StepStatus::kNoStep) {
    plan_.status = PlanStatus::kFallback;
    ++counters_.fallbacks;
    if (status == StepStatus::kNoStep) ++counters_.lcp_failures;
    return;
  }
  plan_.status = status == StepStatus::kTruncated ? PlanStatus::kTruncated : PlanStatus::kOk;
  if (status == StepStatus::kTruncated) ++counters_.truncated;
  plan_.p_WE = result.p_WE + rise * Eigen::Vector3d::UnitZ();
  plan_.v_WE = result.v_WE;
  const double speed = plan_.v_WE.norm();
  if (speed > parameters_.speed_limit) {
    const Eigen::Vector3d way = plan_.p_WE - input.effector.p_WE;
    if (way.norm() > 0.0)
      plan_.p_WE =
          input.effector.p_WE + way.normalized() * parameters_.speed_limit * plan_.delta_t_c;
    plan_.v_WE *= parameters_.speed_limit / speed;
    ++counters_.speed_clamped;
  }
  plan_.force_E = result.force_E;
  // A plan that stands on the ball does not hold it: over a tenth of a millimetre of gap, which the
  // cameras cannot tell from contact, no force acts.
  if (phase_ == Phase::kRoll) plan_.force_E.z() += parameters_.heuristic.roll_press;
  plan_.lambda_d = result.lambda_d;
  plan_.u_c3 = result.u_c3;
  const c3::Solution& solution = *result.solution;
  const Eigen::Index n_x = plan_.x.rows(), n_lambda = plan_.lambda.rows();
  plan_.x = solution.z.topRows(n_x);
  plan_.lambda = result.force_scale * solution.z.middleRows(n_x, n_lambda);
  plan_.u = result.input_scale * solution.z.middleRows(n_x + n_lambda, plan_.u.rows());
  plan_.admm_iterations = solution.iterations;
  plan_.primal_residual = solution.primal_residual;
  plan_.complementarity_violation = solution.complementarity_violation;
}

}  // namespace c3rt::planner
