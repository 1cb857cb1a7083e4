#include "tests/support/closed_loop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "controller/base/time.hpp"
#include "plant_emulator/start.hpp"

namespace c3rt::test {
namespace {
using base::nanoseconds;
}  // namespace

ClosedLoop::ClosedLoop(const config::Scenario& scenario, std::uint64_t seed)
    : scenario_(scenario),
      plant_(plant::drawn_start(scenario.plant, seed)),
      sensor_(scenario.vision.emulated, seed),
      pushes_(plant::drawn_pushes(scenario.plant.pushes,
                                  static_cast<int>(scenario.plant.world.balls.size()), seed)),
      arm_(scenario.impedance.arm),
      heard_(plant_.state()) {
  restart_vision();
  restart_planner();
  restart_impedance();
}

void ClosedLoop::restart_impedance() {
  impedance_.emplace(scenario_.impedance, model::Arm(scenario_.impedance.arm));
}

void ClosedLoop::restart_planner() {
  planner_.emplace(scenario_.planner);
  stopped_ = false;
}

void ClosedLoop::restart_vision() {
  estimators_.clear();
  for (const plant::BallParameters& ball : scenario_.plant.world.balls)
    estimators_.emplace_back(scenario_.vision.estimator, ball.radius);
}

void ClosedLoop::stop() {
  plant_.request_stop();
  stop_ = stopped_ = true;
}

void ClosedLoop::recover() {
  plant_.request_recovery();
  recover_ = true;
  stopped_ = false;
}

void ClosedLoop::step_1ms() {
  const plant::State& state = plant_.state();
  const auto due = [&](std::uint64_t count, double rate) {
    return now_ns_ >= nanoseconds(static_cast<double>(count) / rate);
  };

  if (running.plant && !lost_state) {
    state_ns_ = now_ns_;
    heard_ = state;
  }
  if (due(exposures_, scenario_.vision.rate) && ++exposures_ && running.vision && running.plant) {
    Estimates estimates;
    for (std::size_t i = 0; i < estimators_.size(); ++i) {
      vision::Measurement measurement;
      measurement.exposure_ns = now_ns_;
      measurement.found = in_view_;
      measurement.p_WB = sensor_.measure(state.balls[i].p_WB);
      estimates.push_back(estimators_[i].step(measurement));
    }
    estimates_.push_back({now_ns_ + nanoseconds(scenario_.timing.vision_latency_s), estimates});
  }
  while (!estimates_.empty() && estimates_.front().time_ns <= now_ns_) {
    newest_estimates_ = estimates_.front().value;
    estimates_.pop_front();
  }

  if (due(plans_made_, scenario_.planner.rate)) {
    ++plans_made_;
    if (running.planner) plan_now();
  }
  while (!plans_.empty() && plans_.front().time_ns <= now_ns_) {
    newest_plan_ = plans_.front().value;
    has_plan_ = true;
    plans_.pop_front();
  }

  if (running.impedance) control();
  if (running.plant) {
    for (; pushed_ < pushes_.size() && pushes_[pushed_].time <= plant_.state().time; ++pushed_)
      plant_.push_ball(pushes_[pushed_].ball, pushes_[pushed_].impulse);
    plant_.step_1ms();
    const double fastest =
        (state.dq.array().abs() / scenario_.plant.limits.dq_max.array()).maxCoeff();
    fastest_joint_ = std::max(fastest_joint_, fastest);
  }
  now_ns_ += 1'000'000;
}

void ClosedLoop::control() {
  const plant::State& state = heard_;
  impedance::Input input;
  input.now_ns = now_ns_;
  input.has_state = true;
  input.session_id = 1;
  input.state_stamp_ns = state_ns_;
  input.q = state.q;
  input.dq = state.dq;
  if (nan_state) input.q[0] = std::nan("");
  input.robot_moves = state.mode == plant::Mode::kIdle || state.mode == plant::Mode::kMove;
  input.has_plan = has_plan_;
  input.plan = newest_plan_;
  input.stop = std::exchange(stop_, false);
  input.recover = std::exchange(recover_, false);
  output_ = impedance_->step(input);
  if (output_.commands) plant_.set_command(output_.tau, ++cycle_, now_ns_);
}

void ClosedLoop::plan_now() {
  const plant::State& state = heard_;
  arm_.update(state.q, state.dq, arm_state_);
  planner::Input input{};
  input.now = time();
  input.state_age = 1e-9 * static_cast<double>(now_ns_ - state_ns_);
  input.stopped = stopped_;
  input.robot_follows = state.mode == plant::Mode::kMove && output_.mode == impedance::Mode::kTrack;
  input.effector.p_WE = arm_state_.X_WE.translation();
  if (nan_state) input.effector.p_WE.x() = std::nan("");
  input.effector.v_WE = arm_state_.V_WE.head<3>();
  for (std::size_t i = 0; i < newest_estimates_.size(); ++i) {
    const vision::Estimate& seen = newest_estimates_[i];
    input.bodies[i] = {seen.valid,
                       1e-9 * static_cast<double>(now_ns_ - seen.exposure_ns),
                       {seen.p_WB, seen.q_WB, seen.v_WB, seen.omega_WB}};
  }
  input.target = target_;
  input.solve_time = scenario_.timing.solve_time_s;
  plan_ = planner_->step(input);
  impedance::Plan plan;
  plan.session_id = 1;
  plan.stamp_ns = now_ns_ + nanoseconds(std::max(scenario_.timing.solve_time_s,
                                                 scenario_.planner.publish_delay));
  plan.valid_until_ns = plan.stamp_ns + nanoseconds(scenario_.planner.valid_for);
  plan.status = plan_.status == planner::PlanStatus::kFallback ? impedance::PlanStatus::kFallback
                                                               : impedance::PlanStatus::kOk;
  plan.knots[0].p_WE = plan_.p_WE;
  plan.knots[0].v_WE = plan_.v_WE;
  plan.knots[0].q_WE = plan_.q_WE;
  plan.knots[0].force_E = plan_.force_E;
  plan.knot_count = 1;
  plan.knots[0].time_ns = plan.stamp_ns + nanoseconds(plan_.delta_t_c);
  if (spoil_plan) spoil_plan(plan);
  if (plan_.mode != planner::Mode::kWait) plans_.push_back({plan.stamp_ns, plan});
}

}  // namespace c3rt::test
